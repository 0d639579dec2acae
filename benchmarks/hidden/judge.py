"""What counts as right.

An effect that a model has under another name, as one of its own parameters (plants.OWN: the nut's speed exponent is
`nut_friction.n`), is found too where that parameter carries it: its value is nearer to the truth than half of what was
planted. With a model that was fitted to a healthy machine the parameter must be named all the same; by the other roads,
where all parameters are another machine's or were fitted to the fault, it is right that nothing more is missing.
What a machine has by a law of its own (plants.BY_LAW) is there although nobody planted it; so is an effect for a
parameter that the model holds fixed, or has not, and that is another one on this machine by half of what would be
planted at least. To name such a thing is right where a parameter carries what is hidden.
A thermometer that is shifted in all runs is also found if it is said to be broken in most of them, and left out.
"""

from collections import defaultdict
from collections.abc import Callable, Mapping

from benchmarks import paper_rig
from benchmarks.hidden.cases import ODD, Case
from benchmarks.hidden.drawn_reading import ALL as ALL_READ, drawn_reading
from benchmarks.hidden.outcome import Outcome
from benchmarks.hidden.plants import BY_LAW, DRAWN, OWN, STRANGERS, kind_of
from drivers.virtual_rig.machine.drawn import drawn
from drivers.virtual_rig.machine.heaters import local_place
from drivers.virtual_rig.population.draw import machine
from drivers.virtual_rig.sensors.telemeter import telemeter
from estimator.events.event import LOOSE, READING
from estimator.missing_effect.wrong_input import ALL

NEAR_MM, NEAR_S, NEAR_SHIFT_MM = 60.0, 600.0, 10.0
MOST_TIED = 3
CARRIED = 0.5  # of what was planted, by which a parameter that carries it may be off
SHIFTED = ("channel_offset", "channel_gain")
WORTH_UM = 1.0  # an effect that costs more must not be taken for one of the other kind


def right(case: Case, out: Outcome) -> bool:
    """Whether a case came out as it should."""
    return not out.error and RULES[case.row](case, out)


def carried(case: Case, out: Outcome, name: str) -> bool:
    """Whether the model's own parameters carry an effect of this name in one of the models that the verdict leaves."""
    one = machine(case.machine)
    return name in OWN and all(_close(case, out, name, path, *of(one)) for path, of in OWN[name].items())


def _close(case: Case, out: Outcome, name: str, path: str, without: float, each: float) -> bool:
    planted = each * case.hidden.plant.get(name, 0.0)
    return any(abs(value - without - planted) < CARRIED * abs(planted) for value in out.values.get(path, ()))


def is_named(case: Case, out: Outcome, name: str) -> bool:
    """Whether an effect that is hidden is said, or the parameter of the model that carries it."""
    holders = {path.partition(".")[0] for path in OWN.get(name, ())}
    return name in out.said or (bool(holders & {*out.own}) and carried(case, out, name))


def is_found(case: Case, out: Outcome, name: str) -> bool:
    """Whether an effect that is hidden is named, or need not be: a parameter carries it, or the channel is left out."""
    held = case.road != "healthy" and carried(case, out, name)
    return is_named(case, out, name) or held or _left_out(case, out, name)


def _left_out(case: Case, out: Outcome, name: str) -> bool:
    """Whether the thermometer that is shifted is said to be broken in most of the runs."""
    if name not in SHIFTED:
        return False
    places = telemeter(case.seed, defaultdict(float, {name: 1.0}), machine(case.machine).sensors).places
    broken = [channel for _, channel in out.faulty]
    return broken.count(paper_rig.rig().thermometers[int(places[name]) - 1]) > len(case.runs[0]) / 2


def false_effects(case: Case, out: Outcome) -> list[str]:
    """Named effects that are neither hidden, nor the model's own, nor there because of the machine."""
    there = {*case.hidden.names, *out.own, *_by_machine(case, out)}
    return [name for name in out.said if name not in there]


def _by_machine(case: Case, out: Outcome) -> set[str]:
    one = machine(case.machine)
    apart = {name: [(out.held.get(path), *of(one)) for path, of in paths.items()] for name, paths in OWN.items()}
    other = {
        name
        for name, values in apart.items()
        if any(held is not None and abs(true - held) >= CARRIED * abs(each) for held, true, each in values)
    }
    return other | {BY_LAW[law] for law in one.laws if law in BY_LAW}


def confused(case: Case, out: Outcome) -> bool:
    """Whether heat was taken for a wrong reading, or the reverse."""
    return out.first in false_effects(case, out) and kind_of(out.first) != kind_of(case.hidden.names[0])


def costly(out: Outcome) -> bool:
    """Whether without what is hidden the elongation is off by more than can be let pass."""
    return len(out.before) > 1 and out.before[1] > WORTH_UM


def _one(case: Case, out: Outcome) -> bool:
    (name,) = case.hidden.names
    false = false_effects(case, out)
    if out.verdict == "nothing_missing" or (out.said and not false):
        return is_found(case, out, name)
    too_many = len(out.said) > MOST_TIED or (out.verdict == "effects" and false)
    return is_named(case, out, name) and not too_many


def _none(case: Case, out: Outcome) -> bool:
    """Nothing, or what is true of the machine; in a tie one of those is enough."""
    return out.verdict == "nothing_missing" or len(false_effects(case, out)) < len(out.said)


def _several(least: int) -> Callable[[Case, Outcome], bool]:
    return lambda case, out: sum(is_found(case, out, name) for name in case.hidden.names) >= least


def _stranger(case: Case, out: Outcome) -> bool:
    (name,) = case.hidden.names
    near = out.place_mm is not None and abs(out.place_mm - local_place(case.seed, name)) <= NEAR_MM
    follows = {out.follows, *out.as_well} & {*STRANGERS[name]}
    return out.verdict == "nothing_in_catalogue" and near and bool(follows)


def _drawn(case: Case, out: Outcome) -> bool:
    """Composed where it is: what it follows is judged apart (`follows_drawn`)."""
    return bool(out.composed) and out.place_mm is not None and abs(out.place_mm - drawn(case.seed).place_mm) <= NEAR_MM


def follows_drawn(case: Case, out: Outcome) -> bool:
    """Whether a composed effect is right, and follows what it should, or may as well."""
    return _drawn(case, out) and bool({out.follows, *out.as_well} & {*DRAWN[drawn(case.seed).kind]})


def gained(out: Outcome) -> list[float]:
    """Which share of what the true effect takes off the error held out is taken off, of temperature and elongation."""
    errors = zip(out.before, out.after, out.knowing, strict=True) if out.knowing and out.after else ()
    return [(before - after) / (before - knowing) for before, after, knowing in errors if before > 1.2 * knowing]


def _bare(case: Case, out: Outcome) -> bool:
    """Half of the gain at least; all of it where the true effect has none."""
    return min(gained(out), default=1.0) >= CARRIED


def _reading(case: Case, out: Outcome) -> bool:
    """The channel, and what its shift follows, or that as well."""
    one = drawn_reading(case.seed, paper_rig.rig())
    channel = "" if one.channel == ALL_READ else one.channel
    return any(found[0] == channel and {*found[1:]} & {*one.follows} for found in out.misread)


def _event(case: Case, out: Outcome) -> bool:
    """A time of heat: all that is planted so is."""
    run, onset_s = out.happened or ("", 0.0)
    heats = [(name, when) for name, when, kind in out.began if kind not in (READING, LOOSE)]
    return any(name == run and abs(when - onset_s) <= NEAR_S for name, when in heats)


def _label(case: Case, out: Outcome) -> bool:
    hidden, run = case.hidden, f"{case.runs[0][ODD]}.blf"
    signal = "ambient" if hidden.ambient_K else "speed" if hidden.position == 1.0 else "speed and position"
    return out.verdict == "input_error" and [*out.wrong] == [run, signal]


def _shifted(case: Case, out: Outcome) -> bool:
    """Of all recordings, with its size."""
    size = abs(out.shift_mm - case.hidden.shift_mm)
    return out.verdict == "input_error" and [*out.wrong] == [ALL, "position"] and size <= NEAR_SHIFT_MM


def _sensor(case: Case, out: Outcome) -> bool:
    """The thermometer is named, and no heat is."""
    named = [*out.broken] in [[*each] for each in out.faulty] or out.channel == out.broken[1]
    heats = out.place_mm is not None or any(kind_of(name) == "heat" for name in false_effects(case, out))
    return named and not heats


RULES: Mapping[str, Callable[[Case, Outcome], bool]] = {
    "one": _one,
    "half": _one,
    "double": _one,
    "none": _none,
    "two": _several(2),
    "three": _several(2),
    "stranger": _stranger,
    "drawn": _drawn,
    "bare": _bare,
    "reading": _reading,
    "event": _event,
    "label": _label,
    "sensor": _sensor,
    "shifted": _shifted,
}
