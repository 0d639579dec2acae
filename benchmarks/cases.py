"""What is hidden in the study of hidden effects: which effect, how strong, on which rig, in which recordings."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

RUNS = (
    (("FS-20", "FS-5", "CS-10", "ES-20"), ("CS-5", "ES-10")),
    (("FS-10", "CS-20", "ES-5", "FS-20"), ("ES-20", "CS-10")),
    (("ES-10", "FS-5", "CS-20", "FS-20"), ("CS-5", "FS-10")),
)
PLANTED = (
    "nut_speed_exponent", "bearing_speed_exponent", "friction_thinning", "churning", "motor_heat", "radiation",
    "base_drift", "ambient_gradient", "local_heat", "local_heat_driving", "sensor_lag", "expansion_error",
    "support_yield", "probe_expansion", "bar_expansion", "board_drift", "channel_offset", "channel_gain",
)  # fmt: skip
TAKEN_OUT = ("rotating_convection", "nut_body", "anchor_housing", "free_housing")
STRANGERS = {"rubbing_cover": ("speed2",), "parked_chips": ("rest",), "stop_blast": ("early_stop",)}
PAIRS = (
    ("friction_thinning", "motor_heat"), ("churning", "base_drift"), ("sensor_lag", "support_yield"),
    ("local_heat", "nut_speed_exponent"), ("ambient_gradient", "expansion_error"), ("motor_heat", "churning"),
    ("bearing_speed_exponent", "channel_offset"), ("local_heat_driving", "bar_expansion"),
    ("base_drift", "friction_thinning"), ("nut_speed_exponent", "board_drift"), ("churning", "support_yield"),
)  # fmt: skip
FIRST_SEED = 21


@dataclass(frozen=True)
class Case:
    """What is hidden: `kind` is the row of the study; `wrong` the speed and position label of the third run."""

    kind: str
    planted: tuple[str, ...]
    strength: float
    seed: int
    runs: int
    wrong: tuple[float, float] = (1.0, 1.0)
    frames: bool = False


def cases() -> Iterator[Case]:
    """All cases, the ones that count first."""
    for n in range(3):
        for i, name in enumerate((*PLANTED, *TAKEN_OUT)):
            yield Case("one", (name,), 1.0, FIRST_SEED + 3 * i + n, n, frames=n == 0 and i < 5)
    for n in range(21):
        yield Case("none", (), 1.0, 140 + n, n % 3)
        yield Case("stranger", (list(STRANGERS)[n % 3],), 1.0, 170 + n, n // 3 % 3)
    for n, pair in enumerate(PAIRS * 2):
        yield Case("two", pair, 1.0, 200 + n, n % 3)
    for n in range(20):
        yield Case("label", (), 1.0, 230 + n, n % 3, (1.2, 1.2 if n % 2 else 1.0))
    for name in (*PLANTED, *TAKEN_OUT):
        yield Case("fitted", (name,), 1.0, 260, 0)
    for strength in (0.5, 2.0):
        for name in PLANTED:
            yield Case(f"strength {strength:g}", (name,), strength, 270, 1)
