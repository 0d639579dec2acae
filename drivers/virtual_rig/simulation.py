"""From an experiment's name to a finished run."""

from collections.abc import Collection, Mapping
from typing import NamedTuple

import numpy as np

from drivers.virtual_rig.dice import dice
from drivers.virtual_rig.machine.heat import ThermalRig
from drivers.virtual_rig.machine.heaters import Heaters, heaters
from drivers.virtual_rig.machine.motion import Travel
from drivers.virtual_rig.machine.planted import BASE, Strengths, strengths
from drivers.virtual_rig.machine.screw import Growths
from drivers.virtual_rig.machine.weather import weather
from drivers.virtual_rig.population import draw as population
from drivers.virtual_rig.population.constants import Machine
from drivers.virtual_rig.protocol import Experiment, Plan, Progress, stroke
from drivers.virtual_rig.run import Holds, Measured, Run
from drivers.virtual_rig.sensors import environment, telemeter
from drivers.virtual_rig.sensors.probes import freeze_delay_s, probes
from drivers.virtual_rig.sensors.telemeter import Telemeter
from drivers.virtual_rig.sensors.truth import Truth

EXPANSION_ERROR = 0.04


class Began(NamedTuple):
    """Strengths of the effects before and after something begins, s since the first sample."""

    onset_s: float
    at_first: Strengths
    strength: Strengths


def simulate(
    name: str,
    *,
    machine: int = 0,
    seed: int = 1,
    plant: Mapping[str, float] | None = None,
    without: Collection[str] = (),
    onset_s: float = 0.0,
    max_drive_s: float = 7200.0,
    stop_s: float = 3600.0,
    cycles: int = 2,
    seconds: float | None = None,
    progress: Progress | None = None,
) -> Run:
    """Run experiment `name` ("FS-20", "CS-7.5", ...) on the rig with effects planted and taken away.

    `machine` 0 is the paper's, N another of the same build. The same seed is the same rig: its sensors' offsets and the
    places of planted faults. Weather and noise differ from run to run. What is planted heats, cools and disturbs
    channels from `onset_s` on, s since the first sample; weather, expansion and displacement have their effects from
    the first sample on.
    """
    built = population.machine(machine)
    strength = strengths(plant, without)
    sources = heaters(seed, strength, built.sources)
    at_first = strengths({}, without) if onset_s > 0.0 else strength
    rig = ThermalRig(built, at_first, weather(seed, name, strength), heaters(seed, at_first, built.sources))
    rig.change(onset_s, strength, sources)
    expansion = built.screw.expansion * (1.0 + EXPANSION_ERROR * strength["expansion_error"])
    growths = Growths.of(built.anchor.centre, built.free.centre, expansion, strength["held_ends"])
    travel, draw = Travel(stroke(name)), dice(seed, name, "hold")
    experiment = Experiment(rig, probes(seed, strength, built.sensors), travel, growths, draw)
    experiment.run(Plan(max_drive_s, stop_s, cycles, seconds), progress)
    began = Began(onset_s, at_first, strength)
    return _finished(name, seed, built, began, sources, experiment)


def _finished(name: str, seed: int, built: Machine, began: Began, sources: Heaters, experiment: Experiment) -> Run:
    truth = Truth.of(experiment.rows)
    centres, reading = experiment.readings
    sensors = telemeter.telemeter(seed, began.strength, built.sensors)
    measured = _measured(name, seed, sensors, truth, experiment)
    earlier = _measured(name, seed, telemeter.telemeter(seed, began.at_first, built.sensors), truth, experiment)
    shown = np.where(truth.time_s[:, None] < began.onset_s, earlier.channels, measured.channels)
    return Run(
        name=name,
        seed=seed,
        machine=built,
        planted={effect: s for effect, s in began.strength.items() if s != float(effect in BASE)},
        places=sources.places | sensors.places,
        onset_s=began.onset_s,
        truth=truth,
        measured=measured._replace(channels=shown),
        holds=Holds(centres, centres + freeze_delay_s(experiment.travel.stroke), reading),
        travel=experiment.travel,
    )


def _measured(name: str, seed: int, sensors: Telemeter, truth: Truth, experiment: Experiment) -> Measured:
    draw = dice(seed, name, "telemeter")
    motion = experiment.travel.at(truth.time_s)
    moved = motion.moving.cumsum() > 0
    return Measured(
        time_s=truth.time_s,
        channels=sensors.read(truth.channels, truth.board, moved, draw),
        board=telemeter.quantised(truth.board + sensors.noise * draw.standard_normal(truth.board.shape)),
        direct=experiment.probes.direct(truth.gauge, motion, dice(seed, name, "direct")),
        environment=environment.read(truth.environment, seed, name),
    )
