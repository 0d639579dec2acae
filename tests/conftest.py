"""What several test files share: rigs, drives without measurements, and recordings made by a model itself."""

import contextlib
import io
import json
import os
import sys
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any
from unittest import mock

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")  # as the command does: two threads take up to ten times as long
os.environ.pop("PYTHONDONTWRITEBYTECODE", None)  # or every process that a test starts compiles every module anew

import numpy as np
import pytest
from hypothesis import settings

import drivers.canbus  # noqa: F401 before the virtual rig, which loads all that python-can loads
from ballscrew.cli import main
from ballscrew.workers import processes
from drivers.virtual_rig import simulate, write
from estimator.effects import CATALOGUE
from estimator.effects.air import StillAir
from estimator.effects.length import Displacement
from estimator.effects.nut import NutBody, NutFriction
from estimator.effects.readings import Thermometers
from estimator.effects.screw import Conduction
from estimator.faults import machine
from estimator.filter import Filter
from estimator.inputs.inputs import Inputs
from estimator.inputs.start import Start
from estimator.model import Model, Value, model_of
from estimator.network.forcing import Forcing
from estimator.record import Array, Recording
from estimator.rig import Channel, Rig, Signal
from estimator.rig_folder.model_toml import load_model
from estimator.rig_folder.rig_folder import load_rig
from estimator.screw import Nut, Screw
from estimator.state import report
from estimator.state.open_loop import OpenLoop
from estimator.state.prior import BODY_SD_K
from estimator.step import Step, Track
from estimator.terms import Term

sys.dont_write_bytecode = False  # or pytest rewrites the assertions of every test file anew in every worker
settings.register_profile("ballscrew", deadline=None, derandomize=True)  # the same on every machine, however slow
settings.load_profile("ballscrew")

ROOT = Path(__file__).parents[1]
PAPER, EXAMPLES = ROOT / "recordings", ROOT / "examples"
ROD, TWO = EXAMPLES / "heated_rod", EXAMPLES / "two_heaters"
RIG = load_rig(PAPER)
FAST = 174.5  # rad/s: 20 m/min
WITH_BEARINGS = {
    "bearing_speed_exponent",
    "support_yield",
    "motor_heat",
    "held_ends",
    "housing_shells",
}  # as all that are named after a bearing
SMALL = [  # effects that the small rig can serve
    effect
    for effect in CATALOGUE.values()
    if "anchor" not in effect.name and "free" not in effect.name and effect.name not in WITH_BEARINGS
]
SMALL_VALUES = {"local_heat.at": 70.0, "local_heat_driving.at": 120.0}  # on its 200 mm
FREED = ("nut_friction.n", "thermometers.tau", "displacement.probe", "displacement.bar")  # as in the shipped model


@pytest.fixture(scope="session")
def rig() -> Rig:
    """The paper's rig."""
    return RIG


def at_defaults() -> Model:
    """The effects of the shipped model, at their defaults; a fit may change what it may change there."""
    shipped = load_model(PAPER / "model.toml")
    defaults = {
        path: replace(value, value=shipped.param(path).value, sd=None) for path, value in shipped.values.items()
    }
    return replace(shipped.with_values(defaults), about={}, name="full", folder=None)


def terms_of(name: str, rig: Rig, u: Inputs, **values: float) -> list[Term]:
    """What an effect of the catalogue yields in a model of all effects, at defaults but for these values of its own."""
    model = model_of(list(CATALOGUE.values()))
    return list(model.with_values({f"{name}.{key}": value for key, value in values.items()}).terms_of(name, u, rig))


@pytest.fixture(scope="session")
def shipped() -> Model:
    """The model that ships with it."""
    return load_model(PAPER / "model.toml")


@pytest.fixture(scope="session")
def paper(shipped) -> tuple[Rig, Model]:
    """The paper's rig with the model that ships with it."""
    return RIG, shipped


@pytest.fixture
def no_other_machine(monkeypatch) -> None:
    """The machine is the model's for sure: nothing is off by more than its parameters' sd."""
    monkeypatch.setattr(machine, "ANOTHER", 1e-12)


@pytest.fixture
def no_lies(monkeypatch) -> None:
    """Lengths are right for sure: what they lead the estimate by is no doubt."""
    monkeypatch.setattr(report, "LENGTHS_LIE", 0.0)


@pytest.fixture(scope="session")
def full() -> Model:
    """What the shipped model says, at the defaults of its effects."""
    return at_defaults()


@pytest.fixture(scope="session")
def every() -> Model:
    """Every effect of the catalogue, at its defaults."""
    return model_of(list(CATALOGUE.values()), "every")


@pytest.fixture(scope="session")
def small() -> Rig:
    """A bar of 200 mm with three knots, four thermometers, a nut and a displacement."""
    screw = Screw(0, 200, 40, 17, cells=20, knots_mm=(0, 90, 200), span_from_mm=10, span_to_mm=190)
    channels = {f"T{i}": Channel(at_mm=x) for i, x in enumerate((5.0, 60.0, 110.0, 195.0), start=1)}
    channels["displacement"] = Channel(unit="um")
    inputs = {name: Signal() for name in ("ambient", "nut", "probe", "bar", "board")}
    inputs["position"] = Signal(unit="mm")
    return Rig("small", 1.0, channels, inputs, screw, Nut(50, 150), folder=Path("small"))


@pytest.fixture(scope="session")
def half(small) -> Rig:
    """The same at two ticks a second: what forgets the tick is right at one of 1 s, and wrong here."""
    return replace(small, name="half", tick_s=0.5)


@pytest.fixture(scope="session")
def small_model() -> Model:
    """What heats and cools the small bar: four temperatures in all, nut included."""
    model = model_of([Conduction, StillAir, NutFriction, NutBody, Thermometers, Displacement], "small")
    free = {path: Value(model[path]) for path in FREED}
    return model.with_values({**free, "displacement.zero_sd": 2.0, "thermometers.board": Value(0.004)})


def _driven(
    rig: Rig,
    seconds: float,
    drive: tuple[float, float] = (20, 10**9),
    omega: float = FAST,
    stroke: tuple[float, float] = (0.0, 400.0),
) -> Recording:
    """Rest, a drive to and fro over the stroke (mm), rest: all inputs at 22 degC and no channel measured."""
    ticks = round(seconds / rig.tick_s)
    time_s = (np.arange(ticks) + 1.0) * rig.tick_s
    instants = time_s[:, None] + ((np.arange(40) + 0.5) / 40 - 1) * rig.tick_s
    lo, hi = stroke
    way = np.clip(instants - drive[0], 0, drive[1] - drive[0]) * omega / (2 * np.pi) * 12
    position = lo + (hi - lo) - np.abs((hi - lo) - way % (2 * (hi - lo)))
    reach, travels = rig.nut.length_mm / 2, np.ptp(position, axis=1) > 0
    centre = rig.nut.centre(position)
    coverage = rig.screw.overlap(centre[:, -1] - reach, centre[:, -1] + reach)
    coverage[travels] = rig.screw.overlap(centre[travels] - reach, centre[travels] + reach).mean(axis=1)
    inputs = {name: np.full(ticks, 22.0) for name in rig.inputs}
    inputs["position"] = position[:, -1]
    moving = (time_s > drive[0]) & (time_s <= drive[1])
    gaps = np.full((ticks, len(rig.names)), np.nan)
    return Recording("driven", time_s, gaps, np.zeros_like(gaps), inputs, np.where(moving, omega, 0.0), coverage)


@pytest.fixture(scope="session")
def driven() -> Callable[..., Recording]:
    """driven(rig, seconds, drive, omega, stroke): the inputs of a run that is still to be lived."""
    return _driven


@dataclass(frozen=True)
class Lived:
    """A recording made by a model, with its true elongation (K,) um and temperatures of the states (K, n)."""

    recording: Recording
    elongation_um: Array
    states: Array


def _live(
    model: Model, rig: Rig, drive: Recording, seed: int | None = None, process: bool = False, expansion: float = 0.0
) -> Lived:
    """Let the model live through the drive from 22 degC; with a seed its sensors scatter.

    With `process` the heat scatters too, thermometers differ by constants, and the bodies are not quite as warm as the
    screw at the start. The screw grows by a share `expansion` of the model's open-loop growth more, as far as a
    thermometer can tell unseen.
    A displacement reading comes every third tick, with an unknown zero of 5 um, and a direct one at rest, where the rig
    has it.
    """
    dice = np.random.default_rng(seed)
    forcing = Forcing(model, rig, Start(22.0, 0.0, dict.fromkeys(rig.inputs, 0.0)))
    ticks, readings = forcing.ticks(forcing.read(drive)), forcing.readings
    start = np.full(forcing.place.size, 22.0)
    if process:
        start[len(forcing.place.knots_mm) :] += BODY_SD_K * dice.standard_normal(len(forcing.place.bodies))
    run = OpenLoop(start, readings, rig.tick_s)
    factor: dict[int, Array] = {}
    states, channels = np.empty((len(drive), len(start))), np.empty_like(drive.channels)
    screw = rig.screw
    growth = screw.growth(*screw.span_mm) @ forcing.place.shapes[forcing.place.nodes["screw"]]
    alone, more = start.copy(), np.zeros(len(drive))
    drawn = readings.zero_sd * dice.standard_normal(len(readings.sd)) if process else np.zeros(len(readings.sd))
    zero = np.where(readings.spans > 0, 5.0, drawn)
    for k, (regime, heat) in enumerate(zip(ticks.regime, ticks.heat, strict=True)):
        if k:  # the first sample is the start
            transition = forcing.transition(regime)
            run.step(transition, heat)
            alone = transition.F @ alone + transition.J @ heat
            more[k] = expansion * growth @ (alone - start)
            if process:
                if regime not in factor:
                    factor[regime] = np.linalg.cholesky(transition.Q)
                run.z = run.z + factor[regime] @ dice.standard_normal(len(start))
                zero = zero + readings.zero_walk * np.sqrt(rig.tick_s) * dice.standard_normal(len(zero))
        states[k] = run.z
        spot = run.reading if not process else readings.rows @ run.z
        channels[k] = spot + ticks.offset[k] + zero + readings.spans * more[k]
    if seed is not None:
        channels += readings.sd * dice.standard_normal(channels.shape)
    unread = np.arange(len(drive)) % 3 > 0
    channels[np.ix_(unread, readings.spans > 0)] = np.nan
    grown, inputs = (states - start) @ growth + more, drive.inputs
    if "displacement_direct" in inputs:
        inputs = inputs | {"displacement_direct": np.where(drive.omega > 0.0, np.nan, grown - 40.0)}
    return Lived(replace(drive, channels=channels, inputs=inputs), grown, states)


@pytest.fixture(scope="session")
def live() -> Callable[..., Lived]:
    """live(model, rig, drive, seed, process, expansion): what the channels would read if the model were the truth."""
    return _live


def stepped(filter_: Filter, recording: Recording, before: Sequence[Step] = ()) -> Track:
    """All ticks of a recording, one step after the other, as live takes them; `before`, those that it has taken."""
    steps = [*before, *(filter_.step(sample) for sample in recording)]
    view = filter_.run.view if filter_.run else None
    return Track.of(steps, view.x_mm if view else np.empty(0), view.bodies if view else ())


def ballscrew(*words: object) -> tuple[int, str, str]:
    """Exit status, stdout and stderr of `ballscrew WORDS`, as on one core: one thread, no process but this one."""
    out, err = io.StringIO(), io.StringIO()
    command = mock.patch.object(sys, "argv", ["ballscrew", *map(str, words)])
    alone, ended = mock.patch.object(processes.os, "cpu_count", return_value=1), pytest.raises(SystemExit)
    with command, alone, contextlib.redirect_stdout(out), contextlib.redirect_stderr(err), ended as status:
        main()
    return status.value.code or 0, out.getvalue(), err.getvalue()


def ended(status: int, *words: object) -> tuple[str, str]:
    """stdout and stderr of `ballscrew WORDS`, which must end with this status."""
    found, out, err = ballscrew(*words)
    assert found == status, err
    return out, err


def json_of(*words: object) -> Any:
    """What `ballscrew WORDS --json`, which must succeed, prints as JSON."""
    return json.loads(ended(0, *words, "--json")[0])


@pytest.fixture(scope="session")
def fs20_log(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """FS-20 of the virtual rig, first drive and some of its stop, as a CAN log with its truth beside it."""
    return write(simulate("FS-20", cycles=1, seconds=420.0), tmp_path_factory.mktemp("fs20") / "FS-20.log")
