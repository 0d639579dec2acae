"""What `review --table` writes is what review found, in the units it says, without pandas."""

import os
import shutil
import subprocess
import sys
from pathlib import Path

import numpy as np
import pyarrow as pa
import pytest
from pyarrow import csv, parquet

import ballscrew as face
from drivers.recordings import find_recordings
from tests.conftest import PAPER, ROD, ballscrew, ended, json_of


@pytest.fixture(scope="module")
def found(short_log):
    rig, model = face.load_rig(PAPER), face.load_model(PAPER / "model.toml")
    return rig, face.review(face.read(short_log, rig), rig, model)


def test_a_parquet_holds_what_review_found_to_the_bit_with_units(short_log, found, tmp_path):
    rig, review = found
    path = tmp_path / "ticks.parquet"
    assert ballscrew("review", short_log, "--rig", PAPER, "--table", path)[0] == 0
    rows, track = parquet.read_table(path), review.track
    assert rows.column_names[:10] == [
        "time_s", "mode", "elongation_um", "sigma_um", "smoothed_um", "smoothed_sigma_um", "open_loop_um",
        "error_at_table_um", "error_at_table_sd_um", "nis",
    ]  # fmt: skip
    for name, series in {
        "time_s": track.time_s, "elongation_um": track.elongation_um, "sigma_um": track.sigma_um,
        "smoothed_um": review.estimates["smoothed"], "open_loop_um": track.open_loop_um, "nis": track.nis,
        "error_at_table_um": track.error_at_table_um, "reference_um": review.reference,
        "T07_innovation": track.innovation[:, 6], "displacement_measured": track.measured[:, 15],
        "input_speed": review.recording.inputs["speed"],
    }.items():  # fmt: skip
        np.testing.assert_array_equal(rows[name].to_numpy(), series, err_msg=name)
    assert rows["T07_used"].to_pylist() == track.fused[:, 6].tolist()
    assert set(rows["mode"].to_pylist()) <= {"predict", "update", "coasting"}
    units = {name: rows.schema.field(name).metadata[b"unit"].decode() for name in rows.column_names}
    assert [units[n] for n in ("T07_measured", "T07_innovation_sd", "displacement_innovation", "x_100_C")] == [
        "degC", "K", "um", "degC",
    ]  # fmt: skip
    assert rig.screw is not None
    assert units["input_speed"] == "rpm"


def test_what_is_not_known_is_null_and_the_profile_is_at_round_places(short_log, found, tmp_path):
    rig, review = found
    path = tmp_path / "ticks.csv"
    assert ballscrew("review", short_log, "--rig", PAPER, "--table", path)[0] == 0
    rows = csv.read_csv(path)
    assert rows["nis"].null_count == np.isnan(review.track.nis).sum() > 0
    np.testing.assert_allclose(rows["elongation_um"].to_numpy(), review.track.elongation_um, atol=1e-6)
    assert pa.types.is_timestamp(rows["clock"].type)
    since = rows["clock"].to_numpy().astype("datetime64[ms]").astype(float) / 1000
    np.testing.assert_allclose(since, review.recording.began_s + review.track.time_s, atol=1e-3)
    places = {name: float(name[2:-2]) for name in rows.column_names if name.startswith("x_")}
    assert min(places.values()) >= rig.screw.from_mm
    assert max(places.values()) <= rig.screw.to_mm
    written = [rows[name][-1].as_py() for name in places]
    profile = np.interp(list(places.values()), review.track.x_mm, review.track.profile_C[-1])
    np.testing.assert_allclose(written, profile, atol=1e-6)


def test_several_recordings_of_a_rig_without_a_screw_are_told_apart(tmp_path):
    path = tmp_path / "rods.csv"
    assert ballscrew("review", ROD / "steps.csv", ROD / "check.csv", "--table", path)[0] == 0
    rows = csv.read_csv(path)
    assert rows.column_names[:2] == ["recording", "time_s"]
    assert rows["recording"].unique().to_pylist() == ["steps.csv", "check.csv"]
    assert rows["elongation_um"].null_count in (0, len(rows))


def test_a_table_of_another_format_is_refused_before_the_work(short_log, tmp_path):
    _, err = ended(2, "review", short_log, "--table", tmp_path / "ticks.xlsx")
    assert "ticks.xlsx: a table is written as one of .csv, .parquet" in err
    told = json_of("review", short_log, "--rig", PAPER, "--table", tmp_path / "ticks.csv")
    assert told["recordings"][0]["ticks"] == len(csv.read_csv(tmp_path / "ticks.csv"))


def test_who_reads_what_is_printed_may_leave_before_the_end(tmp_path):
    table, (end, pipe) = tmp_path / "rods.csv", os.pipe()
    os.close(end)
    words = [sys.executable, "-m", "ballscrew", "review", str(ROD / "check.csv"), "--table", str(table)]
    subprocess.run(words, stdout=pipe, stderr=subprocess.PIPE, check=False)
    os.close(pipe)
    assert len(csv.read_csv(table)) > 10


def test_a_table_beside_its_recording_is_no_recording_the_next_time(short_log, tmp_path):
    shutil.copy(short_log, tmp_path)
    for k in range(2):
        assert ballscrew("review", tmp_path, "--rig", PAPER, "--table", tmp_path / f"{k}.csv", "--quiet")[::2] == (
            0,
            "",
        )
    assert find_recordings([tmp_path]) == [tmp_path / short_log.name]
    assert csv.read_csv(tmp_path / "1.csv").column_names[0] == "time_s"


def test_a_table_overwrites_a_table_and_no_recording(tmp_path):
    recording, table = Path(shutil.copy(ROD / "check.csv", tmp_path)), tmp_path / "table.csv"
    before = recording.read_bytes()
    status, _, err = ballscrew("review", recording, "--rig", ROD, "--table", recording)
    assert (status, recording.read_bytes() == before) == (2, True)
    assert "check.csv: is there, and is no table of `review`; choose another name" in err
    for _ in range(2):
        assert ballscrew("review", recording, "--rig", ROD, "--table", table, "--quiet")[0] == 0


def test_a_recording_of_two_that_could_be_read_keeps_its_name_in_the_table(tmp_path):
    (tmp_path / "torn.csv").write_text("hello\n")
    path = tmp_path / "rods.parquet"
    assert ballscrew("review", ROD / "check.csv", tmp_path / "torn.csv", "--rig", ROD, "--table", path)[0] == 1
    assert parquet.read_table(path)["recording"].unique().to_pylist() == ["check.csv"]
