"""A small synthetic run for the views: an explicit heat balance on 49 cells, thermometers, displacement readings."""

from pathlib import Path

import numpy as np

from estimator.alarms.alarms import Alarm
from estimator.batch.replay import replay
from estimator.record import Array, Recording
from estimator.rig import Rig
from estimator.rig_folder.rig_folder import load_rig
from estimator.step import TableErrors
from tests.conftest import at_defaults
from viz.lanes.standing import Judged
from viz.recorded.run import ReviewedRun

CELLS = 49
REST_S, DRIVE_S = 20, 222
SILENT = Alarm("silent", "T07", 600.0, "T07 at 703 mm is not read")
JUDGED = [
    Judged(1.0, ("no estimate yet",), ()),
    Judged(2.0, (), ()),
    Judged(610.0, (), (SILENT,)),
    Judged(641.0, ("no news of the drive",), ()),
]


def fake_run(name: str = "FS-20", seconds: int = 2022, seed: int = 0, rig: Rig | None = None) -> ReviewedRun:
    """Rest, drive, cooldown at 1 Hz on the paper's rig, filtered by the default model."""
    rig = rig or load_rig(Path(__file__).parent.parent / "recordings")
    dice = np.random.default_rng(seed)
    time_s = np.arange(seconds) + 1.0
    turning = (time_s > REST_S) & (time_s <= REST_S + DRIVE_S)
    place = np.linspace(10.0, 970.0, CELLS)
    truth = _heat(place, turning)
    elongation = rig.screw.expansion * np.trapezoid(truth - truth[0], place, axis=1) * 1e3
    rise = np.stack([np.interp(_places(rig), place, row - truth[0]) for row in truth])
    recording = _recording(name, rig, time_s, turning, truth[0, 0] + rise, elongation, dice)
    track = replay(at_defaults(), rig, recording)
    measured = track.measured[:, :15]
    polyline = rig.screw.expansion * np.trapezoid(measured - measured[0], _places(rig), axis=1) * 1e3
    smoothed = track.elongation_um + 0.1, 0.5 * track.sigma_um  # told apart from the filter's in the views
    errors = {
        "filter": elongation - track.elongation_um,
        "smoothed": elongation - smoothed[0],
        "polyline": elongation - polyline,
    }
    readings = track.measured[:, 15] - track.measured[0, 15]
    read = readings, readings, np.full(seconds, 0.1)
    nis_of = {name: 1.0 + i / 100 for i, name in enumerate(rig.names)}
    at_mm = np.array([0.0, 200.0, 400.0])
    table_truth = elongation[:, None] * (1.0 - at_mm / 1000.0)
    table = TableErrors(at_mm, table_truth + 0.2, np.full(table_truth.shape, 0.15))
    reference = "truth", errors, track.sigma_um
    told = nis_of, table, "**Grown**", JUDGED, rise, table_truth
    return ReviewedRun(name, rig, recording, track, *smoothed, polyline, *read, elongation, *reference, *told)


def _places(rig: Rig) -> Array:
    return np.array([channel.at_mm for channel in rig.channels.values() if channel.at_mm is not None])


def _heat(place: Array, turning: Array) -> Array:
    """Temperatures (K, CELLS) degC of a bar heated at both bearings and under the nut while turning."""
    source = 1.6 * ((place > 186) & (place < 761)) + 9.0 * np.exp(-(((place - 889) / 25) ** 2))
    source = (source + 4.0 * np.exp(-(((place - 72.5) / 20) ** 2))) * 0.0125
    rows, now = np.empty((len(turning), CELLS)), np.full(CELLS, 22.0)
    for k, on in enumerate(turning):
        rows[k] = now
        bend = np.diff(now, 2, prepend=now[0], append=now[-1]) * 12.5 / 20.0**2
        now = now + bend + on * source - 4e-4 * (now - 22.0)
    return rows


def _recording(
    name: str,
    rig: Rig,
    time_s: Array,
    turning: Array,
    thermometers: Array,
    elongation: Array,
    dice: np.random.Generator,
) -> Recording:
    count = len(time_s)
    channels = np.full((count, len(rig.names)), np.nan)
    channels[:, :15] = thermometers + dice.normal(0, 0.02, thermometers.shape)
    channels[600:640, 6] = np.nan
    read = ~turning | (time_s % 2 == 0)
    channels[read, 15] = elongation[read] + dice.normal(0, 0.1, read.sum())
    inputs = {key: np.full(count, 22.0) for key in rig.inputs}
    inputs["position"] = np.where(turning, 200 + 200 * np.cos(2 * np.pi * (time_s - REST_S) / 2.4), 400.0)
    coverage = rig.screw.overlap(rig.nut.centre(inputs["position"]) - 87.5, rig.nut.centre(inputs["position"]) + 87.5)
    coverage[turning] = rig.screw.overlap(186.0, 761.0) * 0.3
    return Recording(
        name, time_s, channels, np.zeros_like(channels), inputs, np.where(turning, 174.5, 0.0), coverage,
        frames=16 * count, skipped={"error frame": 3}, notes=("the log ends in the middle of a frame",),
    )  # fmt: skip
