"""What has changed is asked in a process of its own, and said in one line."""

import time
from collections.abc import Iterator
from itertools import islice

import pytest

from ballscrew.monitor.explainer import AGAIN_S, SOON_S, Explainer
from estimator.alarms.alarms import Alarm
from estimator.rig_folder.model_toml import load_model, save_model
from tests.conftest import PAPER

PARTED = [Alarm("nis", "", 60.0, "innovations too large", 60.0)]
SILENT = [Alarm("silent", "T04", 60.0, "T04 is silent")]


@pytest.fixture
def asking(request) -> Iterator:
    made = []

    def of(*parts, options=("--rig", str(PAPER))) -> Explainer:
        made.append(Explainer(lambda: parts, options))
        return made[-1]

    yield of
    for one in made:
        one.close()


def answer(explainer: Explainer, alarms=PARTED) -> str:
    """Wait until it has been told."""
    assert explainer.look(alarms) == ""
    for _ in range(6000):
        if said := explainer.look([]):
            return said
        time.sleep(0.05)
    raise AssertionError("no answer came")


def test_it_says_where_the_model_fails_once_an_hour(asking, fs20_log, tmp_path):
    model = load_model(PAPER / "model.toml").with_values({"nut_friction.power": 30.0})
    save_model(model, tmp_path / "off.toml")
    explainer = asking(fs20_log, options=("--rig", str(PAPER), "--model", str(tmp_path / "off.toml")))
    assert explainer.look(SILENT) == ""
    assert explainer._running is None
    said = answer(explainer)
    assert said.startswith("explained: The model alone is ")
    assert "It lacks " in said
    assert "\n" not in said
    more = answer(explainer, [])
    assert more.startswith("suggested: Something is missing, ")
    assert "\n" not in more
    assert explainer.look(PARTED) == ""
    assert explainer._running is None, "it was asked just now"
    explainer._due = 0.0
    explainer.look(PARTED)
    assert explainer._running is not None


def test_what_cannot_be_read_is_said(asking, tmp_path):
    torn = tmp_path / "torn.log"
    torn.write_text("nothing of ours\n")
    said = answer(asking(torn))
    assert said.startswith("could not be explained: ")
    assert "torn.log" in said


def test_where_nothing_shows_yet_it_says_nothing_and_asks_soon_again(asking, fs20_log, tmp_path):
    """In the first two minutes of a drive."""
    with fs20_log.open() as whole:
        (tmp_path / "early.log").write_text("".join(islice(whole, 3000)))
    explainer = asking(tmp_path / "early.log")
    explainer.look(PARTED)
    explainer._running.wait()
    assert explainer.look([]) == ""
    assert explainer._due < time.monotonic() + SOON_S < time.monotonic() + AGAIN_S


def test_without_a_recording_nothing_is_asked(asking):
    explainer = asking()
    assert explainer.look(PARTED) == ""
    assert explainer._running is None


def test_it_ends_with_the_monitor(asking, fs20_log):
    explainer = asking(fs20_log)
    explainer.look(PARTED)
    running = explainer._running
    explainer.close()
    assert running.poll() is not None
