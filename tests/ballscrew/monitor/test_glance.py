"""What is read at a glance: values of now in full, grey where they are not of now, and whether to rely on them."""

import io
from dataclasses import replace

import numpy as np
import pytest
from PIL import Image

from ballscrew.monitor.glance import glances
from ballscrew.monitor.monitor import Moment
from ballscrew.monitor.status import Status
from estimator.alarms.alarms import Alarm
from estimator.alarms.trust import Trust
from estimator.screw import Bed
from estimator.step import Mode
from tests.viz_fake import fake_run
from viz.lanes import banner
from viz.lanes.standing import Glance

SILENT = Alarm("silent", "T07", 600.0, "T07 is not read")


@pytest.fixture(scope="module")
def status() -> Status:
    """At rest after a drive, valid since the second tick, sent to the control."""
    run = fake_run("FS-20", 300)
    step = run.track.step(299, ("",) * 16)
    moment = Moment(run.recording.sample(299), step, Trust((), False, False), (), ())
    return Status(
        run.rig, moment, (), "a bus open", 100, 16.0, 0.0, None, 0, {}, {}, "none", "", "",
        motion="at rest since 0:04:02", published="sent", judged_s=2.0,
    )  # fmt: skip


def alone(status: Status, **how: object) -> Status:
    assert status.moment is not None
    return replace(status, moment=replace(status.moment, **how))


def test_three_values_with_what_they_are_of(status):
    step = status.moment.step
    growth, table, estimate = glances(status)
    assert growth.value == f"{step.elongation_um:+.2f} ± {2 * step.sigma_um:.2f} µm"
    assert growth.below == "at rest since 0:04:02"
    assert table.value == f"{step.error_at_table_um:+.2f} ± {2 * step.error_at_table_sd_um:.2f} µm"
    assert table.below == "table at 400 mm, sent"
    assert (estimate.value, estimate.below) == ("VALID", "since 0:00:02; 15 of 15 thermometers")
    assert [glance.tone for glance in (growth, table, estimate)] == ["value", "value", "valid"]


def test_an_estimate_that_is_not_valid_is_grey_and_says_why_since_when(status):
    invalid = alone(status, trust=Trust(("no news of the drive", "rig and model part")))
    *values, estimate = glances(replace(invalid, judged_s=280.0))
    assert {value.tone for value in values} == {"stale"}
    assert estimate.below == "since 0:04:40: no news of the drive, rig and model part"
    assert (estimate.value, estimate.tone) == ("INVALID", "invalid")


def test_nothing_is_in_colour_once_the_rig_has_ended(status):
    silent = replace(
        alone(status, provisional=True), alarms=(Alarm("bus", "", 290.0, "nothing of the rig on the bus"),)
    )
    assert glances(silent)[-1] == Glance(
        "estimate", "NO FRAMES", "since 0:04:50: by the model alone, not valid", "stale"
    )
    ended = glances(replace(status, ended=True))
    assert ended[-1].value == "ENDED"
    assert {glance.tone for glance in (*glances(silent), *ended)} == {"stale"}


def test_broken_channels_are_named_beside_a_valid_estimate(status):
    assert glances(replace(status, alarms=(SILENT,)))[-1].below.endswith("; T07 silent")


def test_a_rig_that_does_not_grow_shows_its_warmest_thermometer(status):
    step = replace(status.moment.step, elongation_um=np.nan, sigma_um=np.nan)
    rig = replace(status.rig, screw=None, nut=None, supports={})
    warmest, estimate = glances(replace(alone(status, step=step), rig=rig))
    k = int(np.argmax(step.measured[:15]))
    assert (warmest.value, warmest.below) == (f"{step.measured[k]:.2f} °C", step.names[k])
    assert estimate.value == "VALID"


def test_a_place_of_the_table_that_is_not_known_is_no_number(status):
    step = replace(status.moment.step, error_at_table_um=np.nan, error_at_table_sd_um=np.nan, position_mm=np.nan)
    _, table, _ = glances(alone(status, step=step))
    assert (table.value, table.below) == ("not known", "no position of the table, sent")


def test_a_bed_that_nobody_read_is_why_there_is_no_error_at_the_table(status):
    step = replace(status.moment.step, error_at_table_um=np.nan, error_at_table_sd_um=np.nan)
    _, table, _ = glances(replace(alone(status, step=step), rig=replace(status.rig, bed=Bed("base"))))
    assert (table.value, table.below) == ("not known", "nothing read of base, the bed's temperature, sent")


def test_before_the_first_tick_and_the_first_estimate_there_is_no_value(status):
    assert glances(replace(status, moment=None))[0].value == "WAITING"
    waiting = alone(status, step=replace(status.moment.step, mode=Mode.INIT), trust=Trust())
    assert (glances(waiting)[-1].value, glances(waiting)[-1].tone) == ("NOT YET", "stale")


def colours(*said: Glance) -> np.ndarray:
    """Pixels (n, 3) of a banner."""
    return np.array(Image.open(io.BytesIO(banner.picture(said))).convert("RGB")).reshape(-1, 3).astype(int)


def test_a_banner_is_grey_unless_it_is_of_now(status):
    assert np.ptp(colours(*glances(replace(status, ended=True))), axis=1).max() < 20
    assert np.ptp(colours(*glances(status)), axis=1).max() > 60


def test_a_long_reason_ends_within_its_column():
    long = Glance("estimate", "INVALID", "why " * 200, "invalid")
    pixels = colours(Glance("elongation", "+1.00 µm", "", "value"), long).reshape(banner.HEIGHT, banner.WIDTH, 3)
    assert (pixels[:, -banner.MARGIN // 2 :] == pixels[0, 0]).all()


@pytest.mark.parametrize(
    ("sd_um", "value"), [(0.155, "+47.38 ± 0.31 µm"), (6.25, "+47.4 ± 12.5 µm"), (115.0, "+47 ± 230 µm")]
)
def test_what_is_hardly_known_has_few_digits(status, sd_um, value):
    step = replace(status.moment.step, elongation_um=47.38, sigma_um=sd_um)
    assert glances(alone(status, step=step))[0].value == value
