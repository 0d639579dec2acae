"""The two support bearings: where they sit, their friction, and the housings through which heat leaves to the base."""

from collections.abc import Iterator
from functools import lru_cache
from types import SimpleNamespace
from typing import Any, ClassVar

import numpy as np

from estimator.effect import Effect, Param, needed
from estimator.inputs.inputs import Inputs
from estimator.record import Array
from estimator.rig import Rig
from estimator.screw import Screw, Support
from estimator.terms import SCREW, Heat, Link, Store, Term

BEARINGS = ("anchor", "free")
SEATS = ("anchor_seat", "free_seat")


def under_bearing(rig: Rig, support: str, seat: SimpleNamespace | None = None) -> Array:
    """Share of a heat put in by a bearing that falls to each cell, (..., cells); sums to 1.

    seat  parameters of the effect for it, None: the bearing is where the rig file says; a column of each, (rows, 1),
          gives a row for each
    """
    screw, bearing = rig.the_screw(), rig.the_support(support)
    shift, width = (0.0, 1.0) if seat is None else (seat.shift, seat.width)
    return _share(screw, bearing, _frozen(shift), _frozen(width))


Frozen = tuple[bytes, str, tuple[int, ...]]


def _frozen(value: Any) -> Frozen:
    """A number or a column as something that is found again."""
    array = np.asarray(value)
    return array.tobytes(), array.dtype.char, array.shape


@lru_cache
def _share(screw: Screw, bearing: Support, *seat: Frozen) -> Array:
    """The share of a bearing by shift and width: asked for at every tick."""
    shift, width = (np.frombuffer(number, kind).reshape(shape) for number, kind, shape in seat)
    at_mm, half_mm = bearing.at_mm + shift, bearing.width_mm / 2 * width
    under = screw.overlap(np.squeeze(at_mm - half_mm), np.squeeze(at_mm + half_mm))
    share = np.asarray(under / under.sum(axis=-1, keepdims=True))
    share.flags.writeable = False
    return share


def seat_of(p: SimpleNamespace, support: str) -> SimpleNamespace | None:
    """The seat of a bearing, among the parameters of an effect that `scales` it; None where the model has no such."""
    seat: SimpleNamespace | None = getattr(p, f"{support}_seat", None)
    return seat


class BearingSeat(Effect):
    """Friction enters the screw, and heat leaves to the housing, at another place and width than the rig file's."""

    support: ClassVar[str]
    shift = Param(0.0, "mm", lo=-10.0, hi=10.0, null=0.0, sd=1.5, source="mounting, and drawings to the nearest mm")
    width = Param(
        1.0, "1", lo=0.3, hi=2.0, null=1.0, sd=0.25, source="inner rings, spacer and nut: which of them touch"
    )

    def terms(self, p: SimpleNamespace, u: Inputs, rig: Rig) -> Iterator[Term]:
        rig.the_support(self.support)
        return iter(())


class AnchorSeat(BearingSeat):
    """The anchor bearing sits on another place and width of the screw than the rig file says.

    x = x_rig + shift, b = width b_rig, of the heat of friction and of the heat that leaves to the housing
    """

    support = "anchor"
    trace = "Thermometers at the anchor too warm and too cold side by side while driving."


class FreeSeat(BearingSeat):
    """The free-side bearing sits on another place and width of the screw than the rig file says.

    x = x_rig + shift, b = width b_rig, of the heat of friction and of the heat that leaves to the housing
    """

    support = "free"
    trace = "Thermometers at the free bearing too warm and too cold side by side while driving."


class BearingFriction(Effect):
    """Friction of a bearing heats the screw, spread over the bearing's width, and its housing."""

    support: ClassVar[str]
    power = Param(30.0, "W", lo=0.0, hi=2000.0, null=0.0, sd=12.0, source="41 W for a pair at 1667 rpm, Palmgren")
    power_housing = Param(15.0, "W", lo=0.0, hi=2000.0, null=0.0, sd=10.0, source="the outer ring's share")
    n = Param(1.35, "1", lo=0.5, hi=2.0, sd=0.1, source="2.5 / 6 / 15 / 41 W at 208 / 417 / 833 / 1667 rpm: 1.3 - 1.4")
    noise = Param(0.3, "sqrt(s)", lo=0.0, hi=10.0, fixed=True, source="tuned")

    def terms(self, p: SimpleNamespace, u: Inputs, rig: Rig) -> Iterator[Term]:
        relative = u.speed_law(rig.the_screw(), p.n)
        into_screw, into_housing = p.power * relative, p.power_housing * relative
        yield Heat(
            SCREW,
            into_screw,
            over=under_bearing(rig, self.support, seat_of(p, self.support)),
            noise=p.noise * into_screw,
        )
        yield Heat(f"{self.support}_housing", into_housing, noise=p.noise * into_housing, spare=True)


class AnchorFriction(BearingFriction):
    """Friction of the anchor bearing heats the screw at the motor side, and the housing.

    q = P |omega / omega_ref|^n, spread over the bearing's width;   q_housing = P_housing |omega / omega_ref|^n

    P_housing  heat into the housing, W: gone where the housing is not modelled as a body
    """

    scales = ("anchor_seat",)
    support = "anchor"
    trace = "The anchor's side is too cold from the first minute of a drive on."


class FreeFriction(BearingFriction):
    """Friction of the free-side bearing heats the screw near the far end, and the housing.

    q = P |omega / omega_ref|^n, spread over the bearing's width;   q_housing = P_housing |omega / omega_ref|^n

    P_housing  heat into the housing, W: gone where the housing is not modelled as a body
    """

    scales = ("free_seat",)
    support = "free"
    trace = "The free side is too cold from the first minute of a drive on."
    power = Param(15.0, "W", lo=0.0, hi=2000.0, null=0.0, sd=8.0, source="up to 41 W for a pair at 1667 rpm, Palmgren")
    power_housing = Param(8.0, "W", lo=0.0, hi=2000.0, null=0.0, sd=6.0, source="the outer ring's share")


class BearingHousing(Effect):
    """A housing is a body between the screw under the bearing and the base."""

    support: ClassVar[str]
    capacity = Param(3000.0, "J/K", lo=100.0, hi=50000.0, sd=800.0, source="1800 - 4600 computed from drawings")
    g = Param(2.0, "W/K", lo=0.0, hi=50.0, null=0.0, sd=0.8, source="bearing 1 - 3 W/K")
    g_base = Param(6.0, "W/K", lo=0.0, hi=500.0, sd=4.0, source="bolted joint, by fit")
    noise = Param(1.0, "W/sqrt(Hz)", lo=0.01, hi=100.0, fixed=True, source="tuned")

    def terms(self, p: SimpleNamespace, u: Inputs, rig: Rig) -> Iterator[Term]:
        node, shells = f"{self.support}_housing", p.housing_shells
        capacity = p.capacity * (1.0 - shells.share) if shells else p.capacity
        yield Store(node, capacity, p.noise, start=f"{self.support}_bracket", shown=shells is None)
        yield Link(SCREW, node, p.g * under_bearing(rig, self.support, seat_of(p, self.support)))
        if shells is None:
            yield Link(node, "base", p.g_base)


class AnchorHousing(BearingHousing):
    """The anchor bearing's housing stores heat and conducts it to the machine base.

    C dT/dt = q_housing + g (T_screw - T) - g_base (T - T_base)      with housing_shells the shell has g_base
    """

    scales = ("anchor_seat", "housing_shells")
    support = "anchor"
    trace = "The first 100 mm at the anchor: fast at the stop, slow later."


class FreeHousing(BearingHousing):
    """The free-side bearing's housing stores heat and conducts it to the machine base.

    C dT/dt = q_housing + g (T_screw - T) - g_base (T - T_base)      with housing_shells the shell has g_base
    """

    scales = ("free_seat", "housing_shells")
    support = "free"
    trace = "The first 100 mm at the free bearing: fast at the stop, slow later."
    capacity = Param(2500.0, "J/K", lo=100.0, hi=50000.0, sd=800.0, source="1800 - 4600 computed from drawings")


class HousingShells(Effect):
    """A bearing's housing is two bodies: rings and what they sit in, which friction heats, and behind a joint the rest.

    (1 - share) C dT/dt = q_housing - g (T - T_screw) - (T - T_shell) / r      C, g and g_base of each housing
    share C dT_shell/dt = (T - T_shell) / r - g_base (T_shell - T_base)

    The rings are warmer than the rest while driving, and give that to the screw within minutes of a stop.
    Fitted, and never searched for: no parameter has a null
    """

    trace = "After a stop the ends cool slower than their housings do, for some minutes."
    scales = ("anchor_housing", "free_housing")
    share = Param(0.75, "1", lo=0.1, hi=0.95, sd=0.12, source="rings of 0.5 - 1 kg in a housing of 4 - 9 kg")
    r = Param(0.08, "K/W", lo=0.003, hi=0.6, sd=0.06, source="outer ring in its bore, and some cm of iron")

    def terms(self, p: SimpleNamespace, u: Inputs, rig: Rig) -> Iterator[Term]:
        held = [support for support in BEARINGS if getattr(p, f"{support}_housing") is not None]
        for support in held or BEARINGS:
            housing = needed(p, f"{support}_housing")
            shell = f"{support}_shell"
            yield Store(shell, p.share * housing.capacity, housing.noise, start=f"{support}_bracket")
            yield Link(f"{support}_housing", shell, 1.0 / p.r)
            yield Link(shell, "base", housing.g_base)
