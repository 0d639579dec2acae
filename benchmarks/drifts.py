"""Slow drifts: when a thermometer that drifts is suspected, when it is accused, and what becomes of the estimate."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from benchmarks import handed_over, paper_rig
from benchmarks.injected import drifting
from benchmarks.measure import say, section
from estimator.batch.replay import replay
from estimator.faults.fault import Fault, spans
from estimator.record import Array

RATES = (3.0, 1.0, 0.5, 0.25)  # K/h
CHANNELS = ("T01", "T05", "T08", "T15")
SHORT = {"CS-10": ("CS-10", 300.0), "ES-20": ("ES-20", 160.0)}  # strokes over a part of the screw, while driving
UNDER = ("T03", "T04", "T05", "T06", "T07")  # where the nut goes, or nearly
SHORT_SEED = 314  # the limits were set with those of 311 in view
LOST_SD, LOST_UM = 5.0, 0.5  # further off than both is lost
AFTER = ("may drift after s", "left out after s")
HEAD = ("K/h", "thermometer", "", *AFTER, "worst, um", "in its sd", "lost, s", "in 2 sd")


@dataclass(frozen=True)
class Found:
    """What becomes of a drift.

    suspected_s, accused_s  after which time, NaN: never, or it was suspected before it drifted and still is
    um, sd    most that the elongation is off by, and by how many of its sd
    lost_s    longest time that it is off by more than 5 sd and 0.5 um
    in_2sd    share of ticks from the drift's beginning on in which the truth is within 2 sd
    """

    suspected_s: float
    accused_s: float
    um: float
    sd: float
    lost_s: float
    in_2sd: float


def found(run: str, at_s: float, seed: int, channel: str, K_per_h: float) -> Found:
    """One drift."""
    rig = paper_rig.rig()
    recording, true_um = handed_over.simulated(run, rig, seed=seed)
    i = rig.index(channel)
    track = replay(paper_rig.model(), rig, drifting(recording, i, K_per_h, at_s))
    now = track.time_s >= at_s
    error, sd = np.abs(true_um - track.elongation_um)[now], track.sigma_um[now]
    lost = error > np.maximum(LOST_SD * sd, LOST_UM)
    since_s = track.time_s[now] - at_s
    return Found(
        suspected_s=_first(since_s, (track.may_drift_K[now, i] != 0) & (track.since_s[now, i] >= at_s)),
        accused_s=_first(since_s, track.fault[now, i] == Fault.DRIFTING),
        um=float(error.max()),
        sd=float((error / sd).max()),
        lost_s=longest(lost) * rig.tick_s,
        in_2sd=float((error <= 2.0 * sd).mean()),
    )


def longest(so: Array) -> int:
    """For how many ticks at most something is so."""
    return int(np.diff(spans(so)).max(initial=0))


def table(when: dict[str, tuple[str, float]], seed: int) -> str:
    """All drifts of a rig, from times of runs on."""
    usual = section("Drifts one by one", [HEAD, *_rows(when, seed, RATES, CHANNELS)], level=3)
    return "\n".join(
        [usual, section("Drifts under short strokes", [HEAD, *_rows(SHORT, SHORT_SEED, RATES[:1], UNDER)], level=3)]
    )


def _rows(
    when: dict[str, tuple[str, float]], seed: int, rates: Sequence[float], channels: Sequence[str]
) -> Iterator[list[str]]:
    for rate in rates:
        for channel in channels:
            for name, (run, at_s) in when.items():
                f = found(run, at_s, seed, channel, rate)
                say(f"  drift of {rate:g} K/h, {channel}, {name}: {f.um:.2f} um")
                seconds = [f"{s:.0f}" if np.isfinite(s) else "never" for s in (f.suspected_s, f.accused_s)]
                off = [f"{f.um:.2f}", f"{f.sd:.1f}", f"{f.lost_s:.0f}", f"{f.in_2sd:.0%}"]
                yield [f"{rate:g}", channel, name, *seconds, *off]


def _first(since_s: Array, so: Array) -> float:
    return float(since_s[np.argmax(so)]) if so.any() else float("nan")
