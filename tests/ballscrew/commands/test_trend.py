"""ballscrew trend: a table, sentences, and JSON as programs read it."""

import json

import pytest

from tests.conftest import PAPER, ballscrew, ended


@pytest.fixture(scope="module")
def days(tmp_path_factory, fs20_log):
    """Six short recordings, cut from one at different ends."""
    lines, folder = fs20_log.read_text().splitlines(keepends=True), tmp_path_factory.mktemp("days")
    first = float(lines[0][1:].partition(")")[0])
    for k in range(6):
        kept = [line for line in lines if float(line[1:].partition(")")[0]) < first + 150.0 + 15.0 * k]
        (folder / f"day{k}.log").write_text("".join(kept))
    return folder


def test_every_parameter_of_every_run_is_told(days):
    status, out, err = ballscrew("trend", days, "--rig", PAPER, "--json")
    assert (status, out.startswith("{")) == (0, True)
    told = json.loads(out)
    assert set(told) == {"parameters", "drifts", "sentences"}
    of_nut = told["parameters"]["nut_friction.power"]
    assert [one["recording"] for one in of_nut] == [f"day{k}.log" for k in range(6)]
    assert all(set(one) == {"recording", "start", "value", "sd"} and one["sd"] > 0 for one in of_nut)
    assert told["drifts"] == []
    assert "they are taken in the order given" in told["sentences"][0]
    assert f"These 6 runs are too few to tell that one of the {len(told['parameters'])}" in told["sentences"][1]
    assert "nut_friction.power" in err


def test_a_few_recordings_are_no_trend(days):
    _, err = ended(1, "trend", days / "day0.log", days / "day1.log", "--rig", PAPER)
    assert "a trend needs 6 recordings of one machine at least; here are 2" in err
