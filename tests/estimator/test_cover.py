"""Where the nut was, kept small: the numbers it was made of, to the bit."""

import pickle
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, strategies as st

from drivers.recordings import read_recording
from estimator.cover import Cover
from estimator.rig_folder.rig_folder import load_rig

ROW = st.sampled_from([[0.0, 0.0, 0.0], [0.0, 0.5, 0.0], [0.25, 0.0, 0.125], [np.nan] * 3, [1.0, 1.0, 1.0]])


def table(rows: list) -> np.ndarray:
    return np.array(rows, float).reshape(-1, 3)


@given(rows=st.lists(ROW, max_size=9), more=st.lists(ROW, max_size=4), kind=st.sampled_from([np.float32, np.float64]))
def test_it_has_the_numbers_it_was_made_of(rows: list, more: list, kind: type) -> None:
    numbers = np.vstack([table(rows), table(more)]).astype(kind)
    cover = Cover.joined([Cover.of(table(rows).astype(kind)), Cover.of(table(more).astype(kind))])
    assert (cover.shape, cover.dtype, len(cover)) == (numbers.shape, numbers.dtype, len(numbers))
    for kept in (cover, pickle.loads(pickle.dumps(cover))):
        np.testing.assert_array_equal(np.asarray(kept), numbers)
    np.testing.assert_array_equal(np.array([*cover]).reshape(-1, 3), numbers)
    np.testing.assert_array_equal(cover.known, ~np.isnan(numbers).any(axis=1))
    np.testing.assert_array_equal(cover[2:7][::2], numbers[2:7][::2])
    np.testing.assert_array_equal(1.0 - cover, 1.0 - numbers)
    np.testing.assert_array_equal(cover @ np.arange(3.0), numbers @ np.arange(3.0))
    if len(numbers):
        back = np.arange(len(numbers))[::-1] // 2
        np.testing.assert_array_equal(cover[back], numbers[back])
        np.testing.assert_array_equal(cover[-1], numbers[-1])


def test_a_rig_without_a_screw_has_none() -> None:
    cover = Cover.of(np.zeros((4, 0)))
    assert cover.shape == np.asarray(cover).shape == (4, 0)
    assert cover.known.all()


def test_a_nut_that_stands_is_kept_once() -> None:
    stands = np.tile([0.0, 0.5, 1.0, 0.5, 0.0], (10_000, 1))
    assert Cover.of(stands).nbytes < 4 * len(stands) + 100


@pytest.mark.parametrize("name", ["FS-20.blf", "CS-10.blf"])
def test_an_hour_of_the_papers_rig_is_small(name: str) -> None:
    """Where the nut was takes less than 1 MB, where (270 + 270 / 2) numbers a tick would be 12; all else 1.5 MB."""
    folder = Path(__file__).parents[2] / "recordings"
    recording = read_recording(folder / name, load_rig(folder))
    hours = len(recording) / 3600
    covers = recording.coverage.nbytes + recording.stay.nbytes
    series = [each for each in vars(recording).values() if isinstance(each, np.ndarray)]
    assert covers < 1e6 * hours
    assert sum(each.nbytes for each in [*series, *recording.inputs.values()]) < 1.5e6 * hours
