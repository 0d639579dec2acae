"""What is asked of a review first is answered from the review's own figures."""

from dataclasses import replace

import numpy as np
import pytest

from ballscrew.at_a_glance import glance
from ballscrew.monitor.monitor import Monitor
from estimator.accuracy.review import Review, review
from estimator.faults.fault import Fault
from estimator.record import collect
from tests.live_fake import rig_frames


@pytest.fixture(scope="module")
def found(paper) -> Review:
    """Seventy seconds, the table driven, with a reference."""
    monitor = Monitor(paper[1], paper[0])
    samples = [moment.sample for frame in rig_frames(70.0) for moment in monitor.feed(frame)]
    return review(collect("run", samples), *paper, truth_um=np.linspace(0.0, 1.0, len(samples)), table_mm=(0.0, 400.0))


def test_it_says_how_much_how_sure_and_where_it_fails(found, paper):
    k = 40
    text = glance(found, *paper, found.track.time_s[k]).splitlines()
    um, sd = found.track.elongation_um[k], found.track.sigma_um[k]
    assert text[0].startswith(f"- **Grown {um:.1f} ± {2 * sd:.1f} µm** at 0:00:4")
    assert text[1].startswith(f"- **Sure to ± {2 * np.nanmax(found.track.sigma_um):.2f} µm** (2 sd) or better; ")
    at_table = found.table.error_um[k, np.abs(found.table.error_um[k]).argmax()]
    assert text[2].startswith(f"- **At the table** {at_table:+.1f}")
    assert text[3].startswith("- **Bad channels: none**; ")
    assert text[-2].startswith("- **Fails most** at ")
    assert f"filter {found.errors['filter'][np.nanargmax(np.abs(found.errors['filter']))]:+.2f} µm" in text[-2]


def test_it_names_bad_channels_and_leaves_out_what_nothing_tells(found, paper):
    stuck = replace(found.use.channels[3], why={Fault.STUCK.why: 9})
    use = replace(found.use, channels=(*found.use.channels[:3], stuck, *found.use.channels[4:]))
    nothing = np.full(len(found.track), np.nan)
    track = replace(found.track, elongation_um=nothing, sigma_um=nothing)
    table = replace(found.table, error_um=np.full_like(found.table.error_um, np.nan))
    errors = {**found.errors, "filter": nothing}
    text = glance(replace(found, use=use, track=track, table=table, errors=errors), *paper, 40.0)
    assert "**Bad channels: T04 at 271 mm stuck**" in text
    assert "no reference of the elongation" in text
    for gone in ("Grown", "Sure to", "At the table"):
        assert gone not in text
