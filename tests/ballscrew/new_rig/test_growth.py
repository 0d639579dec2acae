"""A growth in a CSV that repeats its last reading: told from one that is read in every row, by `init` and `check`."""

from pathlib import Path

import numpy as np
import pytest

from ballscrew.new_rig.growth import held
from estimator.rig_folder.rig_folder import load_rig
from tests.conftest import ended, json_of

ROWS = 400
RISE_K = 5.0 * np.concatenate((np.linspace(0, 1, ROWS // 2), np.linspace(1, 0.2, ROWS // 2)))  # a drive and a stop
READ_UM = np.round(12 * RISE_K + np.random.default_rng(1).normal(0, 0.15, ROWS), 2)
KEPT_UM = np.where(np.arange(ROWS) < ROWS // 2, READ_UM, READ_UM[ROWS // 2 - 1])


@pytest.mark.parametrize(
    ("growth_um", "said"),
    [
        (READ_UM, False), (KEPT_UM, True), (np.round(READ_UM / 5) * 5, False), (np.zeros(ROWS), False),
        (np.repeat(READ_UM[::4], 4), False),
    ],
    ids=["read", "kept through the stop", "steps of 5 um", "not connected", "every fourth row"],
)  # fmt: skip
def test_held_is_what_stays_while_the_screw_grows_by_many_steps(growth_um, said):
    assert held(growth_um, RISE_K) is said


def lab(path: Path, growth_um: np.ndarray) -> Path:
    """A lab CSV: five thermometers, a speed, a growth."""
    rows = [
        f"{2 * k},{','.join(f'{20 + share * rise:.2f}' for share in (0.8, 0.9, 1, 1.1, 1.2))},"
        f"{1000 * (k < ROWS // 2)},{grown:.2f}"
        for k, (rise, grown) in enumerate(zip(RISE_K, growth_um))
    ]
    path.write_text("\n".join(["time_s,T1_C,T2_C,T3_C,T4_C,T5_C,speed_rpm,growth_um", *rows, ""]))
    return path


def test_init_takes_no_repeated_value_for_a_reading_and_check_asks_who_wrote_it_otherwise(tmp_path):
    folder = tmp_path / "rig"
    ended(0, "init", lab(tmp_path / "kept.csv", KEPT_UM), "-o", folder)
    assert load_rig(folder).channels["displacement"].fresh == "growth_um"
    text = (folder / "rig.toml").read_text()
    (folder / "rig.toml").write_text(text.replace(', fresh = "growth_um"', ""))
    (one,) = [one for one in json_of("check", folder) if one["place"] == "rig.toml: channels.displacement"]
    assert one["doubt"].startswith("stays the same to the last digit")
    assert 'fresh = "growth_um"' in one["fix"]


def test_a_growth_that_is_read_in_every_row_has_no_such_word(tmp_path):
    folder = tmp_path / "rig"
    ended(0, "init", lab(tmp_path / "read.csv", READ_UM), "-o", folder)
    assert load_rig(folder).channels["displacement"].fresh is None
