"""The recordings of a case: its machine's runs, with what is planted in them and what is wrong with them."""

from dataclasses import dataclass, replace

from benchmarks.handed_over import Lie, record
from benchmarks.hidden.cases import ODD, Case
from benchmarks.hidden.drawn_reading import drawn_reading, misread
from benchmarks.injected import failing
from drivers.virtual_rig import Run, simulate
from drivers.virtual_rig.dice import dice
from estimator.record import Recording
from estimator.rig import Rig

IN_DRIVE = (0.3, 0.6)  # of a drive's length, where something begins
WARM = range(1, 12)  # thermometers that may fail: those between the bearings


@dataclass(frozen=True)
class Recorded:
    """Recordings to search in and held out.

    places    of what is planted there, mm, or the number of a channel
    odd       name of the run in which something is wrong or happens;   onset_s: when, since its first sample
    channel   that fails
    """

    seen: list[Recording]
    held_out: list[Recording]
    places: dict[str, float]
    odd: str = ""
    onset_s: float = 0.0
    channel: str = ""


def recorded(case: Case, rig: Rig) -> Recorded:
    """Let the machine of a case run."""
    (used, apart), hidden = case.runs, case.hidden
    if hidden.event:
        return _eventful(case, rig)
    runs = [simulate(name, machine=case.machine, seed=case.seed, plant=hidden.plant) for name in (*used, *apart)]
    all_ = [record(run, rig, _lies(shift_mm=hidden.shift_mm)) for run in runs]
    if hidden.reading:
        all_ = misread(all_, drawn_reading(case.seed, rig), rig)
        return Recorded(all_[: len(used)], all_[len(used) :], runs[0].places)
    wrong, channel = _wrong(case, rig, runs[ODD])
    seen = [wrong if i == ODD else each for i, each in enumerate(all_[: len(used)])]
    return Recorded(seen, all_[len(used) :], runs[0].places, wrong.name, channel=channel)


def _lies(speed: float = 1.0, position: float = 1.0, shift_mm: float = 0.0) -> dict[str, Lie]:
    """Signals of the drive by factors of what they are, and shifted."""
    return {"speed": lambda rpm: speed * rpm, "position": lambda mm: position * mm + shift_mm}


def _wrong(case: Case, rig: Rig, run: Run) -> tuple[Recording, str]:
    """The odd run as it is handed over, and the thermometer that fails in it."""
    hidden = case.hidden
    made = record(run, rig, _lies(hidden.speed, hidden.position, hidden.shift_mm))
    made = replace(made, inputs={**made.inputs, "ambient": made.inputs["ambient"] + hidden.ambient_K})
    if not hidden.fault:
        return made, ""
    channel = int(dice(case.seed, "channel").choice(WARM))
    return failing(made, hidden.fault, [channel], _in_drive(case, run), case.seed), rig.names[channel]


def _in_drive(case: Case, run: Run) -> float:
    """Some time in the first drive of a run, s since its first sample."""
    drive, share = run.travel.drives[0], dice(case.seed, "onset").uniform(*IN_DRIVE)
    return float(round(drive.start_s + share * (drive.stop_s - drive.start_s)))


def _eventful(case: Case, rig: Rig) -> Recorded:
    """Healthy runs, but for the slowest, in whose first drive something begins and stays."""
    used, _ = case.runs
    healthy = {name: simulate(name, machine=case.machine, seed=case.seed) for name in used}
    odd = min(used, key=lambda name: float(name.partition("-")[2]))
    plant, onset_s = case.hidden.plant, _in_drive(case, healthy[odd])
    runs = healthy | {odd: simulate(odd, machine=case.machine, seed=case.seed, plant=plant, onset_s=onset_s)}
    seen = [record(run, rig) for run in runs.values()]
    return Recorded(seen, [], runs[odd].places, f"{odd}.blf", onset_s)
