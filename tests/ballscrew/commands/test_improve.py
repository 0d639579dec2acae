"""ballscrew improve: what it prints, writes and draws, with a search that knows its answer; and the views of others."""

import json
from collections.abc import Callable
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from ballscrew.commands.improve import _kept
from ballscrew.report.improvement_report import Outcome, as_json, recordings_kept, steps_table, worse_held_out
from ballscrew.search import effects_to_try
from ballscrew.terminal import Terminal
from ballscrew.workspace import Workspace
from estimator.accuracy.noise_floor import Error
from estimator.effect import Effect
from estimator.hypotheses.ground import Ground
from estimator.hypotheses.hypothesis import Hypothesis
from estimator.hypotheses.panel import Explanation
from estimator.inputs.follower import SPEED_SQUARED
from estimator.missing_effect import improve as search
from estimator.missing_effect.improve import ImprovedModel, Improvement
from estimator.missing_effect.suggestion import Suggestion
from estimator.model import Model, Value
from estimator.rig_folder.model_toml import load_model
from estimator.rig_folder.rig_folder import load_rig
from estimator.unknown.composed import Composed
from estimator.unknown.effect_text import effect_text
from estimator.unknown.stand_ins import Unknown
from estimator.unknown.written import effect_of, name_of, wanted_of
from tests.ballscrew.page.test_section import sound
from tests.conftest import PAPER, ended, json_of
from tests.viz_read import fixed, view_names

OWN = '''
from estimator.effect import Effect, Param
from estimator.terms import SCREW, Heat


class Rub(Effect):
    """Something rubs at the middle."""

    power = Param(4.0, "W", lo=0.0, hi=50.0, null=0.0)

    def terms(self, p, u, rig):
        yield Heat(SCREW, p.power * u.motion.turning, over=rig.screw.overlap(400.0, 500.0))
'''


def hypothesis(model: Model, names: tuple[str, ...] = (), heat_K: float = 0.5) -> Hypothesis:
    """A model judged to leave so much; the first free parameter of each name has been fitted."""
    paths = tuple(next(p for p in model.free() if p.startswith(f"{name}.")) for name in names)
    judged = Explanation(
        (), np.zeros(0), 0.25**2 * np.eye(len(paths)), heat_K, 10.0, Error(heat_K, 4 * heat_K), 4 * heat_K, np.zeros(1),
        np.zeros((2, 1, 1)), heat_K,
    )  # fmt: skip
    return Hypothesis(names, Ground(model, ()), model, paths, judged, told=0.0)


def found(model: Model, verdict: str, effect: type[Effect] | None = None, tie: tuple[str, ...] = ()) -> Suggestion:
    """A verdict, with one effect added where there is one."""
    plain = hypothesis(model)
    best = (hypothesis(model + effect, (effect.name,), 0.1),) if effect else ()
    return Suggestion(verdict, best, tie, plain, plain, plain, uses=())


@pytest.fixture
def searching(monkeypatch: pytest.MonkeyPatch) -> Callable[..., None]:
    """searching(*names): a search that adds these effects one after the other; Ctrl-C where the name is `stop`."""

    def planned(*names: str) -> None:
        left = [*names]

        def answer(model, runs, effects, loose=(), healthy=None, taken=()):
            runs.progress("a stage", 0.5)
            name = left.pop(0) if left else None
            if name == "stop":
                raise KeyboardInterrupt
            if name is None:
                return found(model, "nothing_missing")
            return found(model, "tie", {e.name: e for e in effects}[name], (name, "radiation"))

        monkeypatch.setattr(search, "suggest", answer)

    return planned


def test_effects_are_added_and_everything_is_written_with_pictures_beside_it(searching, fs20_log, tmp_path) -> None:
    searching("churning")
    out = tmp_path / "b.toml"
    words = ["--rig", PAPER, "--model", PAPER / "base.toml", "-o", out, "--json", tmp_path / "b.json"]
    said, _ = ended(0, "improve", fs20_log, *words)
    assert "+ churning" in said
    assert "Nothing is missing" in said
    model, told = load_model(out), json.loads((tmp_path / "b.json").read_text())
    assert "churning" in model.effects
    assert model.values["churning.share"].sd == 0.25
    assert {*load_model(PAPER / "base.toml").about["fitted_on"], "FS-20.log"} == set(model.about["fitted_on"])
    assert [step["added"] for step in told["steps"]] == [None, "churning"]
    assert told["steps"][1]["cross_validated"] == {"temperature_K": 0.1, "elongation_um": 0.4}
    assert (told["verdict"], told["model"]) == ("nothing_missing", str(out))
    before, after = told["felt"]
    assert [one["recordings"] for one in (before, after)] == ["used", "used"]
    assert (before["model"], after["model"]) == ("base.toml", "b.toml")
    assert 0.0 < before["seen"]["rms_um"] < before["seen"]["most_um"] < 1.0
    assert after["silent"]["most_um"] != before["silent"]["most_um"], (
        "40 % more friction is felt: two minutes tell no more"
    )
    most = {way: f"{before[way]['most_um']:.2f} -> {after[way]['most_um']:.2f} um" for way in ("seen", "silent")}
    assert f"at most {most['seen']} off" in said
    assert f"and {most['silent']} if they fall silent at the stop (used)." in said
    text = (tmp_path / "b.md").read_text()
    assert "## What the axis feels" in text
    assert "also used for choosing" in text
    assert "| churning.share | new | 0.4 | 0.25 | 1 |" in text
    assert "| + churning | 0.100 | 0.40 | radiation |" in text
    assert "| in the first ten minutes after a stop |" in text
    fails = text.partition("## Where it fails\n")[2].partition("![")[0]
    assert [line for line in fails.splitlines() if line.startswith("### ")] == ["### base.toml", "### b.toml"]
    assert fails.count("- The model alone is ") == 2
    for what in ("steps", "residuals", "missing-heat"):
        assert f"](b-{what}.png)" in text
        assert (tmp_path / f"b-{what}.png").stat().st_size > 5000
    names = view_names(tmp_path / "b.rrd")
    assert "after: heat missing [W/m], b.toml" in names
    assert "Model alone, rms of temperatures [K]" in names
    assert "Filter in cooldown, at most off [µm], used" in names
    summary = fixed(tmp_path / "b.rrd", "/summary", "TextDocument:text")[0]
    assert "+ churning" in summary
    assert "What the axis feels" in summary


def heat_at_350(model: Model, taken: tuple[str, ...]) -> Suggestion:
    """Something that no catalogue has, composed."""
    rig = load_rig(PAPER)
    unknown = Unknown(SPEED_SQUARED, at_mm=350.0)
    values = {"power": Value(6.0, 0.2), "at": Value(350.0, 2.0), "width": Value(40.0, 9.0), "n": Value(1.8, 0.1)}
    text = effect_text(wanted_of(unknown, name_of(unknown, taken), values, "found in 4 recordings"), rig)
    effect = effect_of(text)
    added = hypothesis(model + effect, (effect.name,), 0.1)
    plain = found(model, "nothing_in_catalogue")
    return replace(plain, composed=Composed(unknown, text, effect, added, plain.before.judged, (), tried=700))


def test_what_no_catalogue_has_is_written_down_and_added(monkeypatch, undrawn, unfelt, short_log, tmp_path) -> None:
    asked = []

    def answer(model, runs, effects, loose=(), healthy=None, taken=()):
        asked.append(taken)
        return found(model, "nothing_missing") if len(asked) > 1 else heat_at_350(model, taken)

    monkeypatch.setattr(search, "suggest", answer)
    file, out = tmp_path / "effects.py", tmp_path / "made" / "b.toml"
    file.write_text(f"{OWN}\n\nclass HeatNear350:\n    pass\n")
    out.parent.mkdir()
    words = ["--rig", PAPER, "--model", PAPER / "base.toml", "-o", out, "--compose", file]
    said, _ = ended(0, "improve", short_log, *words, "--json", tmp_path / "b.json")
    assert {"Rub", "HeatNear350"} <= {*asked[0]}
    assert "+ heat_near350_no2" in said
    assert "As an effect: Something heats the screw around 350 mm, in step with a power of the speed; q = P" in said
    assert f"({file}: HeatNear350No2 written)" in said
    model, told = load_model(out), json.loads((tmp_path / "b.json").read_text())
    assert model.use["heat_near350_no2"] == "../effects.py:HeatNear350No2"
    assert model["heat_near350_no2.n"] == 1.8
    assert told["composed"][0]["effect_file"] == str(file)
    assert told["composed"][0]["text"] in file.read_text()
    report = out.with_suffix(".md").read_text()
    assert "### heat_near350_no2, composed" in report
    assert "```python\nclass HeatNear350No2(Effect):" in report


def test_a_file_that_is_no_python_is_refused_before_the_search(short_log, tmp_path) -> None:
    (tmp_path / "effects.py").write_text("def (:\n")
    words = ["--rig", PAPER, "-o", tmp_path / "b.toml", "--compose", tmp_path / "effects.py"]
    _, err = ended(2, "improve", short_log, *words)
    assert "effects.py: line 1 is not Python" in err


def test_a_model_with_an_effect_of_ones_own_loads_again(searching, undrawn, unfelt, short_log, tmp_path) -> None:
    searching("rub")
    (tmp_path / "mine.py").write_text(OWN)
    (tmp_path / "made").mkdir()
    ended(
        0, "improve", short_log, "--rig", PAPER, "--model", PAPER / "base.toml", "--effects", tmp_path / "mine.py",
        "-o", tmp_path / "made" / "b.toml", "--report", tmp_path / "r.html", "--save", tmp_path / "v.rrd", "--quiet",
    )  # fmt: skip
    model = load_model(tmp_path / "made" / "b.toml")
    assert model.use == {"rub": "../mine.py:Rub"}
    page = (tmp_path / "r.html").read_text()
    sound(page)
    assert page.count('<td class="text">rub</td><td class="text">Something rubs at the middle.</td>') == 1
    assert page.count("data:image/png;base64,") == 1
    assert not list(tmp_path.glob("*.png"))
    assert (tmp_path / "v.rrd").is_file()
    assert "rub" in [one.effect.name for one in effects_to_try(Workspace(Terminal(), load_rig(PAPER), model), ())]


def test_a_run_that_was_left_out_is_none_that_the_model_was_fitted_to():
    model = load_model(PAPER / "base.toml")
    steps = [ImprovedModel(name, (), model, Error(1.0, 1.0), None) for name in ("", "churning")]
    done = search.Improvement((*steps,), None, (), (SimpleNamespace(apart="b"),))
    runs = [SimpleNamespace(name=name, fingerprint=name * 3) for name in "ab"]
    work = SimpleNamespace(recordings=runs, rig=SimpleNamespace(fingerprint=lambda: "r"))
    fitted_on = _kept(done, [], work, "better.toml").about["fitted_on"]
    assert fitted_on == {**model.about["fitted_on"], "a": "aaa"}
    loaded = [SimpleNamespace(recording=run) for run in runs]
    assert recordings_kept(done, loaded) == loaded[:1]


def test_ctrl_c_leaves_the_best_so_far(searching, short_log, tmp_path) -> None:
    searching("churning", "stop")
    out = tmp_path / "b.toml"
    said, _ = ended(130, "improve", short_log, "--rig", PAPER, "--model", PAPER / "base.toml", "-o", out)
    assert "stopped by Ctrl-C" in said
    assert "churning" in load_model(out).effects
    assert not (tmp_path / "b.md").exists()


def test_nothing_missing_leaves_the_model_as_it_was(searching, undrawn, unfelt, short_log, tmp_path) -> None:
    searching()
    out = tmp_path / "b.toml"
    words = ["--held-out", short_log, "--rig", PAPER, "--model", PAPER / "base.toml", "-o", out]
    assert json_of("improve", short_log, *words)["steps"][0]["held_out"]["temperature_K"] > 0
    given = load_model(PAPER / "base.toml")
    assert load_model(out).values == given.values
    assert load_model(out).about == given.about
    assert "none was added or changed" in (tmp_path / "b.md").read_text()
    assert "thermometer − open-loop [K], base.toml" in view_names(tmp_path / "b.rrd")


def test_compare_saves_one_model_or_two(short_log, tmp_path) -> None:
    models = ["--model", PAPER / "base.toml", "--model", PAPER / "model.toml"]
    out, err = ended(0, "compare", short_log, *models, "--save", tmp_path / "c.rrd")
    assert "views: " in out
    names = view_names(tmp_path / "c.rrd")
    assert "after: thermometer − open-loop [K], model.toml" in names
    text = fixed(tmp_path / "c.rrd", "/summary", "TextDocument:text")[0]
    assert "| error, rms | base.toml, K | um | model.toml, K | um |" in text
    _, err = ended(2, "compare", short_log, *models, *models, "--save", tmp_path / "d.rrd")
    assert "one model, or two" in err


def test_suggest_saves_the_model_and_the_best_effect(short_log, tmp_path, monkeypatch) -> None:
    def answer(model, runs, effects, loose=(), healthy=None, taken=()):
        return found(model, "effect", {e.name: e for e in effects}["churning"])

    monkeypatch.setattr("ballscrew.commands.suggest.suggest", answer)
    ended(0, "suggest", short_log, "--model", PAPER / "base.toml", "--save", tmp_path / "s.rrd")
    text = fixed(tmp_path / "s.rrd", "/summary", "TextDocument:text")[0]
    assert "| + churning | 0.100 | 0.40 | it alone | share 0.4 +- 0.2 |" in text
    assert "after: thermometer − open-loop [K], with churning" in view_names(tmp_path / "s.rrd")


def test_diagnose_saves_the_one_model(short_log, tmp_path) -> None:
    ended(0, "diagnose", short_log, "--model", PAPER / "base.toml", "--save", tmp_path / "d.rrd")
    assert "| good enough alone |" in fixed(tmp_path / "d.rrd", "/summary", "TextDocument:text")[0]
    assert "heat missing [W/m], base.toml" in view_names(tmp_path / "d.rrd")


def test_a_step_that_makes_held_out_worse_is_said():
    model = load_model(PAPER / "base.toml")
    errors, kept = (Error(0.05, 0.12), Error(0.03, 0.15), Error(0.03, 0.30)), (True, True, False)
    steps = [ImprovedModel(n, (), model, Error(0.1, 1.0), *one) for n, *one in zip(("", "x", ""), errors, kept)]
    first, last = worse_held_out(steps)
    assert "+ x: held out 0.120 -> 0.150 um, worse: do not use it without more runs" in first
    assert "all fitted again: held out 0.150 -> 0.300 um, worse: not kept" in last
    assert steps_table(steps)[-1][0] == "(all fitted again)"
    assert not worse_held_out([replace(step, held_out=None) for step in steps])
    told = as_json(Improvement(tuple(steps), None, ()), None)
    assert [len(told["steps"]), len(told["not_kept"])] == [2, 1]


def test_what_is_not_kept_is_said_not_to_be_in_the_model(monkeypatch):
    monkeypatch.setattr("ballscrew.report.improvement_report.sentence", lambda verdict, rig: "x is missing.")
    model, work = load_model(PAPER / "base.toml"), SimpleNamespace(rig=None)
    given, added = (ImprovedModel(name, (), model, Error(0.1, 1.0), None) for name in ("", "x"))
    for kept, said in (
        (True, "x is missing."),
        (False, "x is missing. But what is held out it foretells worse: x is not "),
    ):
        found = Improvement((given, replace(added, kept=kept)), None, ())
        assert Outcome(found, None, model, model, (), work, ()).said.startswith(said)
        assert Outcome(found, None, model, model, (), work, ()).said.endswith("." if kept else "in the model.")
