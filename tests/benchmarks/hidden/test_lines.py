"""Lines of a study that was stopped, and its tables."""

from dataclasses import replace

from benchmarks.hidden import lines as lines_of_study
from benchmarks.hidden import tables
from benchmarks.hidden.cases import Case, asked
from benchmarks.hidden.lines import known, line_of, told
from benchmarks.hidden.outcome import Outcome
from benchmarks.hidden.tables import interval

CASE = Case("one", "same", 7)
FOUND = Outcome(
    "tie", ["churning", "motor_heat"], values={"nut_friction.n": [1.2]}, before=(0.3, 2.5), after=(0.1, 0.2)
)


def test_lines_are_read_back_for_their_commit_only(tmp_path):
    lines = tmp_path / "hidden.jsonl"
    lines.write_text(
        line_of("commit a", CASE, replace(FOUND, said=[])) + "\n" + line_of("commit a", CASE, FOUND) + "\n"
    )
    assert dict(known("commit a", lines))[CASE].said == ["churning", "motor_heat"]
    assert not dict(known("commit b", lines))


def test_lines_of_a_changed_tree_are_not_read_back(tmp_path):
    lines = tmp_path / "hidden.jsonl"
    lines.write_text(line_of("commit a and changes", CASE, FOUND) + "\n")
    assert not dict(known("commit a and changes", lines))


def test_a_study_that_was_stopped_goes_on_where_it_was(tmp_path, monkeypatch):
    monkeypatch.setattr(lines_of_study, "LINES", tmp_path / "hidden.jsonl")
    monkeypatch.setattr(lines_of_study, "commit", lambda: "commit a")
    (tmp_path / "hidden.jsonl").write_text(line_of("commit a", CASE, FOUND) + "\n")
    assert lines_of_study.outcomes([CASE], 1)[CASE].said == FOUND.said


def test_a_case_is_told_in_one_line():
    assert told(CASE, FOUND).startswith("WRONG  one same 7 (machine 228): bar_expansion; tie; churning motor_heat")
    assert "ValueError: no" in told(CASE, Outcome(error="ValueError: no"))


def test_tables_say_what_must_be_and_list_what_is_wrong(monkeypatch):
    named = {case: Outcome("effect", list(case.hidden.names), search_s=30.0) for case in asked(["one"])}
    found = named | {CASE: Outcome(error="ValueError: no"), Case("two", "healthy", 0): FOUND}
    monkeypatch.setattr(tables, "outcomes", lambda cases, processes: found)
    text = tables.markdown()
    assert "| one effect, model fitted to this machine's healthy runs: first, or in a tie of three | 10 of 10" in text
    assert "| one same 7 | 228 | bar_expansion |  |  | ValueError: no |" in text
    assert "| two healthy 0 | 121 |" in text
    assert "event" not in text


def test_shares_have_intervals():
    assert interval(66, 66) == "66 of 66: 100% (95% - 100%)"
    assert interval(0, 0) == "-"
