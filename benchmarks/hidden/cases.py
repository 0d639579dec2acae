"""The cases: what is hidden, on which machine, in which recordings, and by which road the model came."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from itertools import product
from types import MappingProxyType
from typing import NamedTuple

from benchmarks.hidden.plants import EVENTS, PLANTED, STRANGERS, TAKEN_OUT, kind_of
from benchmarks.injected import FAILURES
from benchmarks.measure import numbers
from drivers.virtual_rig.dice import dice

ROADS = ("healthy", "same", "shipped")
RUNS = (  # to search in, and held out
    (("FS-20", "FS-5", "CS-10", "ES-20"), ("CS-5", "ES-10")),
    (("FS-10", "CS-20", "ES-5", "FS-20"), ("ES-20", "CS-10")),
    (("ES-10", "FS-5", "CS-20", "FS-20"), ("CS-5", "FS-10")),
)
ODD = 2  # the run in which something is wrong, where it is in one
PAIRS = (
    ("friction_thinning", "motor_heat"), ("churning", "base_drift"), ("sensor_lag", "support_yield"),
    ("local_heat", "nut_speed_exponent"), ("ambient_gradient", "expansion_error"), ("motor_heat", "churning"),
    ("bearing_speed_exponent", "channel_offset"), ("local_heat_driving", "bar_expansion"),
    ("base_drift", "friction_thinning"), ("nut_speed_exponent", "board_drift"), ("churning", "support_yield"),
)  # fmt: skip
TRIPLES = (
    ("friction_thinning", "motor_heat", "support_yield"), ("churning", "base_drift", "channel_offset"),
    ("local_heat", "sensor_lag", "ambient_gradient"), ("motor_heat", "nut_speed_exponent", "board_drift"),
    ("base_drift", "expansion_error", "local_heat_driving"), ("churning", "bearing_speed_exponent", "channel_gain"),
    ("ambient_gradient", "friction_thinning", "bar_expansion"), ("local_heat_driving", "radiation", "support_yield"),
    ("motor_heat", "local_heat", "probe_expansion"), ("churning", "ambient_gradient", "sensor_lag"),
)  # fmt: skip
JUDGING, FAR, DEV = 121, 100, 20  # the first machine that judges, from road to road, how many are for setting
FIRST_SEED, FIRST_DEV_SEED = 100_000, 50_000


class Hidden(NamedTuple):
    """What is hidden in a case.

    plant     strengths of effects planted in the rig;   taken: effects taken out of the model
    event     what is planted begins within one run, and is in no other
    speed, position, ambient_K  factors and shift of inputs of one run;   shift_mm: of the position in all runs
    fault     of one thermometer in one run (injected.FAILURES);   reading: of a drawn shape, in all runs
    """

    plant: Mapping[str, float] = MappingProxyType({})
    taken: tuple[str, ...] = ()
    event: bool = False
    speed: float = 1.0
    position: float = 1.0
    ambient_K: float = 0.0
    shift_mm: float = 0.0
    fault: str = ""
    reading: bool = False

    @property
    def names(self) -> tuple[str, ...]:
        """Effects that the model lacks."""
        return (*self.plant, *self.taken)


def _effects(names: Sequence[str], strength: float = 1.0) -> Hidden:
    plant = {name: strength for name in names if name not in TAKEN_OUT}
    return Hidden(plant, tuple(name for name in names if name in TAKEN_OUT))


EVERY = (*PLANTED, *TAKEN_OUT)
HEATS = tuple(name for name in EVERY if kind_of(name) == "heat")
WRONG = (Hidden(speed=1.2), Hidden(speed=1.2, position=1.2), Hidden(ambient_K=3.0))


class Row(NamedTuple):
    """A row of the study: cases a road in all, and in the smaller study; what is hidden in the n-th."""

    whole: int
    small: int
    hidden: Callable[[int], Hidden]


ROWS = {
    "one": Row(66, 10, lambda n: _effects([EVERY[n % len(EVERY)]])),
    "half": Row(18, 1, lambda n: _effects([PLANTED[n % len(PLANTED)]], 0.5)),
    "double": Row(18, 1, lambda n: _effects([PLANTED[n % len(PLANTED)]], 2.0)),
    "none": Row(40, 6, lambda n: Hidden()),
    "two": Row(22, 2, lambda n: _effects(PAIRS[n % len(PAIRS)])),
    "three": Row(20, 1, lambda n: _effects(TRIPLES[n % len(TRIPLES)])),
    "stranger": Row(20, 3, lambda n: _effects([list(STRANGERS)[n % len(STRANGERS)]])),
    "event": Row(20, 2, lambda n: Hidden(EVENTS[n % len(EVENTS)], event=True)),
    "label": Row(21, 2, lambda n: WRONG[n % len(WRONG)]),
    "sensor": Row(20, 2, lambda n: Hidden(fault=list(FAILURES)[n % len(FAILURES)])),
    "shifted": Row(20, 1, lambda n: Hidden(shift_mm=40.0)),
    "drawn": Row(40, 2, lambda n: _effects(["drawn_heat"])),
    "bare": Row(28, 1, lambda n: _effects([HEATS[n % len(HEATS)]])),
    "reading": Row(20, 2, lambda n: Hidden(reading=True)),
}
MOVED_ON = 7  # from road to road, so that the smaller study meets every effect on one of them
HELD_OUT = ("one", "half", "double", "two", "three", "drawn", "bare", "reading")  # the error afterwards is a matter
SIX = "label"  # is told by the other runs, and there are six


@dataclass(frozen=True)
class Case:
    """The n-th case of a row on a road; `dev`: on the machines on which thresholds are set."""

    row: str
    road: str
    number: int
    dev: bool = False

    @property
    def machine(self) -> int:
        """Its machine."""
        return 1 + self.number % DEV if self.dev else JUDGING + FAR * ROADS.index(self.road) + self.number

    @property
    def seed(self) -> int:
        """Of sensors, weather and places: no other case has it."""
        table = list(ROWS).index(self.row) * len(ROADS) + ROADS.index(self.road)
        return (FIRST_DEV_SEED if self.dev else FIRST_SEED) + 1000 * table + self.number

    def drawn(self, what: str, choices: int) -> int:
        """One of some choices, by the seed."""
        return int(dice(self.seed, what).integers(choices))

    @property
    def hidden(self) -> Hidden:
        """What is hidden."""
        return ROWS[self.row].hidden(self.number + MOVED_ON * ROADS.index(self.road))

    @property
    def runs(self) -> tuple[tuple[str, ...], tuple[str, ...]]:
        """Experiments to search in, and held out."""
        used, apart = RUNS[self.drawn("runs", len(RUNS))]
        if self.row == SIX:
            return (*used, *apart), ()
        return used, apart if self.row in HELD_OUT else ()

    def __str__(self) -> str:
        return f"{self.row} {self.road} {self.number}{' dev' if self.dev else ''}"


def asked(words: Sequence[str]) -> list[Case]:
    """The cases that words ask for; the smaller study without any."""
    flags, asked_for = {"whole", "dev", "alone"}, {n for word in words for n in numbers(word)}
    if unknown := {word for word in words if word not in {*ROWS, *ROADS, *flags} and not numbers(word)}:
        known = ", ".join((*ROWS, *ROADS, *sorted(flags)))
        raise SystemExit(f"hidden: what is {', '.join(sorted(unknown))}? Cases like 0-9, or {known}")
    rows, roads = ([each for each in names if each in words] or list(names) for names in (ROWS, ROADS))
    return [
        Case(row, road, n, "dev" in words)
        for row, road in product(rows, roads)
        for n in range(ROWS[row].whole)
        if (n in asked_for if asked_for else "whole" in words or n < ROWS[row].small)
    ]
