"""What can be hidden, and what it is to a model: an effect of the catalogue, another value of one of the model's own
parameters, or nothing that any catalogue has."""

from collections.abc import Callable, Mapping

import numpy as np

from benchmarks.machine_truth import bore_delay_s
from drivers.virtual_rig.machine.air import EMISSIVITY
from drivers.virtual_rig.machine.bearings import PALMGREN, SPEED_EXPONENT as OF_BEARINGS
from drivers.virtual_rig.machine.nut import SPEED_EXPONENT as OF_NUT
from drivers.virtual_rig.population.constants import PAPER, Anchor, Machine
from drivers.virtual_rig.population.draw import RADIATION
from drivers.virtual_rig.sensors.probes import EXTRA
from drivers.virtual_rig.sensors.telemeter import EXTRA_BOARD_DRIFT, EXTRA_LAG_S
from drivers.virtual_rig.simulation import EXPANSION_ERROR

READINGS = (
    "sensor_lag", "expansion_error", "support_yield", "probe_expansion", "bar_expansion", "board_drift",
    "channel_offset", "channel_gain",
)  # fmt: skip
PLANTED = (
    "nut_speed_exponent", "bearing_speed_exponent", "friction_thinning", "churning", "motor_heat", "radiation",
    "base_drift", "ambient_gradient", "local_heat", "local_heat_driving", *READINGS,
)  # fmt: skip
TAKEN_OUT = ("rotating_convection", "nut_body", "anchor_housing", "free_housing")  # every rig has them
STRANGERS = {  # in no catalogue, of shapes in place or time that no stand-in has; what is nearest to each of them
    "rubbing_wiper": ("speed", "speed2"),
    "wide_jet": ("speed",),
    "slow_blast": ("early_stop", "slow_stop", "rest"),
    "start_surge": ("early_drive", "speed_early_drive"),
    "slow_soak": ("rest",),
}
DRAWN = {  # what a composed effect may follow, by the kind of law that was drawn (virtual_rig.machine.drawn)
    "power": ("drive", "speed_root", "speed", "speed2"),
    "gate": ("drive", "speed_root", "speed", "speed2"),
    "surge": ("early_drive", "speed_early_drive", "speed_fading"),
    "blast": ("early_stop", "slow_stop"),
    "soak": ("late_rest", "rest"),
    "two": ("always", "drive", "rest"),
}
EVENTS = (  # what begins within a run: the nut greased anew, coolant, a lid opened, a bearing that is worn
    {"nut_friction": 1.3}, {"local_heat": -4.0}, {"still_air": 2.5}, {"anchor_friction": 1.6},
)  # fmt: skip
BY_LAW = {  # what a machine has by a law of its own is there, planted or not
    "thinning_friction": "friction_thinning",
    "churning_grease": "churning",
    "radiating_surface": "radiation",
    "coarse_gains": "channel_gain",
}

Values = tuple[float, float]  # of a parameter on the machine as it is, and what an effect of strength 1 adds


def kind_of(name: str) -> str:
    """Whether an effect heats, or only shifts readings."""
    return "reading" if name in READINGS else "heat"


def _exponent(bearing: Anchor) -> float:
    """Of the heat, d ln(M omega) / d ln(omega), at half the reference speed."""
    powers = np.array([bearing.power, bearing.power or PALMGREN])
    torques = np.array([bearing.load_torque, bearing.viscous_torque]) * 0.5**powers
    return 1.0 + float(powers @ torques / torques.sum())


def _of_both(one: Machine, what: str) -> float:
    """The mean of the bearings: the model has one rate for them."""
    return float(np.mean([getattr(bearing, what) for bearing in (one.anchor, one.free)]))


def _expansion(one: Machine) -> Values:
    share = one.screw.expansion / PAPER.screw.expansion
    return share - 1.0, EXPANSION_ERROR * share


OWN: Mapping[str, Mapping[str, Callable[[Machine], Values]]] = {
    "nut_speed_exponent": {"nut_friction.n": lambda one: (1.0 + one.nut.speed_exponent, OF_NUT)},
    "bearing_speed_exponent": {
        "anchor_friction.n": lambda one: (_exponent(one.anchor), OF_BEARINGS),
        "free_friction.n": lambda one: (_exponent(one.free), OF_BEARINGS),
    },
    "friction_thinning": {
        "warm_grease.nut": lambda one: (one.nut.thinning, one.nut.planted_thinning),
        "warm_grease.bearings": lambda one: (_of_both(one, "thinning"), _of_both(one, "planted_thinning")),
    },
    "radiation": {
        "still_air.h": lambda one: (one.air.still + RADIATION * one.air.emissivity, RADIATION * EMISSIVITY),
    },
    "sensor_lag": {"thermometers.tau": lambda one: (float(np.mean(one.sensors.lags)) + bore_delay_s(one), EXTRA_LAG_S)},
    "board_drift": {"thermometers.board": lambda one: (one.sensors.board_drift, EXTRA_BOARD_DRIFT)},
    "probe_expansion": {
        "displacement.probe": lambda one: (one.sensors.probe_um_per_K, EXTRA * one.sensors.probe_um_per_K)
    },
    "bar_expansion": {"displacement.bar": lambda one: (one.sensors.bar_um_per_K, EXTRA * one.sensors.bar_um_per_K)},
    "expansion_error": {"expansion_error.error": _expansion},
}
