"""What is true of a machine of the virtual rig: its runs, kept between studies, and its parameters as the model's.

A parameter has a true value where the law of the machine is the model's; where the machine follows another one (its
`laws`), it has none.
"""

import hashlib
import math
import pickle
from functools import cache
from pathlib import Path

import numpy as np

import drivers.virtual_rig
from drivers.virtual_rig import Run, simulate
from drivers.virtual_rig.machine.geometry import OMEGA_20
from drivers.virtual_rig.machine.screw import AREA_M2, BORE_SHARE, mean_above_bore
from drivers.virtual_rig.population.constants import PAPER, Anchor, Machine, Nut
from estimator.effects.friction import WarmGrease

USUAL_K = 4.0  # at which the model's still air is what it is
WARMTH_C = WarmGrease.params["reference"].value  # at which the model's friction is
KEPT = Path(__file__).parent / "machines"
FIRST_SEED = 500  # machine N has the sensors and the weather of seed 500 + N
UNLIKE = {  # laws of a machine with which an effect, or one of its parameters, has no counterpart
    "nut_friction": ("churning_grease",),
    "nut_body": ("growing_contact",),
    "still_air": ("radiating_surface",),
    "free_convection": ("radiating_surface",),
    "rotating_convection": ("late_rotation",),
    "anchor_friction.power_housing": ("two_lump_housings",),
    "anchor_housing": ("two_lump_housings",),
    "free_friction.power_housing": ("two_lump_housings",),
    "free_housing": ("two_lump_housings",),
}


def run_of(number: int, name: str) -> Run:
    """Experiment `name` of a machine; simulated once as long as the virtual rig's code is the same."""
    file = KEPT / _code() / f"{number}-{name}.pickle"
    if not file.exists():
        file.parent.mkdir(parents=True, exist_ok=True)
        made = file.with_suffix(".part")
        made.write_bytes(pickle.dumps(simulate(name, machine=number, seed=FIRST_SEED + number)))
        made.replace(file)
    return pickle.loads(file.read_bytes())


@cache
def _code() -> str:
    """Short hash of the virtual rig's code."""
    files = sorted(Path(drivers.virtual_rig.__file__).parent.rglob("*.py"))
    return hashlib.sha256(b"".join(file.read_bytes() for file in files)).hexdigest()[:12]


def true_parameters(one: Machine) -> dict[str, float]:
    """By path in the model, those whose law is the machine's; in the model's units, powers at the reference speed."""
    return {path: value for path, value in _counterparts(one).items() if not _unlike(path) & set(one.laws)}


def _unlike(path: str) -> set[str]:
    return {law for name in (path, path.partition(".")[0]) for law in UNLIKE.get(name, ())}


def _counterparts(one: Machine) -> dict[str, float]:
    nut, sensors = one.nut, one.sensors
    friction = nut.drag_torque * OMEGA_20 * _thinned(nut)
    return {
        "conduction.scale": one.screw.conductivity / PAPER.screw.conductivity,
        "conduction.capacity": one.screw.volumetric_heat / PAPER.screw.volumetric_heat,
        "still_air.h": one.air.still * (USUAL_K / one.air.rise) ** one.air.growth,
        "free_convection.n": one.air.growth,
        "rotating_convection.h": one.air.rotating,
        "rotating_convection.m": one.air.exponent,
        "nut_friction.power": nut.into_screw * friction,
        "nut_friction.power_nut": (1.0 - nut.into_screw) * friction,
        "nut_friction.n": 1.0 + nut.speed_exponent,
        "warm_grease.nut": nut.thinning,
        "warm_grease.bearings": (one.anchor.thinning + one.free.thinning) / 2.0,
        "nut_body.capacity": nut.capacity,
        "nut_body.g": nut.contact,
        "nut_body.g_air": nut.to_table,
        **_support("anchor", one.anchor),
        **_support("free", one.free),
        "thermometers.tau": float(np.mean(sensors.lags)) + bore_delay_s(one),
        "thermometers.board": sensors.board_drift,
        "displacement.probe": sensors.probe_um_per_K,
        "displacement.bar": sensors.bar_um_per_K,
        "expansion_error.error": one.screw.expansion / PAPER.screw.expansion - 1.0,
    }


def _support(name: str, bearing: Anchor) -> dict[str, float]:
    """An exponent only where friction is one power of the speed; no way to the base, which has the air beside it."""
    friction = (bearing.load_torque + bearing.viscous_torque) * OMEGA_20 * _thinned(bearing)
    return {
        f"{name}_friction.power": bearing.into_screw * friction,
        f"{name}_friction.power_housing": (1.0 - bearing.into_screw) * friction,
        **({f"{name}_friction.n": 1.0 + bearing.power} if bearing.power else {}),
        f"{name}_housing.capacity": bearing.capacity,
        f"{name}_housing.g": bearing.contact,
    }


def _thinned(part: Nut | Anchor) -> float:
    """Friction at the temperature at which the model's is as told, against that at the grease's own."""
    return math.exp(-part.thinning * (WARMTH_C - part.grease))


def bore_delay_s(one: Machine) -> float:
    """How long the wall at the thermometers' tips is behind the mean of the section, which the model's lag holds too.

    rho c A (mean - bore) / q' (1 - depth / (1 - share of the bore's layer))   s
    """
    reach = 1.0 - one.sensors.depth / (1.0 - BORE_SHARE)
    return one.screw.volumetric_heat * AREA_M2 * mean_above_bore(one.screw.conductivity) * reach
