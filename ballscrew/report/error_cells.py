"""Errors of temperatures and elongation as cells of a table, and how far ahead they look, in words and for programs."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from estimator.accuracy.noise_floor import Error

HORIZONS = {"one_step": "one tick ahead", "ahead": "10 minutes ahead", "open_loop": "model alone (open loop)"}
KEYS = {"one_step": "one_step", "ahead": "ahead_10min", "open_loop": "open_loop"}


def number(value: float, digits: int = 2) -> str:
    """A number; nothing where there is none."""
    return f"{value:.{digits}f}" if np.isfinite(value) else ""


def cells(errors: Sequence[Error]) -> list[str]:
    """K and um of each error."""
    return [cell for e in errors for cell in (number(e.temperature_K, 3), number(e.elongation_um))]


def by_horizon(errors: Mapping[str, Error]) -> dict[str, Mapping[str, float]]:
    """Errors by horizon for programs."""
    return {KEYS[key]: vars(error) for key, error in errors.items()}
