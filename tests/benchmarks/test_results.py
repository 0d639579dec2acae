"""What studies measured is kept side by side."""

from benchmarks import __main__ as studies


def test_a_study_s_text_takes_its_place_and_all_else_stays(tmp_path, monkeypatch):
    results = tmp_path / "RESULTS.md"
    monkeypatch.setattr(studies, "RESULTS", results)
    for name, text in (("mesh", "old"), ("machines_first", "a part"), ("live", "told"), ("mesh", "new")):
        studies._keep(name, text)
    kept = {"mesh": "new", "machines_first": "a part", "live": "told"}
    texts = [f"<!-- {name} -->\n\n{text}\n" for name, text in kept.items()]
    assert results.read_text() == "\n".join(["# Measured\n", *texts])
