"""Models: composed, kept as TOML, and refused in one line when they say something wrong."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from estimator.effects import CATALOGUE, STRUCTURE
from estimator.effects.air import StillAir
from estimator.effects.nut import NutBody, NutFriction
from estimator.errors import SetupError
from estimator.filter import Filter
from estimator.model import Prior, Value, file_and_class, model_of
from estimator.rig_folder.model_toml import load_model, save_model
from tests.conftest import stepped

OWN = '''
from estimator.effect import Effect, Param
from estimator.terms import Heat


class CoolantJet(Effect):
    """A jet of coolant takes heat from the middle of the screw.

    q = -P
    """

    power = Param(25.0, "W", lo=0.0, hi=200.0, null=0.0, source="ours")

    def terms(self, p, u, rig):
        yield Heat("screw", -p.power / 20 * rig.screw.overlap(rig.screw.from_mm, rig.screw.to_mm))
'''


def written(folder: Path, text: str, own: str | None = None) -> Path:
    """A model file, and a user's effects beside it."""
    if own is not None:
        (folder / "effects.py").write_text(own)
    path = folder / "model.toml"
    path.write_text(text)
    return path


def test_a_saved_model_is_read_back_unchanged(full, tmp_path):
    changed = full.with_values({
        "nut_friction.power": Value(71.25, 0.5), "still_air.h": Value(7.5, None, True), "anchor_friction.n": 1.5,
        "rotating_convection.m": Value(0.7, 0.01, False), "thermometers.board": -1.25e-5,
        "nut_body.capacity": Value(400.0, prior=Prior(390.0, 50.0), lo=100.0, hi=900.0),
    })  # fmt: skip
    save_model(changed, tmp_path / "m.toml")
    again = load_model(tmp_path / "m.toml")
    assert list(again.effects) == list(changed.effects)
    assert again.values == changed.values
    assert again.name == "m.toml"


def test_what_it_was_fitted_to_and_own_effects_are_kept(tmp_path):
    text = '[about]\nrig = "abc"\n\n[about.fitted_on]\n"FS-20.blf" = "123"\n\n[still_air]\nh = 6.0\n\n'
    path = written(tmp_path, text + '[coolant_jet]\nuse = "effects.py:CoolantJet"\npower = {value = 30, sd = 2}\n', OWN)
    model = load_model(path)
    save_model(model, tmp_path / "again.toml")
    again = load_model(tmp_path / "again.toml")
    assert again.about == {"rig": "abc", "fitted_on": {"FS-20.blf": "123"}}
    assert again.use == {"coolant_jet": "effects.py:CoolantJet"}
    assert again.values == {"still_air.h": Value(6.0), "coolant_jet.power": Value(30.0, 2.0)}


def test_what_a_model_says_of_bounds_and_prior_goes_before_what_its_effect_says(full):
    own = full.with_values({"still_air.h": Value(6.0, prior=Prior(5.0, 0.5), hi=9.0)}).param("still_air.h")
    assert (own.value, own.sd, own.lo, own.hi) == (5.0, 0.5, StillAir.params["h"].lo, 9.0)
    assert full.param("still_air.h") == StillAir.params["h"]


def test_what_nothing_tells_of_goes_with_nothing(full):
    known = full.known(["still_air.h", "conduction.capacity"], np.array([[np.inf, np.inf], [np.inf, 0.01]]))
    assert known.about["covariance"]["correlation"] == [[1.0, 0.0], [0.0, 1.0]]


def test_correlations_are_read_back_so_that_no_variance_is_negative(full, tmp_path):
    """Four digits of a correlation are not enough where parameters are hardly apart."""
    paths = ["still_air.h", "nut_friction.power", "nut_body.g"]
    rho = np.array([[1.0, 0.9999, 0.9999], [0.9999, 1.0, 0.9995], [0.9999, 0.9995, 1.0]])
    assert np.linalg.eigvalsh(rho).min() < 0
    known = full.with_values({path: Value(full[path], 0.1) for path in paths})
    save_model(replace(known, about={"covariance": {"paths": paths, "correlation": rho.tolist()}}), tmp_path / "m.toml")
    doubts = load_model(tmp_path / "m.toml").doubts
    assert np.linalg.eigvalsh(doubts.covariance).min() > -1e-15
    order = [doubts.paths.index(path) for path in paths]
    np.testing.assert_allclose(doubts.covariance[np.ix_(order, order)], 0.01 * rho, atol=2e-6)
    np.testing.assert_allclose(np.diag(doubts.covariance), 0.01, rtol=1e-9)


def test_a_saved_model_explains_itself(tmp_path):
    save_model(model_of([StillAir]), tmp_path / "m.toml")
    head, line = (tmp_path / "m.toml").read_text().strip().splitlines()
    assert head == f"[still_air] # {StillAir.sentence()}"
    assert line == "h = 8.0 # W/(m2 K)"


def test_missing_parameters_have_their_defaults(tmp_path):
    model = load_model(written(tmp_path, "[nut_friction]\npower = {value = 80}\n[still_air]\nh = {fixed = true}\n"))
    assert model["nut_friction.power"] == 80
    assert model["nut_friction.n"] == 1.0
    assert model.values["nut_friction.noise"].fixed
    assert model.values["still_air.h"] == Value(8.0, None, True)
    assert model.free() == ["nut_friction.power", "nut_friction.power_nut", "nut_friction.n"]


FRICTION = "[nut_friction]\n"
ABOUT = "[about.covariance]\n"
ERRORS = [
    ("[nut_frictoin]\n", "no effect 'nut_frictoin'; did you mean 'nut_friction'?"),
    (FRICTION + "powr = 3\n", "nut_friction has no 'powr'; did you mean 'power'?"),
    ("[rotating_convection]\nqqq = 3\n", "rotating_convection has no 'qqq'; known: h, m"),
    (FRICTION + "power = 2001\n", "nut_friction.power = 2001 W is outside 0 ... 2000"),
    (FRICTION + "power = nan\n", "nut_friction.power = nan W is outside 0 ... 2000"),
    (FRICTION + "power = {value = -1}\n", "nut_friction.power = -1 W is outside 0 ... 2000"),
    (FRICTION + 'power = "60"\n', "nut_friction.power: expected a number, got '60'"),
    (FRICTION + "power = true\n", "nut_friction.power: expected a number, got True"),
    (FRICTION + "power = {value = [1]}\n", "nut_friction.power: expected a number, got [1]"),
    (FRICTION + "power = {valeu = 3}\n", "nut_friction.power has no 'valeu'; did you mean 'value'?"),
    (FRICTION + 'power = {sd = "x"}\n', "nut_friction.power.sd: expected a number, got 'x'"),
    (FRICTION + "power = {prior = 60}\n", "nut_friction.power.prior: expected a table with value, sd"),
    (FRICTION + "power = {prior = {value = 60}}\n", "nut_friction.power.prior: 'sd' is missing"),
    (
        FRICTION + "power = {prior = {value = 60, sd = 0}}\n",
        "nut_friction.power.prior.sd is 0, must be 1e-12 ... 1e+12",
    ),
    (
        FRICTION + "power = {prior = {value = -1, sd = 2}}\n",
        "nut_friction.power.prior.value = -1 W is outside 0 ... 2000",
    ),
    (FRICTION + "power = {lo = 70}\n", "nut_friction.power = 60 W is outside 70 ... 2000"),
    (FRICTION + "power = {lo = 70, hi = 50}\n", "nut_friction.power: lo = 70 is not below hi = 50 W"),
    (FRICTION + "power = {fixed = 1}\n", "nut_friction.power.fixed: expected bool, got 1"),
    ("nut_friction = 3\n", "'nut_friction' should be a table, one for each effect"),
    ("about = 3\n[still_air]\n", "'about' is what a fit writes: a table, with a table 'fitted_on'"),
    ("[about]\nfitted_on = 3\n[still_air]\n", "'about' is what a fit writes: a table, with a table 'fitted_on'"),
    (ABOUT + "paths = 3\n[still_air]\n", "about.covariance: 'correlation' is missing"),
    (
        ABOUT + 'paths = ["a"]\ncorrelation = [[1, 0]]\n',
        "about.covariance.correlation: expected 1 rows of 1 numbers, as paths has 1; fit again",
    ),
    (ABOUT + 'paths = ["a"]\ncorrelation = [["x"]]\n', "about.covariance.correlation: expected a number, got 'x'"),
    (
        ABOUT + 'paths = ["a", "b"]\ncorrelation = [[1, 0], [0.5, 1]]\n',
        "about.covariance.correlation: expected 1 from a corner to the other, alike on both sides; fit again",
    ),
    ('[jet]\nuse = "effects.py:CoolantJet"\n', "jet: the effect's name is 'coolant_jet'; call the table so"),
]


@pytest.mark.parametrize(("text", "message"), ERRORS)
def test_what_a_model_file_gets_wrong_is_named(tmp_path, text, message):
    path = written(tmp_path, text, OWN)
    with pytest.raises(SetupError) as caught:
        load_model(path)
    assert str(caught.value) == f"{path}: {message}"


def test_a_missing_or_malformed_file_is_named(tmp_path):
    with pytest.raises(SetupError) as caught:
        load_model(tmp_path / "none.toml")
    assert str(caught.value) == f"{tmp_path / 'none.toml'}: no such file"
    path = written(tmp_path, "[nut_friction\n")
    with pytest.raises(SetupError) as caught:
        load_model(path)
    assert str(caught.value).startswith(f"{path}: not TOML: ")
    with pytest.raises(SetupError) as caught:
        load_model(tmp_path)
    assert str(caught.value) == f"{tmp_path}: not a file"


@pytest.mark.parametrize(
    ("use", "own", "message"),
    [
        ("other.py:Jet", OWN, 'other.py: no such effect file; write use = "effects.py:ClassName"'),
        ("effects.py", OWN, 'effects.py: no such effect file; write use = "effects.py:ClassName"'),
        ("effects.py:CoolantJett", OWN, "effects.py has no effect 'CoolantJett'; did you mean 'CoolantJet'?"),
        (
            "effects.py:Path",
            "from pathlib import Path\n",
            "effects.py has no effect 'Path'; it has none: write a class that is an Effect",
        ),
        ("effects.py:Jet", "1 / 0\n", "effects.py: ZeroDivisionError: division by zero"),
        ("effects.py:Jet", "import sys\nsys.exit(3)\n", "effects.py: SystemExit: 3"),
        (
            "effects.py:Jet",
            "import no_such_thing\n",
            "effects.py: ModuleNotFoundError: No module named 'no_such_thing'",
        ),
    ],
)
def test_what_an_effect_file_gets_wrong_is_named(tmp_path, use, own, message):
    path = written(tmp_path, f'[jet]\nuse = "{use}"\n', own)
    with pytest.raises(SetupError) as caught:
        load_model(path)
    assert str(caught.value) == f"{tmp_path}/{message}"


@pytest.mark.parametrize(
    ("use", "file", "cls"),
    [
        ("effects.py:Rub", "effects.py", "Rub"),
        ("run 12:30/effects.py:Rub", "run 12:30/effects.py", "Rub"),
        ("run 12:30/effects.py", "run 12:30/effects.py", ""),
        ("effects.py", "effects.py", ""),
        ("churning", "churning", ""),
    ],
)
def test_a_folder_may_have_a_colon_in_its_name(use, file, cls):
    assert file_and_class(use) == (file, cls)


def test_plus_and_minus_compose(full):
    model = model_of([StillAir, NutFriction]).with_values({"still_air.h": 5.0})
    more = model + NutBody
    assert list(more.effects) == ["still_air", "nut_friction", "nut_body"]
    assert more["still_air.h"] == 5.0
    assert more["nut_body.capacity"] == 1500.0
    less = more - "nut_friction"
    assert list(less.effects) == ["still_air", "nut_body"]
    assert {path.partition(".")[0] for path in less.values} == {"still_air", "nut_body"}
    assert list(model.effects) == ["still_air", "nut_friction"]
    with pytest.raises(SetupError, match=r"^model has no effect 'nut_frict'; did you mean 'nut_friction'\?$"):
        model - "nut_frict"
    assert (full - "nut_body").values.keys() < full.values.keys()


def test_with_values_changes_a_copy(full):
    other = full.with_values({"still_air.h": 3.0, "nut_friction.power": Value(9.0, 1.0, True)})
    assert (other["still_air.h"], full["still_air.h"]) == (3.0, 8.0)
    assert other.values["nut_friction.power"] == Value(9.0, 1.0, True)
    assert "nut_friction.power" not in other.free()
    assert other.param("still_air.h").unit == "W/(m2 K)"
    with pytest.raises(SetupError, match=r"^full has no 'still_air.hh'; did you mean 'still_air.h'\?$"):
        full.with_values({"still_air.hh": 3.0})


def test_a_users_own_effect_works_in_a_model(tmp_path, small, small_model, driven, live):
    small_model = small_model - "nut_body" - "still_air"  # what is taken out stays out
    save_model(small_model, tmp_path / "model.toml")
    text = (tmp_path / "model.toml").read_text() + '\n[coolant_jet]\nuse = "effects.py:CoolantJet"\npower = 15.0\n'
    cooled = load_model(written(tmp_path, text, OWN))
    assert cooled.effects["coolant_jet"].equation() == "q = -P"
    recording = live(small_model, small, driven(small, 100, (5, 60), stroke=(0.0, 100.0))).recording
    without = stepped(Filter(small_model, small), recording).open_loop_um
    with_jet = stepped(Filter(cooled, small), recording).open_loop_um
    watts = 15.0 * 99  # J taken in 99 s from 200 mm of 3799 J/K per metre; the span is 180 mm
    lost = 12e-6 * watts / 3799 * 1e6 * 180 / 200
    assert (without - with_jet)[-1] == pytest.approx(lost, rel=1e-3)
    assert np.isfinite(with_jet).all()


def test_an_own_effect_that_fails_is_named_with_its_file(tmp_path, small, driven, live, small_model):
    broken = OWN.replace("-p.power / 20", "-p.pwer / 20")
    save_model(small_model, tmp_path / "model.toml")
    text = (tmp_path / "model.toml").read_text() + '\n[coolant_jet]\nuse = "effects.py:CoolantJet"\n'
    model = load_model(written(tmp_path, text, broken))
    recording = live(small_model, small, driven(small, 3)).recording
    with pytest.raises(
        SetupError, match=r"^model.toml: coolant_jet \(effects.py:CoolantJet\): line 15: AttributeError: .*pwer"
    ):
        stepped(Filter(model, small), recording)


def test_the_model_that_ships_is_readable():
    model = load_model(Path(__file__).parents[2] / "recordings" / "model.toml")
    assert {effect.name for effect in STRUCTURE} <= set(model.effects) <= set(CATALOGUE)
    assert len(model.effects) == 19
    assert set(model.about["fitted_on"]) == {"FS-20.blf", "FS-5.blf", "CS-10.blf", "ES-2.5.blf"}
    for path, value in model.values.items():
        assert model.param(path).lo <= value.value <= model.param(path).hi
