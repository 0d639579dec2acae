"""What is installed: one version of each package, one that the ranges of pyproject.toml allow, and our own files."""

import tomllib

from packaging.requirements import Requirement

from tests.conftest import ROOT


def test_each_package_is_kept_at_one_version_which_its_range_allows():
    kept = [Requirement(line) for line in (ROOT / "constraints.txt").read_text().split()]
    assert len({one.name for one in kept}) == len(kept)
    version = {one.name: str(one.specifier).removeprefix("==") for one in kept}
    project = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]
    extras = project["optional-dependencies"]
    every = [*project["dependencies"], *(word for words in extras.values() for word in words)]
    for asked in map(Requirement, every):
        assert asked.name == project["name"] or version[asked.name] in asked.specifier, asked


def test_every_file_that_the_code_reads_is_installed():
    data = tomllib.loads((ROOT / "pyproject.toml").read_text())["tool"]["setuptools"]["package-data"]
    installed = {path for top, patterns in data.items() for pattern in patterns for path in (ROOT / top).glob(pattern)}
    there = [path for top in ("ballscrew", "drivers", "estimator", "viz") for path in (ROOT / top).rglob("*.*")]
    there += (ROOT / "recordings").glob("*.toml")
    assert {path for path in there if path.suffix not in {".py", ".pyc", ".nbc", ".nbi"}} == installed
