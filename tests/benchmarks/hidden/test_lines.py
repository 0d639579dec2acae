"""Cases in words, and the tables of the study."""

from benchmarks.hidden import tables
from benchmarks.hidden.cases import Case, asked
from benchmarks.hidden.lines import told
from benchmarks.hidden.outcome import Outcome
from benchmarks.hidden.tables import interval

CASE = Case("one", "same", 7)
FOUND = Outcome(
    "tie", ["churning", "motor_heat"], values={"nut_friction.n": [1.2]}, before=(0.3, 2.5), after=(0.1, 0.2)
)


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
