"""Whatever an effect of one's own yields: numbers that are right, or one line with effect, term and tick."""

import dataclasses
import re
import warnings

import numpy as np
import pytest
from hypothesis import given, settings, strategies as st

from estimator.battery import exercise
from estimator.effect import Effect
from estimator.effects.screw import Conduction
from estimator.errors import EffectError
from estimator.model import Model, model_of
from estimator.network.sound import NUMBERS
from estimator.terms import ELONGATION, SCREW, Chain, Expand, Heat, Lag, Link, Read, Shift, Spot, Store

CELLS = 20
GOOD = [
    Store("cup", 50.0, 0.1),
    Chain(SCREW, 1.0),
    Link("cup", "ambient", 1.0),
    Link(SCREW, "cup", np.full(CELLS, 0.1)),
    Heat(SCREW, 5.0, np.full(CELLS, 0.05)),
    Heat("cup", np.array([[5.0]])),
    Read("T1", {SCREW: Spot(5.0), "cup": 0.1}, 0.1),
    Read("T2", {SCREW: np.full(CELLS, 0.05)}, 0.1, 0.0, 0.1, 0.001),
    Read("displacement", {ELONGATION: 1.0}, 0.1),
    Lag("T1", 8.0),
    Expand(0.01),
    Shift("ambient", 1.0),
]
NAN_AT = 40  # ticks


def yielding(*terms) -> Model:
    """A model whose own effect yields these; one that is a function gets the inputs."""

    class Odd(Effect):
        """Says what it is told to say: 1 = 1."""

        def terms(self, p, u, rig):
            yield from (term(u) if callable(term) else term for term in terms)

    return model_of([Conduction, Odd], "m.toml")


def said(model: Model, rig) -> str:
    """What a run of the model ends with; nothing where what is read are numbers."""
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        try:
            read = exercise.open_loop(model, rig, exercise.run(rig))
        except EffectError as error:
            return f"{error.effect}: {error}"
    read = read[:, ~np.isnan(read).all(axis=0)]  # channels that no effect reads
    assert read.size
    assert (np.abs(read) < 1e15).all()
    return ""


def test_terms_that_are_right_are_taken(small):
    assert said(yielding(*GOOD), small) == ""


def sometimes(u, bad: float):
    return np.where(u.motion.time_s == NAN_AT, bad, 1.0)


@pytest.mark.parametrize(
    ("term", "message"),
    [
        (5.0, "term 1 is 5.0; yield Heat(...), Link(...) or another term"),
        ("heat", "term 1 is 'heat'; yield"),
        (None, "term 1 is None; yield"),
        ((SCREW, 5.0), "term 1 is ('screw', 5.0); yield"),
        (Heat(SCREW, np.ones(7)), "term 1, Heat of screw: q has the shape (7,), must be a number or fit (1, 20)"),
        (Heat(SCREW, 1.0, np.ones(21)), "term 1, Heat of screw: over has the shape (21,), must be a number or fit"),
        (Heat(SCREW, "five"), "term 1, Heat of screw: q is 'five', must be a number"),
        (Heat(SCREW, None), "term 1, Heat of screw: q is None, must be a number"),
        (Heat(SCREW, [[1.0], [1.0, 2.0]]), "term 1, Heat of screw: q is [[1.0], [1.0, 2.0]], must be a number"),
        (Heat(SCREW, 1j), "term 1, Heat of screw: q is 0+1j at 0 s (tick 0), must be -1e+09 ... 1e+09 W"),
        (Heat(5, 1.0), "term 1, Heat of 5: node is 5, must be a name"),
        (Heat(SCREW, np.nan), "term 1, Heat of screw: q is nan at 0 s (tick 0), must be -1e+09 ... 1e+09 W"),
        (
            lambda u: Heat(SCREW, sometimes(u, np.nan)),
            "term 1, Heat of screw: q is nan at 40 s (tick 40), must be -1e+09 ... 1e+09 W",
        ),
        (
            lambda u: Heat(SCREW, np.log(u.motion.turning) * np.ones(CELLS)),
            "term 1, Heat of screw: q is -inf at 0 s (tick 0) and 74 ticks more, must be -1e+09 ... 1e+09 W",
        ),
        (
            lambda u: Read("T1", {SCREW: Spot(5.0)}, 0.1, sometimes(u, np.inf)),
            "term 1, Read of T1: offset is inf at 40 s (tick 40), must be -1e+06 ... 1e+06",
        ),
        (
            lambda u: Shift("ambient", sometimes(u, np.nan)),
            "term 1, Shift of ambient: by is nan at 40 s (tick 40), must be -10000 ... 10000",
        ),
        (Store("cup", 0.0, 1.0), "term 1, Store of cup: capacity is 0, must be 1e-06 ... 1e+12 J/K"),
        (Store("cup", -5.0, 1.0), "term 1, Store of cup: capacity is -5, must be 1e-06 ... 1e+12 J/K"),
        (Store("cup", 5.0, 0.0), "term 1, Store of cup: noise is 0, must be 1e-12 ... 1e+09 W/sqrt(Hz)"),
        (Store("start", 5.0, 1.0), "term 1, Store of start: 'start' stores no heat; choose another name"),
        (Link(SCREW, "ambient", -1.0), "term 1, Link of screw - ambient: g is -1, must be 0 ... 1e+09 W/K"),
        (Link(SCREW, "ambient", np.nan), "term 1, Link of screw - ambient: g is nan, must be 0 ... 1e+09 W/K"),
        (Link(SCREW, SCREW, 1.0), "term 1, Link of screw - screw: both its ends are the same"),
        (Link("ambient", "board", 1.0), "a Link is between 'ambient' and 'board', neither of which any effect stores"),
        (Chain(SCREW, -50.0), "term 1, Chain of screw: g is -50, must be 0 ... 1e+09 W/K"),
        (Read("T1", [1.0], 0.1), "term 1, Read of T1: weights are [1.0], must be {node: weight}"),
        (Read("T1", {SCREW: np.full(CELLS, np.nan)}, 0.1), "term 1, Read of T1: the weight of screw is nan, must"),
        (Read("T1", {SCREW: Spot(900.0)}, 0.1), "term 1, Read of T1: a Spot is at 900.0 mm, must be on the screw, 0"),
        (Read("T1", {ELONGATION: 1.0}, 0.1), "term 1, Read of T1: a thermometer reads no elongation"),
        (Read("T1", {}, -0.1), "term 1, Read of T1: sd is -0.1, must be 0 ... 1e+06"),
        (Read("T1", {SCREW: Spot(5.0)}, 0.0), "reads 'T1' without scatter; say its sd in one Read of it"),
        (Lag("T1", -8.0), "term 1, Lag of T1: tau is -8, must be 0 ... 1e+06 s"),
        (Expand(-2.0), "term 1, Expand: error is -2, must be -0.9 ... 9"),
        (Shift("ambient", 1.0, np.ones(3)), "term 1, Shift of ambient: over has the shape (3,), must be a number or"),
        (
            lambda u: Heat(SCREW, 1.0) if u.omega.any() else Expand(0.0),
            "yields other terms than at first; structure never depends on values",
        ),
    ],
)
def test_what_cannot_be_is_named_with_its_term_and_tick(small, term, message):
    found = said(yielding(term, Read("T3", {SCREW: Spot(5.0)}, 0.1)), small)
    assert found.startswith(f"odd: m.toml: odd: {message}")


@pytest.mark.parametrize(("terms", "message"), [((), "yields no term"), ((Lag("T1", 1.0),) * 3000, "yields more than")])
def test_none_and_too_many_are_named(small, terms, message):
    assert said(yielding(*terms), small).startswith(f"odd: m.toml: odd: {message}")


def test_one_that_yields_for_ever_ends(small):
    class Odd(Effect):
        """Never ends: 1 = 1."""

        def terms(self, p, u, rig):
            while True:
                yield Heat(SCREW, 0.0)

    found = said(model_of([Conduction, Odd], "m.toml"), small)
    assert found == "odd: m.toml: odd: yields more than 2000 terms; does it end?"


def test_inputs_cannot_be_written_by_who_reads_them(small):
    def writes(u):
        u["ambient"][:] = 0.0

    with pytest.raises(ValueError, match="read-only"):
        said(yielding(writes), small)


NUMBER = st.one_of(
    st.floats(),
    st.sampled_from([np.nan, np.inf, -np.inf, 0.0, -1.0, 1.0, 1e300, -1e300, 1e-300, 1e9, -1e9, 10**400, True, 1j]),
)
SHAPE = st.sampled_from([(1,), (1, 1), (CELLS,), (1, CELLS), (CELLS, 1), (3,), (0,), (2, 1), (1, 1, 1), (CELLS - 1,)])
WRONG = st.one_of(
    NUMBER,
    st.tuples(SHAPE, st.floats(allow_subnormal=False)).map(lambda made: np.full(*made)),
    st.sampled_from(
        ["", "x", SCREW, "cup", "ambient", "start", ELONGATION, "T1", None, (), [], {}, [[1.0], []], "a\nb"]
    ),
    st.dictionaries(st.sampled_from([SCREW, "cup", ELONGATION, "nix"]), NUMBER, max_size=2),
)


@settings(max_examples=250)
@given(data=st.data())
def test_any_value_anywhere_gives_numbers_or_one_line(small, data):
    """In a whole run, without a warning: the value is right, or it is named with its effect."""
    at = data.draw(st.integers(0, len(GOOD) - 1))
    key = data.draw(st.sampled_from([field.name for field in dataclasses.fields(GOOD[at])]))
    value = data.draw(WRONG)
    sudden = key in NUMBERS[type(GOOD[at])] and NUMBERS[type(GOOD[at])][key].forced and data.draw(st.booleans())
    terms = list(GOOD)
    terms[at] = dataclasses.replace(GOOD[at], **{key: value})
    if sudden:
        terms[at] = lambda u: dataclasses.replace(GOOD[at], **({key: value} if u.omega.any() else {}))
    found = said(yielding(*terms), small)
    assert re.fullmatch(r"odd: m\.toml: odd: .*|", found)
    assert len(found) < 500
