"""The small bar with a speed, and recordings that a model of it has lived."""

from collections.abc import Callable
from dataclasses import replace

import pytest

from estimator.effect import Effect, Param
from estimator.effects import CATALOGUE
from estimator.missing_effect.suggest import suggest
from estimator.missing_effect.suggestion import Suggestion
from estimator.model import Model, Prior
from estimator.record import Recording
from estimator.rig import Rig, Signal
from estimator.terms import SCREW, Heat
from estimator.unknown.stand_ins import UnknownHeat
from estimator.work import Runs

DRIVES = (  # rad/s, stroke mm, from s, to s
    (174.5, (0, 100), (20, 400)),
    (87.0, (20, 80), (20, 700)),
    (43.6, (0, 100), (20, 900)),
    (174.5, (40, 90), (20, 500)),
)
SECONDS = 1200
Lives = Callable[..., list[Recording]]


@pytest.fixture(scope="session")
def bar(small: Rig) -> Rig:
    """The small bar with a speed that is an input."""
    return replace(small, inputs={**small.inputs, "speed": Signal(unit="rpm")})


@pytest.fixture(scope="session")
def plain(small_model: Model) -> Model:
    """What is known of the bar: table values that are right for it, as well known as the catalogue says."""
    model = small_model.with_values(
        {"nut_friction.power": 20.0, "nut_friction.power_nut": 10.0, "thermometers.board": 0.0}
    )
    known = {path: value for path, value in model.values.items() if model.param(path).sd}
    priors = {path: Prior(value.value, model.param(path).sd) for path, value in known.items()}
    return model.with_values({path: replace(value, prior=priors[path]) for path, value in known.items()})


@pytest.fixture(scope="session")
def lives(bar, live, driven) -> Lives:
    """lives(model, seed): four runs that the model has lived, with scatter of the sensors."""
    inputs, known = [driven(bar, SECONDS, drive, omega, stroke) for omega, stroke, drive in DRIVES], {}

    def of(model: Model, seed: int = 1) -> list[Recording]:
        asked = f"{seed} {model.effects} {model.values}"
        if asked not in known:
            lived = [live(model, bar, drive, seed=seed + k).recording for k, drive in enumerate(inputs)]
            known[asked] = [replace(recording, name=f"run {k}") for k, recording in enumerate(lived)]
        return [*known[asked]]

    return of


@pytest.fixture(scope="session")
def searched(plain, bar, lives) -> dict[str, tuple[Runs, Suggestion]]:
    """Searches of the whole catalogue: where nothing is missing, and where a channel reads 0.4 K too much."""
    off, found = with_effect(plain, "channel_offset", channel=3, offset=0.4), {}
    for name, truth in (("nothing", plain), ("channel_offset", off)):
        runs = Runs(bar, lives(truth, seed=50)[:2])
        found[name] = runs, suggest(plain, runs, CATALOGUE.values())
    return found


def with_effect(model: Model, name: str, **values: float) -> Model:
    wider = model + (UnknownHeat if name == "unknown_heat" else CATALOGUE[name])
    return wider.with_values({f"{name}.{key}": value for key, value in values.items()})


class Chips(Effect):
    """Hot chips lie on the screw from some time on."""

    since_s = 500.0
    power = Param(3.0, "W", lo=-20.0, hi=20.0)

    def terms(self, p, u, rig):
        over = rig.screw.overlap(120.0, 160.0)
        yield Heat(SCREW, p.power * (u.motion.time_s >= Chips.since_s), over=over / over.sum())
