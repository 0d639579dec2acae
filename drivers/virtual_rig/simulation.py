"""From an experiment's name to a finished run."""

from collections.abc import Collection, Mapping

from drivers.virtual_rig.dice import dice
from drivers.virtual_rig.experiments import stroke
from drivers.virtual_rig.machine.heat import Rig
from drivers.virtual_rig.machine.heaters import Heaters, heaters
from drivers.virtual_rig.machine.motion import Travel
from drivers.virtual_rig.machine.planted import BASE, Strengths, strengths
from drivers.virtual_rig.machine.weather import weather
from drivers.virtual_rig.protocol import Plan, Progress, Session, session
from drivers.virtual_rig.run import Holds, Measured, Run
from drivers.virtual_rig.sensors import environment, telemeter
from drivers.virtual_rig.sensors.probes import freeze_delay_s, probes
from drivers.virtual_rig.sensors.telemeter import Telemeter
from drivers.virtual_rig.sensors.truth import Truth

EXPANSION_ERROR = 0.04


def simulate(
    name: str,
    *,
    seed: int = 1,
    plant: Mapping[str, float] | None = None,
    without: Collection[str] = (),
    max_drive_s: float = 7200.0,
    stop_s: float = 3600.0,
    cycles: int = 2,
    seconds: float | None = None,
    progress: Progress | None = None,
) -> Run:
    """Run experiment `name` ("FS-20", "CS-7.5", ...) on the rig with effects planted and taken away.

    The same seed is the same rig: its sensors' errors and the places of planted faults. Weather and noise differ
    from run to run.
    """
    strength = strengths(plant, without)
    travel = Travel(stroke(name))
    sources = heaters(seed, strength)
    rig = Rig(strength, weather(seed, name, strength), sources)
    under_way = session(seed, name, rig, probes(seed, strength), travel, EXPANSION_ERROR * strength["expansion_error"])
    under_way.run(Plan(max_drive_s, stop_s, cycles, seconds), progress)
    return _finished(name, seed, strength, sources, under_way)


def _finished(name: str, seed: int, strength: Strengths, sources: Heaters, under_way: Session) -> Run:
    truth = Truth.of(under_way.rows)
    sensors = telemeter.telemeter(seed, strength)
    return Run(
        name=name,
        seed=seed,
        planted={effect: s for effect, s in strength.items() if s != float(effect in BASE)},
        places=sources.places | sensors.places,
        truth=truth,
        profile=under_way.profile,
        measured=_measured(name, seed, sensors, truth, under_way),
        holds=_holds(under_way),
        travel=under_way.travel,
    )


def _measured(name: str, seed: int, sensors: Telemeter, truth: Truth, under_way: Session) -> Measured:
    draw = dice(seed, name, "telemeter")
    motion = under_way.travel.at(truth.time_s)
    moved = motion.moving.cumsum() > 0
    return Measured(
        time_s=truth.time_s,
        channels=sensors.read(truth.channels, truth.board, moved, draw),
        board=telemeter.quantised(truth.board + sensors.noise * draw.standard_normal(truth.board.shape)),
        direct=under_way.probes.direct(truth.gauge, motion, dice(seed, name, "direct")),
        environment=environment.read(truth.environment, seed, name),
    )


def _holds(under_way: Session) -> Holds:
    centres, reading = under_way.readings
    delay = freeze_delay_s(under_way.travel.stroke)
    return Holds(centres, centres + delay, reading)
