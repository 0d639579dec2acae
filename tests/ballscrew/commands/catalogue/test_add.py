"""`ballscrew add`: an effect of the catalogue or of one's own in a model file."""

import json

import pytest

from estimator.effects import CATALOGUE
from estimator.rig_folder.model_toml import load_model
from tests.ballscrew.commands.conftest import OWN, SECOND, done, refused
from tests.conftest import ended


def test_an_effect_of_the_catalogue_is_added_at_its_defaults(own_effects):
    before = (own_effects / "model.toml").read_bytes()
    out = done("add", "churning", "model.toml", "-o", "better.toml")
    assert "better.toml: churning added to 13 effects, at its defaults" in out
    old, new = load_model(own_effects / "model.toml"), load_model(own_effects / "better.toml")
    assert new.effects.keys() - old.effects.keys() == {"churning"}
    assert {path: new.values[path] for path in old.values} == dict(old.values)
    assert new["churning.share"] == CATALOGUE["churning"].params["share"].value
    assert new.about == old.about
    assert (own_effects / "model.toml").read_bytes() == before


def test_what_nobody_has_fitted_is_as_uncertain_as_its_source_says(own_effects):
    done("add", "held_ends", "model.toml", "-o", "better.toml")
    model = load_model(own_effects / "better.toml")
    assert {key: model.values[f"held_ends.{key}"].sd for key in ("k_anchor", "k_free", "E")} == {
        "k_anchor": 400.0, "k_free": 400.0, "E": None,
    }  # fmt: skip
    assert {*model.doubts.paths} - {*load_model(own_effects / "model.toml").doubts.paths} == {
        "held_ends.k_anchor", "held_ends.k_free",
    }  # fmt: skip


def test_an_effect_of_ones_own_is_kept_as_seen_from_the_new_model(own_effects):
    (own_effects / "deep" / "er").mkdir(parents=True)
    done("add", "effects.py:CoolantJet", "model.toml", "-o", "deep/er/m.toml")
    assert 'use = "../../effects.py:CoolantJet"' in (own_effects / "deep/er/m.toml").read_text()
    done("add", "effects.py", "model.toml", "-o", "model.toml")
    assert load_model(own_effects / "model.toml").use == {"coolant_jet": "effects.py:CoolantJet"}
    done("add", "churning", "deep/er/m.toml", "-o", "both.toml")
    assert load_model(own_effects / "both.toml").use == {"coolant_jet": "effects.py:CoolantJet"}
    told = json.loads(done("add", "radiation", "both.toml", "-o", "both.toml", "--json"))
    assert told["effect"] == "radiation"
    assert told["parameters"] == {"emissivity": 0.5}


@pytest.mark.parametrize(
    ("words", "text"),
    [
        (
            "nut_body model.toml -o x.toml",
            "model.toml has the effect 'nut_body' already; change its values in the file, or fit them",
        ),
        ("curning model.toml -o x.toml", "no effect 'curning' in the catalogue; did you mean 'churning'?"),
        (
            "churning bare.toml -o x.toml",
            "bare.toml: churning: needs the effect 'nut_friction', which the model has not; add it first",
        ),
        ("churning none.toml -o x.toml", "none.toml: no such file"),
        ("churning model.toml -o none/x.toml", "none/x.toml: there is no folder none"),
        ("two.py model.toml -o x.toml", "two.py has 2 effects; name one of them: two.py:CoolantJet, two.py:Rubbing"),
    ],
)
def test_what_cannot_be_added_is_said_in_a_line(words, text, own_effects):
    (own_effects / "bare.toml").write_text("[conduction]\n[still_air]\n[thermometers]\n")
    (own_effects / "two.py").write_text(OWN + SECOND)
    assert refused("add", *words.split()).startswith(text)
    assert not (own_effects / "x.toml").exists()


def test_an_effect_that_could_do_more_says_what_it_lacks(own_effects):
    (own_effects / "bare.toml").write_text("[conduction]\n[nut_friction]\n[thermometers]\n")
    _, err = ended(0, "add", "friction_thinning", "bare.toml", "-o", "x.toml")
    assert "note: friction_thinning acts on nut_body, anchor_friction, anchor_housing, free_friction, free_hous" in err
