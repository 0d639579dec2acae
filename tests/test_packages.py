"""What is installed: one version of each package, and one that the ranges of pyproject.toml allow."""

import tomllib

from packaging.requirements import Requirement

from tests.conftest import PAPER

ROOT = PAPER.parent


def test_each_package_is_kept_at_one_version_which_its_range_allows():
    kept = [Requirement(line) for line in (ROOT / "constraints.txt").read_text().split()]
    assert len({one.name for one in kept}) == len(kept)
    version = {one.name: str(one.specifier).removeprefix("==") for one in kept}
    project = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]
    extras = project["optional-dependencies"]
    every = [*project["dependencies"], *(word for words in extras.values() for word in words)]
    for asked in map(Requirement, every):
        assert asked.name == project["name"] or version[asked.name] in asked.specifier, asked
