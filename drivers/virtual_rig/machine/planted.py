"""Names, base and nominal sizes of the effects that the rig can show, and the strengths chosen for one run."""

import difflib
import math
from collections.abc import Collection, Mapping

Strengths = Mapping[str, float]

# Effects of the rig as it stands (strength 1), and what their strength scales. All numbers here are those of the
# paper's machine, number 0; another machine's own stand in its NAME.machine.json.
BASE = {
    "conduction": "scales the conductivity along the screw",
    "still_air": "scales the convection to still air, 3.6 W/(m2 K)",
    "rotating_convection": "scales the extra convection while turning, 25 W/(m2 K) at 20 m/min, ~ omega^0.7",
    "nut_friction": "scales the nut's drag torque, 0.68 N m",
    "nut_body": "scales the conductance between screw and nut body, 3 W/K",
    "anchor_friction": "scales the anchor bearing's torque",
    "free_friction": "scales the free bearing's torque",
    "anchor_housing": "scales the conductance between the anchor seat and its housing, 1.6 W/K",
    "free_housing": "scales the conductance between the free seat and its housing, 1.0 W/K",
    "thermometers": "scales noise, offsets, lag, gains and board drift of the channels; 0 is a perfect thermometer",
    "displacement": "scales wobble, noise, hold error, probe, bar and inertia errors; 0 is a perfect reading",
}

# Effects that are absent (strength 0) unless planted, and what strength 1 is.
PLANTED = {
    "nut_speed_exponent": "+0.2 on the nut's heat ~ omega^1, heat at 20 m/min unchanged",
    "bearing_speed_exponent": "+0.25 on the bearings' heat exponent, heat at 20 m/min unchanged",
    "friction_thinning": "friction falls by 3.1 %/K (nut) and 4.2 %/K (bearings) from what it is at 20 degC",
    "churning": "40 % more nut friction at a fresh start, fading with 600 s of motion",
    "motor_heat": "15 W through the coupling into the motor end while driving",
    "radiation": "emissivity 0.5",
    "base_drift": "air and base at the screw drift by 1 K/h away from what their thermometers show",
    "ambient_gradient": "air 1.5 K warmer at channel 15 and 1.5 K colder at channel 1, from the first sample on",
    "local_heat": "1.5 W into 30 mm of screw at a place chosen by the seed; negative cools",
    "local_heat_driving": "2 W into 30 mm of screw at a place chosen by the seed, only while driving; negative cools",
    "sensor_lag": "15 s more lag in every channel",
    "expansion_error": "the screw expands by 4 % more than 12e-6 1/K",
    "support_yield": "the motor-side reading follows the anchor bearing, 0.54 um/K",
    "probe_expansion": "the probes' own expansion twice more",
    "bar_expansion": "the bar's own expansion twice more",
    "board_drift": "all channels read 0.5 K more per 10 K of board temperature rise",
    "channel_offset": "0.3 K on one channel chosen by the seed, from the first motion on",
    "channel_gain": "5 % of its rise on one channel that warms, chosen by the seed",
    "held_ends": "the free bearing holds the screw along its axis with 700 N/um, the anchor bearing with 900",
    "rubbing_cover": "6 W into 30 mm of screw at a place chosen by the seed at 20 m/min, ~ omega^2",
    "parked_chips": "1.5 W into 30 mm of screw at a place chosen by the seed, at rest after the first motion",
    "stop_blast": "8 W out of 30 mm of screw at a place chosen by the seed after each stop, fading with 300 s",
    "rubbing_wiper": "6 W into 30 mm of screw at a place chosen by the seed at 20 m/min, ~ omega^1.5",
    "wide_jet": "6 W out of 160 mm of screw, most at its motor end, at a place chosen by the seed at 20 m/min, ~ omega",
    "slow_blast": "6 W out of 30 mm of screw at a place chosen by the seed after each stop, fading with 900 s",
    "start_surge": "20 W into 30 mm of screw at a place chosen by the seed at each start, fading with 120 s",
    "slow_soak": "3 W into 30 mm of screw at a place chosen by the seed at rest, coming with 1200 s",
    "drawn_heat": "heat or cold of a place, length, size and law that the seed draws",
}
NEVER_BELOW_0 = {"held_ends"}


def strengths(plant: Mapping[str, float] | None, without: Collection[str]) -> dict[str, float]:
    """The strength of every effect: 1 for the base, 0 for the rest, then what is planted or taken away."""
    plant, usual = plant or {}, dict.fromkeys(BASE, 1.0) | dict.fromkeys(PLANTED, 0.0)
    for name in (*plant, *without):
        if name not in usual:
            near = difflib.get_close_matches(name, usual, n=1, cutoff=0.0)[0]
            raise ValueError(f"unknown effect {name!r}; did you mean {near!r}?")
    for name, strength in plant.items():
        if not math.isfinite(strength):
            raise ValueError(f"plant {name!r}: strength {strength} is not a finite number")
        if name in NEVER_BELOW_0 and strength < 0.0:
            raise ValueError(f"plant {name!r}: strength {strength:g} is below 0, and no bearing's stiffness is")
        if name in without:
            raise ValueError(f"effect {name!r} is both planted and taken away")
    return usual | {name: float(strength) for name, strength in plant.items()} | dict.fromkeys(without, 0.0)
