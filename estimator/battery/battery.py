"""The battery that every effect must pass, the catalogue's and a user's own: what filter, fit and search rely on.

Each check yields what is wrong, a sentence each; an effect passes where none does. A parameter that this rig and this
model leave without influence is a remark only where nobody fits it, or where it acts on what the model lacks.
"""

import warnings
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass, fields, replace

import numpy as np

from estimator.battery.bench import Bench, without
from estimator.effect import Effect
from estimator.errors import BallscrewError
from estimator.model import Model
from estimator.network import assemble
from estimator.network.check import checked_terms
from estimator.network.layout import layout
from estimator.record import Array
from estimator.rig import Rig
from estimator.terms import Heat, Term

LONGEST = 130  # characters of a sentence
ROUNDING, SEEN = 1e-9, 1e-3  # K or um between two readings
STEP = 1e-30
LENGTH_MM = 100.0  # a place matters on the scale of a width, not of how far it is from zero


@dataclass(frozen=True)
class Finding:
    """One check of one effect; `detail` says what is wrong, or what is worth saying."""

    check: str
    ok: bool
    detail: str = ""


class Remark(str):
    """What a check has to say that is not wrong."""


def battery(effect: type[Effect], model: Model, rig: Rig) -> list[Finding]:
    """Run all checks on an effect in a model of the rig, whether that has the effect already or not.

    What the effect needs of other effects must be in the model. One that does not fit the rig is not checked further.
    """
    bench, findings = Bench(effect, without(model, effect.name, rig), rig), []
    for name in CHECKS:
        findings.append(_finding(name, bench))
        if name == "fits the rig" and not findings[-1].ok:
            break
    return findings


def _finding(name: str, bench: Bench) -> Finding:
    """A user's own code may raise anything: that is a finding too, as is an imaginary part that is lost on the way."""
    try:
        with warnings.catch_warnings(), np.errstate(all="ignore"):
            warnings.simplefilter("error", np.exceptions.ComplexWarning)
            problems = list(CHECKS[name](bench))
    except BallscrewError as error:
        problems = [str(error)]
    except Exception as error:
        problems = [f"{type(error).__name__}: {error}"]
    return Finding(name, all(isinstance(problem, Remark) for problem in problems), "; ".join(problems))


def documented(bench: Bench) -> Iterator[str]:
    """A sentence, an equation, and for each parameter its unit, source and finite bounds around default and null."""
    effect = bench.effect
    if not effect.sentence().endswith(".") or len(effect.sentence()) >= LONGEST:
        yield f"the docstring's first line is no sentence of one line that ends with '.': {effect.sentence()!r}"
    if "=" not in effect.equation():
        yield "the docstring has no equation: a line with '=' below the sentence"
    for key, param in effect.params.items():
        yield from (f"{key} has no {word}" for word in ("unit", "source") if not getattr(param, word))
        if not (np.isfinite([param.lo, param.hi]).all() and param.lo < param.hi):
            yield f"{key} has no finite bounds: lo = {param.lo:g}, hi = {param.hi:g}"
        if param.null is not None and not param.lo <= param.null <= param.hi:
            yield f"{key}: the null {param.null:g} is outside {param.lo:g} ... {param.hi:g}"


def fits(bench: Bench) -> Iterable[str]:
    """Model and effect together are a model of the rig, which has all that they name."""
    checked_terms(bench.model, bench.u, bench.rig)
    bench.reads(bench.model)
    return ()


def invisible(bench: Bench) -> Iterator[str]:
    """With all nulls the readings are those of the model without the effect."""
    if bench.nulls:
        apart = _apart(bench.at_null, bench.reads(bench.base))
        if not apart <= ROUNDING:
            yield f"with its parameters at null the readings are {apart:.2g} K or um off those without the effect"


def seen(bench: Bench) -> Iterator[str]:
    """Off each null the readings are others."""
    params = bench.effect.params
    places = {
        key: params[key].hi if params[key].value == null else params[key].value for key, null in bench.nulls.items()
    }
    unseen = []
    for key, off in places.items():
        if _apart(bench.reads(bench.at(**{**bench.nulls, key: off})), bench.at_null) <= SEEN:
            unseen.append(key)
    nodes = layout(list(bench.model.terms(bench.u, bench.rig)), bench.rig).nodes
    spared = any(isinstance(term, Heat) and term.node not in nodes for term in bench.terms())
    for key in unseen:
        excused = params[key].fixed or (spared and len(unseen) < len(places))
        yield (Remark if excused else str)(f"{key} = {places[key]:g} leaves nothing in any reading")


def _apart(a: Array, b: Array) -> float:
    """How far readings are off others, at most, in the channels that those have."""
    return float(np.where(np.isnan(b), 0.0, np.abs(a - b)).max(initial=0.0))


def structure(bench: Bench) -> Iterator[str]:
    """Values change numbers, not which terms there are, nor their shapes."""
    usual = [_skeleton(term) for term in bench.terms()]
    ends = {k: [v for v in (p.lo, p.hi, p.null) if v is not None] for k, p in bench.effect.params.items()}
    alone = [{key: value} for key, values in ends.items() for value in values]
    for values in (*alone, *({key: choice[i] for key, choice in ends.items()} for i in (0, 1, -1))):
        if [_skeleton(term) for term in bench.terms(**values)] != usual:
            at = ", ".join(f"{key} = {value:g}" for key, value in values.items())
            yield f"with {at} it yields other terms than by default; yield the same, with zeros in them"
            return


def _skeleton(term: Term) -> object:
    """A term without its numbers."""
    names = [(f.name, value) for f in fields(term) if isinstance(value := getattr(term, f.name), (str, bool))]
    shapes = [np.shape(getattr(term, key, 0.0)) for key in ("capacity", "g", "q", "tau", "over")]
    return type(term), names, tuple(getattr(term, "weights", ())), shapes


def derivative(bench: Bench) -> Iterator[str]:
    """By complex step it is that of central differences, in all that the effect says and all that is made of it."""
    place = layout(list(bench.model.terms(bench.u, bench.rig)), bench.rig)
    for key, param in bench.effect.params.items():
        value = param.value or 0.01
        step = 1e-4 * (min(abs(value), LENGTH_MM) if param.unit == "mm" else abs(value))
        slope, up, down = (bench.numbers(place, **{key: x}) for x in (value + STEP * 1j, value + step, value - step))
        moves = False
        for name, number in slope.items():
            known = np.isfinite(down[name])
            if not known.all() and name != "sd":  # of a channel that no effect reads
                yield f"{name} is no number at {key} = {value - step:g}"
                break
            found, true = number.imag[known] / STEP, (up[name] - down[name])[known] / (2 * step)
            rounding = 1e-13 * abs(up[name][known]).max(initial=0.0) / step
            moves |= bool(np.any(true))
            if not np.allclose(found, true, rtol=0, atol=1e-5 * abs(true).max(initial=0.0) + rounding):
                yield f"{key}: the complex step of {name} is not its slope; write the equation in functions like np.exp"
                break
        if not moves and param.over != "channel":
            yield (Remark if param.fixed else str)(f"{key} changes nothing")


def order(bench: Bench) -> Iterator[str]:
    """Readings are the same wherever in the model the effect stands."""
    usual, model = bench.reads(bench.model), bench.model
    for names in (sorted(model.effects, key=lambda name: name != bench.effect.name), list(model.effects)[::-1]):
        other = replace(model, effects={name: model.effects[name] for name in names})
        if not (apart := _apart(bench.reads(other), usual)) <= ROUNDING:
            yield f"readings change by {apart:.2g} K or um with the order of the effects"
            return


def conserving(bench: Bench) -> Iterator[str]:
    """What its links take out of the nodes goes to inputs, and nowhere else; no link conducts backwards."""
    place = layout(list(bench.model.terms(bench.u, bench.rig)), bench.rig, reduced=False)
    own = assemble.network_of(bench.terms(), place, len(bench.u))
    outside = own.inflow[:, :, : len(place.inputs)].sum(axis=2)
    for axis in (1, 2):
        if not np.allclose(own.conductance.sum(axis=axis), outside, rtol=0, atol=1e-9):
            yield "its links lose heat on the way"
            return
    if not (outside >= -ROUNDING).all():
        yield "a link conducts backwards: its g is below 0"


CHECKS: dict[str, Callable[[Bench], Iterable[str]]] = {
    "documented": documented,
    "fits the rig": fits,
    "invisible at null": invisible,
    "seen off null": seen,
    "structure": structure,
    "derivative": derivative,
    "order": order,
    "heat is kept": conserving,
}
