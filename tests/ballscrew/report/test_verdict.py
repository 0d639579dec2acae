"""Verdicts of a search in words."""

from dataclasses import replace
from types import SimpleNamespace

import pytest

from ballscrew.report.search.verdict import _beside

N = "nut_friction.n"


@pytest.mark.parametrize("verdict", ["effect", "nothing_in_catalogue"])
def test_what_was_held_fixed_and_is_another_is_told_beside_an_effect(verdict, full):
    was, here = (full.with_values({N: replace(full.values[N], value=v, sd=0.008)}) for v in (1.0, 1.103))
    found, given = SimpleNamespace(known=lambda: here), SimpleNamespace(ground=SimpleNamespace(model=was))
    said = _beside(SimpleNamespace(verdict=verdict, found=[found], loosened=[N], as_given=given))
    told = "Held fixed in the model, but nut_friction.n is 1.103 +- 0.008 here, not 1."
    assert said == (told if verdict == "effect" else "")
