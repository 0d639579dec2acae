"""A study that was stopped goes on where it was, as long as nothing has changed since."""

import pytest

from benchmarks import kept
from benchmarks.judged import Case

CASE = Case(3, "four", ("quick",))


def study(case: Case) -> dict[str, float]:
    return {"fit_s": float(case.machine)}


@pytest.mark.parametrize(("then", "goes_on"), [("commit a", True), ("commit b", False)])
def test_lines_are_read_back_for_their_commit_only(then, goes_on, tmp_path, monkeypatch):
    monkeypatch.setattr(kept, "commit", lambda: "commit a")
    found = kept.outcomes(tmp_path / "a.jsonl", [CASE], {}, study, lambda *_: "", processes=1)
    assert found == {CASE: {"fit_s": 3.0}}
    monkeypatch.setattr(kept, "commit", lambda: then)
    assert [out for _, out in kept.known(tmp_path / "a.jsonl")] == [{"fit_s": 3.0}] * goes_on


def test_lines_of_a_changed_tree_are_not_read_back(tmp_path, monkeypatch):
    monkeypatch.setattr(kept, "commit", lambda: "commit a and changes")
    kept.outcomes(tmp_path / "a.jsonl", [CASE], {}, study, lambda *_: "", processes=1)
    assert not [*kept.known(tmp_path / "a.jsonl")]


def test_what_is_found_already_is_not_done_again(tmp_path):
    found = {CASE: {"fit_s": 1.0}}
    assert kept.outcomes(tmp_path / "a.jsonl", [CASE], found, study, lambda *_: "") == found
