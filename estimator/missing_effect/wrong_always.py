"""An input that is wrong in all recordings alike, as an effect that sets it right: a candidate beside all others.

Like the stand-ins these are never added to a model: the signal has to be set right where it comes from.
"""

from collections.abc import Iterable, Iterator
from dataclasses import replace
from types import SimpleNamespace
from typing import ClassVar

from estimator.batch.trials import Trials
from estimator.effect import Effect, Param
from estimator.effects.elsewhere import Elsewhere
from estimator.hypotheses.candidates import Candidate
from estimator.hypotheses.hypothesis import Hypothesis
from estimator.inputs.inputs import Inputs
from estimator.inputs.moved import moved
from estimator.inputs.start import SENSOR_K
from estimator.missing_effect.wrong_input import ALL, KELVIN, LOG, MM, Mislabel
from estimator.model import Value
from estimator.rig import Rig
from estimator.terms import Shift, Term


class WrongInput(Effect):
    """One input is told wrong in all recordings.

    signal  which;   least: an error below which it is not called wrong
    """

    signal: ClassVar[str] = ""
    least: ClassVar[float] = 0.0


class PositionShift(Elsewhere, WrongInput):
    """The position of the table is told with another zero than the rig file means.

    position = told - shift
    """

    signal, least = "position", MM.sure

    def terms(self, p: SimpleNamespace, u: Inputs, rig: Rig) -> Iterator[Term]:
        rig.the_nut()
        yield Shift("position", -p.shift)


class PositionScale(WrongInput):
    """The position of the table is told in another scale.

    position = told / (1 + error)
    """

    signal, least = "position", LOG.sure
    error = Param(0.1, "1", lo=-0.6, hi=1.5, null=0.0, source="by search")

    def inputs(self, p: SimpleNamespace, u: Inputs, rig: Rig) -> Inputs:
        return replace(u, coverage=moved(u.coverage, rig, share=1.0 / (1.0 + p.error))) if p.error else u

    def terms(self, p: SimpleNamespace, u: Inputs, rig: Rig) -> Iterator[Term]:
        rig.the_nut()
        yield Shift("position", u["position"] * (1.0 / (1.0 + p.error) - 1.0))


class SpeedScale(WrongInput):
    """The speed is told in another scale: of the motor before a gear, or in another unit.

    speed = told / (1 + error)
    """

    signal, least = "speed", LOG.sure
    error = Param(0.1, "1", lo=-0.6, hi=1.5, null=0.0, source="by search")

    def inputs(self, p: SimpleNamespace, u: Inputs, rig: Rig) -> Inputs:
        return replace(u, omega=u.omega / (1.0 + p.error)) if p.error else u

    def terms(self, p: SimpleNamespace, u: Inputs, rig: Rig) -> Iterator[Term]:
        rig.the_screw()
        yield Shift("speed", u["speed"] * (1.0 / (1.0 + p.error) - 1.0))


class AmbientShift(WrongInput):
    """The thermometer of the air is off by the same in all recordings.

    T_air = T_air,measured - shift
    """

    signal, least = "ambient", KELVIN.sure
    shift = Param(1.0, "K", lo=-20.0, hi=20.0, null=0.0, source="by search")

    def terms(self, p: SimpleNamespace, u: Inputs, rig: Rig) -> Iterator[Term]:
        yield Shift("ambient", -p.shift)


WRONG_INPUTS: tuple[type[WrongInput], ...] = (PositionShift, PositionScale, SpeedScale, AmbientShift)
BY_NAME = {each.name: each for each in WRONG_INPUTS}


def wrong_inputs(trials: Trials) -> list[type[WrongInput]]:
    """Those that recordings leave open.

    A start sets an air's thermometer right that is off by up to `SENSOR_K` beside a rig in equilibrium: it may be wrong
    only where it was further off in every run.
    """
    starts = [
        abs(trial.drive.inputs["ambient"][0, 0] - trial.run.start.level_C)
        for trial in trials
        if "ambient" in trial.rig.inputs
    ]
    open_ = min(starts, default=0.0) > SENSOR_K
    return [each for each in WRONG_INPUTS if open_ or each is not AmbientShift]


def is_input(candidate: Candidate) -> bool:
    """Whether a candidate is a wrong input."""
    return candidate.name in BY_NAME


def inputs_in(names: Iterable[str]) -> list[str]:
    """Which of some effects are wrong inputs."""
    return [name for name in names if name in BY_NAME]


def too_small(h: Hypothesis) -> bool:
    """Whether an input of it is hardly wrong."""
    return any(abs(value.value) < BY_NAME[path.partition(".")[0]].least for path, value in _errors(h))


def told(h: Hypothesis) -> Mislabel:
    """The wrong input of a hypothesis that has one."""
    ((path, value),) = _errors(h)
    name, _, kind = path.partition(".")
    unit, size = h.model.param(path).unit, float(value.value)
    return Mislabel(
        ALL, BY_NAME[name].signal, 1.0 + size if kind == "error" else 1.0, size if unit == "K" else 0.0, h.judged,
        size if unit == "mm" else 0.0, tuple(other for other in h.names if other != name),
    )  # fmt: skip


def _errors(h: Hypothesis) -> list[tuple[str, Value]]:
    return [(path, value) for path, value in h.model.values.items() if path.partition(".")[0] in inputs_in(h.names)]
