"""An effect of one's own that makes no number of some ticks: said once, never sent, and the monitor goes on."""

from dataclasses import replace
from pathlib import Path

import cantools
import numpy as np
import pytest

from ballscrew.monitor.monitor import Moment, Monitor
from ballscrew.monitor.session import Session
from drivers.bus import publisher as publishing
from drivers.bus.publisher import Publisher
from estimator.effect import Effect
from estimator.errors import EffectError
from estimator.filter import Filter
from estimator.record import collect
from estimator.step import Mode
from estimator.terms import SCREW, Heat, Link, Read, Store
from tests.ballscrew.monitor.conftest import Clock, Receiver
from tests.live_fake import lived

END_S, FAILS_S = 90.0, 60.0


def failing(u):
    return np.where(u.motion.time_s > FAILS_S, np.nan, 0.0)


class Jet(Effect):
    """Cools nothing, and after a minute makes no number of it: q = 0 / 0."""

    def terms(self, p, u, rig):
        yield Heat(SCREW, failing(u))


class Odd(Jet):
    """Shifts a reading by as little: y = T + 0 / 0."""

    def terms(self, p, u, rig):
        yield Read("T03", {}, 0.0, failing(u))


class Raising(Effect):
    """Divides by the speed, which is 0 at rest: q = 0 / w."""

    def terms(self, p, u, rig):
        yield Heat(SCREW, 0.0 / u.omega)


class Body(Effect):
    """A body of its own, which the estimate cannot do without: C dT/dt = 0 / 0."""

    def terms(self, p, u, rig):
        yield Store("cover", 1e4, 0.1, "ambient")
        yield Link("cover", "ambient", 1.0)
        yield Heat("cover", failing(u))


def sent(rig, step, trust) -> list[dict]:
    """Both frames of a moment as a control decodes them."""
    dbc = cantools.database.load_file(Path(publishing.__file__).parents[1] / "rig.dbc")
    frames = Publisher(rig, lambda: None).frames(step, trust, step.position_mm)
    return [dbc.decode_message(f.arbitration_id, f.data, decode_choices=False) for f in frames]


@pytest.fixture(scope="module")
def without(rig, shipped, frames) -> list[Moment]:
    return lived(Monitor(shipped, rig), frames)


@pytest.mark.parametrize(("effect", "at_s"), [(Odd, FAILS_S + 2), (Raising, 1.0)])
def test_the_estimate_goes_on_without_an_effect_that_fails(rig, shipped, frames, without, effect, at_s):
    moments = lived(Monitor(shipped + effect, rig), frames)
    (alarm,) = (alarm for moment in moments for alarm in moment.begun)
    assert (alarm.kind, alarm.channel) == ("effect", effect.name)
    assert alarm.since_s == pytest.approx(at_s, abs=1.5)
    assert f"{effect.name}: term 1, " in alarm.text
    assert alarm.text.endswith(f"the estimate goes on without {effect.name}")
    for moment, usual in zip(moments, without, strict=True):
        assert moment.trust == usual.trust
        np.testing.assert_allclose(moment.step.elongation_um, usual.step.elongation_um, rtol=0, atol=1e-9)
        np.testing.assert_allclose(moment.step.sigma_um, usual.step.sigma_um, rtol=0, atol=1e-9)


def test_the_tick_in_which_it_fails_is_read_once(rig, shipped, without):
    """Asked for again, without the effect, the drive has gone on by one tick, not two."""
    odd, usual = Filter(shipped + Jet, rig), Filter(shipped, rig)
    for moment in without:
        usual.step(moment.sample)
        try:
            odd.step(moment.sample)
        except EffectError:
            odd.leave_out("jet")
            odd.step(moment.sample)
    assert "jet" not in odd.model.effects
    next_one = collect("", [without[-1].sample])
    seconds, expected = (one.run.forcing.read(next_one).inputs.motion.time_s for one in (odd, usual))
    assert seconds == expected


def test_two_that_fail_at_once_are_both_left_out(rig, shipped, frames, without):
    monitor = Monitor(shipped + Jet + Odd, rig)
    moments = lived(monitor, frames)
    assert [alarm.channel for moment in moments for alarm in moment.begun] == ["jet", "odd"]
    assert moments[-1].step.elongation_um == pytest.approx(without[-1].step.elongation_um, abs=1e-9)
    assert set(monitor.model.effects) == set(shipped.effects)


def test_while_the_bus_is_silent_too(rig, shipped, frames, without):
    monitor, begun = Monitor(shipped + Jet, rig), []
    before = [frame for frame in frames if frame.time_s - frames[0].time_s < FAILS_S - 5]
    lived_so_far = [moment for frame in before for moment in monitor.feed(frame)]
    for silent_s in (5.0, 10.0):
        provisional = list(monitor.idle(silent_s))
        assert all(np.isfinite(moment.step.elongation_um) for moment in provisional)
        begun += [alarm.kind for moment in provisional for alarm in moment.begun]
    assert begun.count("effect") == 1
    moments = [*lived_so_far, *lived(monitor, frames[len(before) :])]
    assert moments[-1].step.elongation_um == pytest.approx(without[-1].step.elongation_um, abs=1e-9)


def test_without_an_effect_that_the_estimate_needs_there_is_none_until_the_next_start(rig, shipped, frames):
    """The session says so once, sends no number, and goes on to listen and to record."""
    said, told, recorded = [], [], []
    session = Session(
        Monitor(shipped + Body, rig), Receiver(frames), Clock(), "bus", lambda text, level: said.append(text),
        lambda status: told.append(status.json()),
    )  # fmt: skip
    session.run(lambda: bool(session.receiver.items), lambda status: recorded.append(status.frames))
    session.finish()
    (why,) = (text for text in said if "body" in text)
    assert why.startswith("estimate valid no longer: ")
    assert "term 3, Heat of cover: q is nan at " in why
    assert why.endswith("correct it and start again")
    assert len(told) == pytest.approx(END_S, abs=2)
    bad = [line for line in told if line["t"] > FAILS_S + 2]
    assert {line["mode"] for line in bad} == {"invalid"}
    assert not np.isfinite([[line["elongation_um"], line["sigma_um"], line["nis"]] for line in bad]).any()
    last = session.latest
    estimate, compensation = sent(rig, last.step, last.trust)
    assert (estimate["EstMode"], estimate["EstElongation"], estimate["EstSigma"]) == (Mode.INVALID, 0.0, 65.535)
    assert (compensation["CmpValid"], compensation["CmpError"]) == (0, 0.0)


@pytest.mark.parametrize("broken", [{"elongation_um": np.nan}, {"sigma_um": np.inf}])
def test_what_is_no_number_is_never_sent_as_valid(paper, without, broken):
    last = without[-1]
    assert last.trust.valid
    estimate, _ = sent(paper[0], replace(last.step, **broken), last.trust)
    assert (estimate["EstMode"], estimate["EstSigma"]) == (Mode.INVALID, 65.535)
