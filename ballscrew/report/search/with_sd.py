"""A value and how well it is known, as a person reads it."""

from __future__ import annotations

import numpy as np

from estimator.model import Value


def with_sd(value: Value, unit: str) -> str:
    """A value to the first digit of its sd: 923 +- 46 s, 2.1 +- 0.2; of a sd that is not known, to three digits."""
    per = "" if unit == "1" else f" {unit}"
    if not value.sd or not np.isfinite(value.sd):
        return f"{value.value:.3g}{per}"
    digits = max(0, -int(np.floor(np.log10(value.sd))))
    return f"{value.value:.{digits}f} +- {value.sd:.{digits}f}{per}"
