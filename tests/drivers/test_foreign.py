"""Files that are none of ours."""

import gzip
import zipfile
from pathlib import Path

import pytest

from drivers.logs.logs import regular
from estimator.errors import InputError


def refused(path: Path) -> str:
    with pytest.raises(InputError) as error:
        regular(path)
    return str(error.value).removeprefix(f"{path}: ")


@pytest.mark.parametrize("name", ["a.csv", "a.log", "a.asc", "a.trc"])
def test_what_is_no_text_is_named_by_how_it_begins(tmp_path: Path, name: str) -> None:
    path = tmp_path / name
    with zipfile.ZipFile(path, "w") as book:
        book.writestr("xl/workbook.xml", "")
    assert refused(path).startswith("is an Excel workbook or a zip archive: save or export it as CSV, or unpack")
    path.write_bytes(gzip.compress(b"t,A\n0,1\n"))
    assert refused(path) == "is compressed: unpack it first"
    path.write_bytes(b"LOGG" + bytes(200))
    assert refused(path) == "is a Vector BLF log: rename it to .blf"
    path.write_text("\N{BYTE ORDER MARK}<html><table>", encoding="utf-8")
    assert refused(path) == "is HTML or XML: save or export it as CSV"


@pytest.mark.parametrize(
    ("name", "fix"),
    [("a.log.gz", "unpack it first"), ("a.xlsx", "as .csv"), ("a.txt", "rename it"), ("a.pcap", ".blf")],
)
def test_other_suffixes_say_the_way_out(tmp_path: Path, name: str, fix: str) -> None:
    said = refused(tmp_path / name)
    assert said.startswith(f"no known kind of log '{Path(name).suffix}'; ")
    assert fix in said


def test_a_blf_may_begin_as_it_does(tmp_path: Path) -> None:
    path = tmp_path / "a.blf"
    path.write_bytes(b"LOGG" + bytes(200))
    assert regular(path) == path
