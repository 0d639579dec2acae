"""The replay refuses, leaves out and begins anew as the filter does."""

from collections.abc import Callable

import numpy as np
import pytest

from estimator.batch.replay import replay
from estimator.faults.fault import Fault
from estimator.faults.judge import START_S, TOGETHER_TICKS
from estimator.faults.suspects import HELD_S
from estimator.rig import Rig
from estimator.step import Mode, Track
from tests.estimator.batch.conftest import SPIKE_K, TICKS, both, copy


def left_out(track: Track, channel: int) -> list[int]:
    return np.flatnonzero(~track.fused[:, channel]).tolist()


def test_a_spike_is_refused_and_one_that_stays_is_left_out(lived):
    model, rig, run = lived
    run = copy(run)
    run.channels[30, 1] += SPIKE_K
    run.channels[60:, 2] += SPIKE_K
    track = both(model, rig, run)
    assert left_out(track, 1) == [30]
    assert left_out(track, 2) == list(range(60, TICKS))
    held = round(HELD_S / rig.tick_s)
    assert track.fault[60 : 60 + held, 2].tolist() == [Fault.JUDGED] * held
    assert (track.fault[60 + held :, 2] == Fault.JUMPED).all()
    np.testing.assert_array_equal(track.since_s[60:, 2], track.time_s[60])
    assert np.isnan(track.since_s[:60]).all() or np.flatnonzero(np.isfinite(track.since_s[:60, 1])).tolist() == [30]


def test_a_reading_missed_does_not_end_a_spike(lived):
    model, rig, run = lived
    run = copy(run)
    run.channels[60:75, 2] += SPIKE_K
    run.channels[63, 2] = np.nan
    assert left_out(both(model, rig, run), 2)[:15] == list(range(60, 75))


def test_a_thermometer_that_was_off_from_the_first_sample_on(lived):
    model, rig, run = lived
    run = copy(run)
    run.channels[:, 1] += SPIKE_K
    track = both(model, rig, run)
    assert left_out(track, 1) == list(range(TICKS))
    assert track.fault[-1, 1] == Fault.OFF


def test_all_thermometers_that_began_with_another_temperature(lived):
    """What they read before they were ready is no start: the run begins anew."""
    model, rig, run = lived
    run = copy(run)
    run.channels[:12, rig.is_thermometer] += SPIKE_K
    track = both(model, rig, run)
    assert track.elongation_um[12 + TOGETHER_TICKS - 1] == pytest.approx(0.0, abs=1e-9)
    assert left_out(track, 1) == list(range(12, 12 + TOGETHER_TICKS - 1))
    later = both(model, rig, run.rows(slice(12 + TOGETHER_TICKS - 1, None)))
    np.testing.assert_allclose(track.elongation_um[12 + TOGETHER_TICKS - 1 :], later.elongation_um, atol=1e-9)


def test_all_thermometers_that_jump_together_have_other_zeros(anywhere):
    model, rig, run = anywhere
    run, healthy = copy(run), replay(model, rig, run)
    from_ = TICKS - 25
    rig_is_warm = run.time_s[from_] - run.time_s[0] > START_S
    run.channels[from_:, rig.is_thermometer] += SPIKE_K
    track = both(model, rig, run)
    assert left_out(track, 1) == list(range(from_, from_ + TOGETHER_TICKS - (not rig_is_warm)))
    if rig_is_warm:
        error = abs(track.elongation_um - healthy.elongation_um)
        assert (error <= 4.0 * track.sigma_um + 0.01)[from_:].all()


def muted(*spans: tuple[int, float, float], rig: Rig) -> Callable[[float], np.ndarray]:
    """Mute channel i between two ticks, for each (i, from, to)."""

    def mute(time_s: float) -> np.ndarray:
        out = np.zeros(len(rig.names), dtype=bool)
        for i, lo, hi in spans:
            out[i] |= lo <= time_s / rig.tick_s < hi
        return out

    return mute


def test_muted_spans(lived):
    """Also from the start on, of all channels at a time, and over a spike, which is still there afterwards."""
    model, rig, run = lived
    run = copy(run)
    m = len(rig.names)
    run.channels[100:108, 2] += SPIKE_K
    spans = [(0, 0, 30), (m - 1, 50, 80), (2, 100, 103), *((i, 120, 125) for i in range(m))]
    track = both(model, rig, run, muted(*spans, rig=rig))
    assert not track.fused[:29, 0].any()
    assert track.fused[29, 0]
    assert np.isfinite(track.innovation[:29, 0]).all()
    assert not track.fused[49:79, -1].any()
    assert left_out(track, 2)[:9] == list(range(99, 108))
    assert (track.mode[119:124] == Mode.COASTING).all()


def test_a_channel_that_no_effect_reads_is_shown_but_never_fused(lived):
    model, rig, run = lived
    track = both(model - "displacement", rig, run)
    assert not track.fused[:, -1].any()
    assert np.isinf(track.innovation_sd[:, -1]).all()
