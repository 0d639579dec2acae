"""The vocabulary of the physics: all that an effect may say about the rig.

A node is named by a string. `"screw"` is the line of all cells of the screw: its values are vectors (..., cells). Any
other node is a body with one temperature, or, in a Link, a measured input such as "ambient" or "start". Values are
scalars or arrays that broadcast to (ticks, 1) for a body and (ticks, cells) for the screw.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

SCREW = "screw"
ELONGATION = "elongation"  # in the weights of a Read: growth of the measured span, um
START = "start"  # where a Link may end: the temperature at which the run started


@dataclass(frozen=True, eq=False)
class Store:
    """The node stores heat, and so is a state.

    capacity  J/K
    noise     W/sqrt(Hz) of heat that no effect describes, independent from cell to cell; required, above 0
    start     measured input that tells a body's temperature at the start of a run, where the rig has one
    shown     whether that input also shows how the body goes on
    """

    node: str
    capacity: Any
    noise: Any
    start: str | None = None
    shown: bool = True


@dataclass(frozen=True, eq=False)
class Chain:
    """Neighbouring cells of a line conduct: g (T[i] - T[i+1]) W; g in W/K."""

    node: str
    g: Any


@dataclass(frozen=True, eq=False)
class Link:
    """Heat g over (T_a - T_b) W flows from a to b; g in W/K, per cell where a node is the screw.

    b     may be a measured input, or "start": the temperature at which the run started
    over  share of g that each cell has, (cells,) or (ticks, cells): u.coverage or u.bare as they stand, or what the
          nut's balls cover, which are multiplied out for a few regimes instead of each tick
    """

    a: str
    b: str
    g: Any
    over: Any = 1.0


@dataclass(frozen=True, eq=False)
class Heat:
    """q W put into the node, or q over: spread over the cells of the screw.

    over   share of q that each cell gets, (cells,) or (ticks, cells); where it is an input of the rig as it stands
           (u.coverage), a whole recording's worth of it is projected on the states once
    noise  W/sqrt(Hz): the part of this heat that scatters, spread as q is, in step over all cells
    spare  where no effect stores the node the heat leaves the rig unseen; else that is an error
    """

    node: str
    q: Any
    over: Any = 1.0
    noise: Any = 0.0
    spare: bool = False


@dataclass(frozen=True)
class Spot:
    """In the weights of a Read: `weight` times the screw's temperature at a place, mm, in its section.

        T + deep d2T/dx2

    deep  mm2: 0 for the mean of the section, Screw.bore_mm2 at the wall of the bore
    """

    at_mm: float
    weight: Any = 1.0
    deep: Any = 0.0


@dataclass(frozen=True, eq=False)
class Read:
    """A channel reads sum(w T) + offset: degC, or um for the displacement.

    weights    node -> weight (1; a Spot or (cells,) for the screw), or ELONGATION -> 1
    sd         scatter of one reading, in the channel's unit; a channel's several Reads add, their scatter in squares
    offset     what the reading shows beside the temperatures, in the channel's unit
    zero_sd    above 0: the reading's zero is unknown and becomes a state, with this sd at the start ...
    zero_walk  ... that wanders, in unit/sqrt(s)
    gain_sd    sd of the share by which the channel shows too much of its rise since the start
    """

    channel: str
    weights: Mapping[str, Any] = field(default_factory=dict)
    sd: Any = 1.0
    offset: Any = 0.0
    zero_sd: Any = 0.0
    zero_walk: Any = 0.0
    gain_sd: Any = 0.0


@dataclass(frozen=True, eq=False)
class Lag:
    """The channel follows its spot with a first-order lag of tau s, starting in equilibrium.

    noise   how far the lag itself is off: sd of the reading as a multiple of what the lag takes from it
    own_sd  sd of the share by which this channel's own lag is longer or shorter
    """

    channel: str
    tau: Any
    noise: Any = 0.0
    own_sd: Any = 0.0


@dataclass(frozen=True, eq=False)
class Expand:
    """The screw expands by (1 + error) times what the rig file says."""

    error: Any


@dataclass(frozen=True, eq=False)
class Hold:
    """The bearing at `by_mm` holds the screw along its axis as the anchor bearing at `anchor_mm` does.

    Of the growth that the screw between them would have were it free,
    squeeze  is the share that is pressed back, evenly along what lies between them
    give     the share by which the anchor bearing gives way, away from the other one
    """

    anchor_mm: float
    by_mm: float
    squeeze: Any
    give: Any


@dataclass(frozen=True, eq=False)
class Shift:
    """What links to a measured input feel is not what its sensor shows: input + by over.

    by    in the input's unit
    over  1: wherever a link ends at the input; (cells,) along the screw, and nothing at bodies. Never of parameters
    """

    input: str
    by: Any
    over: Any = 1.0


Term = Store | Chain | Link | Heat | Read | Lag | Expand | Hold | Shift
OF_READINGS = (Read, Lag, Expand, Hold)  # what says how channels read
OF_TICKS = (Heat, Read, Shift)  # what is said of each tick: the others say something of a regime, or of the run
