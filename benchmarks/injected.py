"""Thermometers that fail in a recording, each in a way that sensors do."""

from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np

from estimator.record import Array, Recording

LOOSE_S, LOOSE_EVERY_S, LOOSE_K = 12.0, 40.0, 30.0
SPIKES, SPIKE_K = 0.05, (2.0, 20.0)
DRIFT_K_S = 3.0 / 3600.0
STEP_C = 0.01  # resolution of the telemeter

Failure = Callable[[Array, Array, np.random.Generator], Array]  # seconds since, healthy readings -> readings


def _stuck(since_s: Array, reading: Array, _: np.random.Generator) -> Array:
    return np.full_like(reading, reading[np.flatnonzero(np.isfinite(reading))[0]])


def _loose(since_s: Array, reading: Array, dice: np.random.Generator) -> Array:
    noise = dice.uniform(-LOOSE_K, LOOSE_K, len(reading))
    return reading + np.where(since_s % LOOSE_EVERY_S < LOOSE_S, noise, 0.0)


def _spikes(since_s: Array, reading: Array, dice: np.random.Generator) -> Array:
    size = dice.uniform(*SPIKE_K, len(reading)) * dice.choice([-1.0, 1.0], len(reading))
    return reading + np.where(dice.random(len(reading)) < SPIKES, size, 0.0)


FAILURES: dict[str, Failure] = {
    "+0.25 K": lambda since_s, reading, _: reading + 0.25,
    "+2 K": lambda since_s, reading, _: reading + 2.0,
    "-20 K": lambda since_s, reading, _: reading - 20.0,
    "0 degC": lambda since_s, reading, _: 0.0 * reading,
    "85 degC": lambda since_s, reading, _: 0.0 * reading + 85.0,
    "stuck": _stuck,
    "loose": _loose,
    "spikes": _spikes,
    "drift": lambda since_s, reading, _: reading + DRIFT_K_S * since_s,
}
NAMED = {  # the words that fit each
    "+0.25 K": ("jumped",),
    "+2 K": ("jumped",),
    "-20 K": ("jumped",),
    "0 degC": ("jumped", "stuck"),
    "85 degC": ("jumped", "stuck"),
    "stuck": ("stuck",),
    "loose": ("loose",),
    "spikes": ("loose",),
    "drift": ("drifting",),
    "swapped": ("jumped", "drifting"),
}


def failing(recording: Recording, kind: str, channels: Sequence[int], at_s: float, seed: int) -> Recording:
    """The recording with some channels failing from a time on; "swapped": two that read what the other should."""
    readings, now = recording.channels.copy(), recording.time_s >= at_s
    since_s, dice = recording.time_s[now] - at_s, np.random.default_rng(seed)
    if kind == "swapped":
        at = np.array(channels)
        readings[np.ix_(now, at)] = readings[np.ix_(now, at[::-1])]
    else:
        for i in channels:
            readings[now, i] = np.round(FAILURES[kind](since_s, readings[now, i], dice) / STEP_C) * STEP_C
    return replace(recording, channels=readings)


def drifting(recording: Recording, channel: int, K_per_h: float, at_s: float) -> Recording:
    """The recording with a channel that drifts from a time on."""
    readings, since_s = recording.channels.copy(), np.maximum(recording.time_s - at_s, 0.0)
    readings[:, channel] = np.round((readings[:, channel] + K_per_h / 3600.0 * since_s) / STEP_C) * STEP_C
    return replace(recording, channels=readings)


INPUT_FAILURES: dict[str, Callable[[Array], Array]] = {
    "0 degC": lambda reading: 0.0 * reading,
    "85 degC": lambda reading: 0.0 * reading + 85.0,
    "+2 K": lambda reading: reading + 2.0,
    "stuck": lambda reading: np.full_like(reading, reading[0]),
    "dead": lambda reading: np.full_like(reading, np.nan),
}


def failing_input(recording: Recording, name: str, kind: str, at_s: float) -> Recording:
    """The recording with a temperature input failing from a time on."""
    column, now = recording.inputs[name].copy(), recording.time_s >= at_s
    column[now] = INPUT_FAILURES[kind](column[now])
    return replace(recording, inputs={**recording.inputs, name: column})


def shifted(recording: Recording, shift_K: Array, at_s: float) -> Recording:
    """The recording with channels (m,) that read another zero from a time on."""
    now = recording.time_s >= at_s
    return replace(recording, channels=recording.channels + now[:, None] * shift_K)
