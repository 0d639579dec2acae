"""ballscrew report: the page, and that it says what review says."""

import json
import re
import shutil

import pytest

from tests.ballscrew.page.test_section import sound
from tests.conftest import ballscrew as run, ended, json_of

NAME = "<b onload=x> um & co.log"


@pytest.fixture(scope="module")
def made(fs20_log, tmp_path_factory):
    """Page, JSON and terminal of a report on a recording with a hostile name."""
    folder = tmp_path_factory.mktemp("page")
    log = shutil.copy(fs20_log, folder / NAME)
    shutil.copy(fs20_log.with_name("FS-20.truth.csv"), folder / NAME.replace(".log", ".truth.csv"))
    (folder / "torn.blf").write_bytes(b"LOGG and nothing more")
    words = ["--iso230-3", "--at", "390,10", "--mute", "T03:100-130", "-o", folder / "p.html"]
    status, out, err = run("report", log, folder / "torn.blf", *words, "--json", folder / "p.json")
    assert (status, err.count("torn.blf"), err.count("\n")) == (1, 1, 1)
    return (folder / "p.html").read_text(encoding="utf-8"), json.loads((folder / "p.json").read_text()), out


def test_the_page_is_whole_and_its_parts_stand_in_order(made):
    text, told, out = made
    sound(text)
    titles = [re.sub("<.*?>", "", one) for one in re.findall(r"<h2>(.*?)</h2>", text)]
    name = "&lt;b onload=x&gt; µm &amp; co.log"
    expected = ["Rig and recordings", "How far the estimates are off", name, "Drift of the axis after ISO 230-3"]
    assert titles == [*expected, "The model", "What was not used"]
    assert text.count("<figure>") == 5
    assert told["report"].endswith("p.html")
    assert out.splitlines()[-1] == f"report: {told['report']}"
    assert all(sentence in out for sentence in told["headline"])
    assert told["headline"][-1].startswith("As asked without T03:100-130. Could not be used: 1. No sensor failed.")
    assert re.search(r"<li>\S*torn.blf: ", text)
    assert '<td class="text">left out as asked</td><td class="text">T03:100-130</td>' in text
    assert re.search(r'<td class="text">T03</td><td>127</td><td>9\d.\d%</td><td>31</td>.*>31 × muted</td>', text)


def test_its_figures_are_those_of_the_review(made, fs20_log):
    text, told, _ = made
    assert told["overall"] == json_of("review", fs20_log, "--mute", "T03:100-130", "--quiet")["overall"]
    low, high = told["overall"]["filter"]["band_um"]
    assert f"within {low:+.2f} .. {high:+.2f} µm" in text
    row = re.search(r'<td class="text">filter</td><td>(.*?)</td><td>(.*?)</td><td>(.*?)</td>', text)
    assert row.groups() == (f"{low:+.2f}", f"{high:+.2f}", f"{high - low:.2f}")


def test_the_drift_is_told_to_programs_too(made):
    (one,) = made[1]["iso230_3"]
    assert (one["by"], one["positions_mm"]) == ("truth", [10.0, 390.0])
    assert [spell["name"] for spell in one["spells"]] == ["heating 1", "cooling 1"]
    near, far = one["spells"][0]["positions"]
    assert 5 < near["whole_um"] < far["whole_um"] < 45
    assert far["left_whole_um"] < 0.03 * far["whole_um"]


@pytest.mark.parametrize(
    ("words", "said"),
    [
        ("--at 10,390", "--at names the positions of --iso230-3: give both"),
        ("--iso230-3 --at 10,ab", "write two or three positions"),
        ("-o none/p.html", "there is no folder none"),
        ("-o FS-20.blf", "-o FS-20.blf: a page is written as .html"),
    ],
)
def test_wrong_words_end_before_the_work(words, said, fs20_log):
    _, err = ended(2, "report", fs20_log, *words.split())
    assert said in err


def test_a_rig_without_a_screw_has_a_page_and_no_drift(tmp_path):
    csv = "examples/heated_rod/slow.csv"
    out, err = ended(0, "report", csv, "-o", tmp_path / "rod.html")
    text = (tmp_path / "rod.html").read_text()
    sound(text)
    assert "No reference: how far the elongation is off is not known." in out
    assert "elongation not judged" in text
    status, _, err = run("report", csv, "--iso230-3", "-o", tmp_path / "rod.html")
    assert (status, "has no [screw] with a [nut]" in err) == (2, True)
