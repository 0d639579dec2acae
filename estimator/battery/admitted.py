"""What is asked of the user's own effects each time that a model with them is used: of the battery what takes no time.

Structure never depends on values; and a tick's numbers do not depend on which ticks are asked for together, or a
recording and a bus would not give the same estimate.
"""

from collections.abc import Iterator

import numpy as np

from estimator.battery import exercise
from estimator.inputs.inputs import InputReader, Inputs, nothing
from estimator.inputs.start import Start
from estimator.model import Model
from estimator.network.check import checked_terms
from estimator.network.sound import ALIKE, NUMBERS, Sound, label, skeleton
from estimator.record import Array
from estimator.rig import Rig
from estimator.terms import Term

TICKS = 12  # of the made-up run: rest, and a drive


def admit(model: Model, rig: Rig) -> None:
    """An EffectError where the model does not fit the rig, or an effect of the user's own can be none."""
    checked_terms(model, nothing(rig), rig)
    for name in model.use:
        _same_structure(model, name, rig)
        _tick_by_tick(model, name, rig)


def _same_structure(model: Model, name: str, rig: Rig) -> None:
    """The same terms at the ends of all parameters."""
    usual = skeleton(model.terms_of(name, nothing(rig), rig))
    for key, param in model.effects[name].params.items():
        for value in (param.lo, param.hi, param.null):
            if value is None or not np.isfinite(value):
                continue
            other = model.with_values({f"{name}.{key}": value})
            if skeleton(other.terms_of(name, nothing(rig), rig)) != usual:
                raise model.error(name, f"yields other terms with {key} = {value:g}; {ALIKE}")


def _tick_by_tick(model: Model, name: str, rig: Rig) -> None:
    """The same numbers whether ticks come together or one by one."""
    together = Sound(model, rig).of(name, next(_inputs(rig, TICKS)), forced=False)
    for k, u in enumerate(_inputs(rig, 1)):
        alone = model.terms_of(name, u, rig)
        if skeleton(alone) != skeleton(together):
            raise model.error(name, f"yields other terms while driving than at rest; {ALIKE}")
        for number, (a, b) in enumerate(zip(together, alone, strict=True), start=1):
            for key in NUMBERS[type(a)]:
                if not np.allclose(_of_tick(a, key, k), _of_tick(b, key, 0), rtol=1e-9, atol=1e-12, equal_nan=True):
                    raise model.error(
                        name, f"{label(number, a)}: {key} of a tick changes with the ticks that are "
                        "asked for beside it, or from one time to the next; make it from that tick's inputs"
                    )  # fmt: skip


def _inputs(rig: Rig, at_once: int) -> Iterator[Inputs]:
    """The first ticks of the made-up run, so many at once."""
    run = exercise.run(rig)
    reader = InputReader(rig, Start(exercise.LEVEL_C, 0.0, dict.fromkeys(rig.inputs, 0.0)))
    for first in range(0, TICKS, at_once):
        yield reader.read(run.rows(slice(first, first + at_once)))


def _of_tick(term: Term, key: str, k: int) -> Array:
    """A number of a term in its tick k."""
    array = np.asarray(getattr(term, key))
    return array[min(k, len(array) - 1)] if array.ndim == 2 else array
