"""The columns of the table: a row a tick, each column with its unit, in this order.

    time_s, mode, elongation_um, sigma_um, smoothed_um, smoothed_sigma_um, open_loop_um, error_at_table_um,
    error_at_table_sd_um, nis
    NAME_measured, NAME_predicted, NAME_innovation, NAME_innovation_sd, NAME_used     of each channel
    x_MM_C            temperature of the screw each 20 mm
    body_NAME_C       of each body that the model has: nut, housings, or those of a rig without a screw
    reference_um      what the estimates are judged by
    input_NAME        of each input of the rig, as measured
    clock             of the tick, where the log's clock tells a date

What is not known is null. Where several recordings were given a first column `recording` tells them apart.
"""

from collections.abc import Callable, Iterator, Sequence
from itertools import chain
from pathlib import Path

import numpy as np
import pyarrow as pa
from pyarrow import compute, csv, parquet

from estimator.accuracy.review import Review
from estimator.errors import InputError
from estimator.record import Array
from estimator.rig import Rig
from estimator.step import Mode

EACH_MM = 20.0  # of the profile: finer than the thermometers stand, no finer than the screw's own
LINES = ("measured", "predicted", "innovation", "innovation_sd")  # of a channel, in its unit

Column = tuple[str, Array, str]  # name, values (K,), unit
DIGITS = 6  # after the point, of what a CSV tells; Parquet keeps all


def table(reviews: Sequence[Review], rig: Rig, several: bool) -> pa.Table:
    """All ticks of recordings, one after the other; the unit of a column is in its field's metadata.

    several  whether more than one recording was given, be it that not all could be used
    """
    tables = [_table(review, rig) for review in reviews]
    if not several:
        return tables[0]
    named = [one.add_column(0, "recording", _names(r)) for one, r in zip(tables, reviews, strict=True)]
    return pa.concat_tables(named, promote_options="default")  # a model's profile begins where its run has


def _names(review: Review) -> pa.Array:
    return pa.array([review.recording.name] * len(review.recording))


def _table(review: Review, rig: Rig) -> pa.Table:
    told = _estimate(review), _channels(review, rig), _temperatures(review, rig), _beside(review, rig)
    fields, arrays = zip(*(_field(*column) for column in chain(*told)), strict=True)
    return pa.Table.from_arrays(list(arrays), schema=pa.schema(fields))


def _field(name: str, values: Array, unit: str) -> tuple[pa.Field, pa.Array]:
    array = pa.array(values, from_pandas=True)  # NaN is null
    return pa.field(name, array.type, metadata={"unit": unit}), array


def _estimate(review: Review) -> Iterator[Column]:
    track = review.track
    yield "time_s", track.time_s, "s"
    yield "mode", np.array([Mode(mode).name.lower() for mode in track.mode]), ""
    yield "elongation_um", track.elongation_um, "um"
    yield "sigma_um", track.sigma_um, "um"
    yield "smoothed_um", review.estimates["smoothed"], "um"
    yield "smoothed_sigma_um", review.smoothed_sd, "um"
    yield "open_loop_um", track.open_loop_um, "um"
    yield "error_at_table_um", track.error_at_table_um, "um"
    yield "error_at_table_sd_um", track.error_at_table_sd_um, "um"
    yield "nis", track.nis, "1"


def _channels(review: Review, rig: Rig) -> Iterator[Column]:
    track = review.track
    for i, (name, channel) in enumerate(rig.channels.items()):
        for line in LINES:
            unit = "K" if channel.is_thermometer and line.startswith("innovation") else channel.unit
            yield f"{name}_{line}", getattr(track, line)[:, i], unit
        yield f"{name}_used", track.fused[:, i], ""


def _temperatures(review: Review, rig: Rig) -> Iterator[Column]:
    track = review.track
    if rig.screw is not None:
        first, last = (np.array([rig.screw.from_mm, rig.screw.to_mm]) / EACH_MM).round(6)
        for at_mm in EACH_MM * np.arange(np.ceil(first), np.floor(last) + 1):
            yield f"x_{at_mm:g}_C", _at(at_mm, track.x_mm, track.profile_C), "degC"
    for i, body in enumerate(track.bodies):
        yield f"body_{body}_C", track.bodies_C[:, i], "degC"


def _at(at_mm: float, x_mm: Array, profile: Array) -> Array:
    """(K,) from (K, x), linear between places."""
    right = int(np.clip(np.searchsorted(x_mm, at_mm), 1, len(x_mm) - 1))
    share = (at_mm - x_mm[right - 1]) / (x_mm[right] - x_mm[right - 1])
    return profile[:, right - 1] * (1 - share) + profile[:, right] * share


def _beside(review: Review, rig: Rig) -> Iterator[Column]:
    recording = review.recording
    yield "reference_um", review.reference, "um"
    for name, values in recording.inputs.items():
        yield f"input_{name}", values, rig.inputs[name].unit
    if recording.began_s is not None:
        since_1970 = np.round((recording.began_s + recording.time_s) * 1000).astype("datetime64[ms]")
        yield "clock", since_1970, "UTC"


def _write_csv(rows: pa.Table, path: Path) -> None:
    rounded = [compute.round(c, DIGITS) if pa.types.is_floating(c.type) else c for c in rows.columns]
    csv.write_csv(pa.Table.from_arrays(rounded, names=rows.column_names), path)


def _write_parquet(rows: pa.Table, path: Path) -> None:
    parquet.write_table(rows, path, compression="zstd")


WRITERS: dict[str, Callable[[pa.Table, Path], None]] = {".csv": _write_csv, ".parquet": _write_parquet}


def write(rows: pa.Table, path: Path) -> None:
    """Write the table; one that cannot be written is an InputError."""
    try:
        WRITERS[path.suffix.lower()](rows, path)
    except OSError as error:
        raise InputError(f"{path}: cannot be written: {(error.strerror or str(error)).lower()}") from error
