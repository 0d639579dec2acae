"""How far the readings of a recording were used: of each channel how many, why the others were not, and when it was
broken."""

from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, fields

import numpy as np

from estimator.faults.fault import ELSEWHERE, Fault, Spell, Suspicion, spans, spells, suspicions
from estimator.faults.travel import disagreements, too_slow
from estimator.record import POWER_ON_C, Array, Recording
from estimator.rig import Rig
from estimator.step import Track

NOT_MEASURED, NO_MODEL, MUTED = "not measured", "no model", "muted"
SILENT_S = 60.0
POWER_ON, EARLY = "power-on value", "before the start"


@dataclass(frozen=True)
class Told:
    """K ticks of m channels, as a filter has left them.

    time_s     (K,);   begins (K,) bool, where the run began, the last time for good
    measured   (K, m) NaN: not measured;   modelled (m,) bool, which channels the model reads
    fused      (K, m) bool
    fault, since_s  (K, m) a Fault each, and since when;   jump (K, m) by how much zeros became others
    may_drift_K     (K, m) by how much channels that are fused may have drifted, 0: not suspected
    input_fault     (K, p) why inputs were held, a Fault each
    shift_mm        (K,) by how much the nut's heat stands elsewhere than the position says
    """

    time_s: Array
    begins: Array
    measured: Array
    modelled: Array
    fused: Array
    fault: Array
    since_s: Array
    may_drift_K: Array
    jump: Array
    input_fault: Array
    shift_mm: Array

    @classmethod
    def by(cls, track: Track) -> "Told":
        """What a track tells."""
        modelled = np.asarray(np.isfinite(track.innovation_sd).any(axis=0))
        names = (field.name for field in fields(cls) if field.name != "modelled")
        return cls(modelled=modelled, **{name: getattr(track, name) for name in names})

    @property
    def begin(self) -> int:
        """The tick with which the run began."""
        return int(np.flatnonzero(self.begins)[-1])


@dataclass(frozen=True)
class ChannelUse:
    """One channel's readings: how many were taken and used, why others were not, when it was broken and when only
    suspected."""

    channel: str
    taken: int
    used: int
    why: Mapping[str, int]
    spells: tuple[Spell, ...]
    suspicions: tuple[Suspicion, ...]

    @property
    def refused(self) -> int:
        """Readings that were taken, and not used."""
        return self.taken - self.used

    @property
    def share(self) -> float:
        """Of the readings taken, those used; NaN without any."""
        return self.used / self.taken if self.taken else float("nan")

    @property
    def suspect(self) -> Fault:
        """How the channel was broken for longest; NONE where it never was."""
        broken = {fault: self.why.get(fault.why, 0) for fault in Fault if fault.word}
        most = max(broken, key=lambda fault: broken[fault])
        return most if broken[most] else Fault.NONE


@dataclass(frozen=True)
class Jump:
    """Channels whose zeros became others at a time: by how much each, K or um."""

    time_s: float
    sizes: Mapping[str, float]


@dataclass(frozen=True)
class Use:
    """What was used of one recording. `again`: the run had begun before, with what were no temperatures.

    inputs  when those that were broken were so
    silent  since when, s, inputs were not read any more;   never  inputs that were not read at all
    travel  what was wrong with position and speed, and since when, s
    too_slow  which jumps of the position speeds are too far apart to show; empty: none that matter
    """

    name: str
    begun_s: float
    again: bool
    channels: tuple[ChannelUse, ...]
    jumps: tuple[Jump, ...]
    inputs: Mapping[str, tuple[Spell, ...]]
    silent: Mapping[str, float]
    never: tuple[str, ...]
    travel: tuple[tuple[float, str], ...]
    too_slow: str = ""

    @property
    def suspects(self) -> tuple[ChannelUse, ...]:
        """Channels that were broken for a time."""
        return tuple(one for one in self.channels if one.suspect)


def use_of(recording: Recording, rig: Rig, told: Told) -> Use:
    """What was used of a recording, and why the rest was not."""
    channels, begin = rig.names, told.begin
    why, taken = _why(told), np.isfinite(told.measured)
    used = taken & (why == "")
    found = []
    for i, channel in enumerate(channels):
        reasons = dict(Counter(why[:, i][why[:, i] != ""].tolist()).most_common())
        counts = int(taken[:, i].sum()), int(used[:, i].sum())
        found.append(ChannelUse(channel, *counts, reasons, _spells(told, i), _suspicions(told, i)))
    held = {
        name: spells(told.input_fault[begin:, j], told.time_s[begin:], told.time_s[begin:])
        for j, name in enumerate(rig.inputs)
    }
    jumps = [Jump(float(told.time_s[k]), _sizes(told.jump[k], channels)) for k in np.flatnonzero(told.jump.any(axis=1))]
    broken = {name: some for name, some in held.items() if some}
    again, travel = bool(told.begins.sum() > 1), (*disagreements(recording, rig), *_elsewhere(told))
    return Use(
        recording.name, float(told.time_s[begin]), again, tuple(found), tuple(jumps), broken, _silent(recording),
        tuple(name for name in rig.inputs if not np.isfinite(recording.inputs[name]).any()), travel,
        too_slow(recording, rig),
    )  # fmt: skip


def _elsewhere(told: Told) -> Iterator[tuple[float, str]]:
    """When the nut's heat began to stand elsewhere than the position says, and by how much at most."""
    for first, end in spans(told.shift_mm != 0):
        most_mm = float(max(told.shift_mm[first:end], key=abs))
        yield float(told.time_s[first]), f"{ELSEWHERE} (off by {most_mm:+.0f} mm, or heat is missing there)"


def _silent(recording: Recording) -> dict[str, float]:
    """Inputs that were read once, and for a minute and more at the end were not: since when, s."""
    last = {name: np.flatnonzero(np.isfinite(column)) for name, column in recording.inputs.items()}
    since = {name: float(recording.time_s[at[-1]]) for name, at in last.items() if len(at)}
    return {name: from_s for name, from_s in since.items() if recording.time_s[-1] - from_s > SILENT_S}


def _sizes(jump: Array, channels: Sequence[str]) -> dict[str, float]:
    return {channels[i]: float(jump[i]) for i in np.flatnonzero(jump).tolist()}


def _why(told: Told) -> Array:
    """Why each reading was not used, (K, m) str; empty where it was."""
    early = np.arange(len(told.time_s))[:, None] < told.begin
    words = np.array([fault.why or MUTED for fault in Fault], dtype=object)
    why = np.where(told.fused & ~early, "", words[told.fault])
    why = np.where(told.modelled, why, NO_MODEL)
    begun = np.array([EARLY, POWER_ON], dtype=object)[np.isin(told.measured, POWER_ON_C).astype(int)]
    why = np.where(early, begun, why)
    return np.where(np.isfinite(told.measured), why, NOT_MEASURED)


def _spells(told: Told, i: int) -> tuple[Spell, ...]:
    """When channel i was broken."""
    return spells(told.fault[told.begin :, i], told.since_s[told.begin :, i], told.time_s[told.begin :])


def _suspicions(told: Told, i: int) -> tuple[Suspicion, ...]:
    """When channel i was used though it may have drifted."""
    return suspicions(told.may_drift_K[:, i], told.fault[:, i], told.time_s)
