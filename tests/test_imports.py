"""Imports go one way: the application uses everything, drivers and views only what the estimator measures and says."""

import ast
import re
import subprocess
import sys
from collections.abc import Callable
from functools import cache
from graphlib import TopologicalSorter
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
OURS = {"ballscrew", "drivers", "viz", "estimator", "recordings"}
TYPES = {"record", "rig", "rig_log", "screw", "step", "errors", "alarms"}  # what an estimator is told and what it says
FLOORS = {  # of each package, the ground first: a wing, or a file beside the wings, imports from its own and lower ones
    "estimator": (
        "cover errors record terms screw rig rig_log step work",
        "faults",
        "inputs",
        "effect",
        "effects model",
        "network",
        "rig_folder",
        "state",
        "filter batch battery alarms",
        "sensitivity accuracy",
        "fit missing_heat",
        "events",
        "hypotheses",
        "unknown trend",
        "missing_effect",
        "next_run",
    ),
    "drivers": (
        "canbus",
        "budget received frames mended foreign units virtual_rig",
        "decode",
        "lab",
        "bus logs silences ticker",
        "recorder recordings encoded",
    ),
    "viz": ("drawing", "figures lanes", "recorded comparison tuning plant", "viewer", "live"),
}
MOST_FILES = {"commands": 15}  # all of one kind, each found by the command's name; 12 in any other folder
SAID = {"estimator.inputs.phase", "estimator.faults.fault"}  # what the machine was doing, what is wrong with a channel
RUNS_ITS_OWN_TEXT = ROOT / "estimator" / "unknown" / "written.py"  # an effect as a user gets it, never a user's
FILES = sorted(path for top in OURS for path in (ROOT / top).rglob("*.py"))


@cache
def tree(path: Path) -> ast.Module:
    return ast.parse(path.read_text(encoding="utf-8"))


@cache
def imported(path: Path) -> frozenset[str]:
    """Every module that a file imports, with dots; `from x import y` counts as x.y too where x is a package of ours."""
    found = set()
    for node in ast.walk(tree(path)):
        if isinstance(node, ast.Import):
            found |= {alias.name for alias in node.names}
        elif isinstance(node, ast.ImportFrom):
            assert node.level == 0, f"{path}: relative import"
            found.add(node.module)
            package = ROOT / node.module.replace(".", "/")
            found |= {f"{node.module}.{a.name}" for a in node.names if package.is_dir()}
    return frozenset(found)


def module_of(path: Path) -> str:
    return ".".join(path.relative_to(ROOT).with_suffix("").parts).removesuffix(".__init__")


def test_no_files_import_each_other_in_a_circle():
    modules = {module_of(path) for path in FILES}
    TopologicalSorter({module_of(path): imported(path) & modules - {module_of(path)} for path in FILES}).prepare()


@pytest.mark.parametrize("package", FLOORS)
def test_imports_of_wings_go_downwards(package):
    floor = {wing: i for i, wings in enumerate(FLOORS[package]) for wing in wings.split()}
    inside = [path for path in files(package) if path != ROOT / package / "__init__.py"]
    assert {module_of(path).split(".")[1] for path in inside} == set(floor)
    for path in inside:
        own = module_of(path).split(".")[1]
        for module in imported(path):
            parts = module.split(".")
            if parts[0] == package and len(parts) > 1 and parts[1] != own:
                below = floor[parts[1]] < floor[own] or floor[own] == floor[parts[1]] == 0
                assert below, f"{name(path)} imports {module}, which is not below it"


def test_no_folder_is_a_hall():
    for folder in {path.parent for path in FILES}:
        inside = [path for path in folder.glob("*.py") if path.name != "__init__.py"]
        assert len(inside) <= MOST_FILES.get(folder.name, 12), f"{name(folder)} has {len(inside)} files"


def test_every_folder_says_at_its_door_which_files_it_has():
    for door in FILES:
        if door.name == "__init__.py" and door.parent.name != "recordings":
            said = ast.get_docstring(tree(door))
            named = set(re.findall(r"\w+", said))
            inside = {path.stem for path in door.parent.glob("*.py")} - {"__init__", "__main__"}
            assert inside <= named, f"{name(door)} does not name {', '.join(sorted(inside - named))}"


@pytest.mark.parametrize("command", ["review", "fit", "tune", "compare", "diagnose", "suggest", "improve"])
def test_the_engine_of_a_command_has_its_name(command):
    assert len(list(ROOT.glob(f"estimator/*/{command}.py"))) == 1


def test_the_corridor_loads_no_compiler_and_no_pictures():
    """Who reads the filter, or runs it live, waits for neither."""
    program = "import sys, estimator.filter; print(*{'numba', 'rerun', 'matplotlib'} & set(sys.modules))"
    done = subprocess.run([sys.executable, "-c", program], cwd=ROOT, capture_output=True, text=True, check=True)
    assert done.stdout.split() == []


def top(module: str) -> str:
    return module.partition(".")[0]


def files(*parts: str) -> list[Path]:
    inside = ROOT.joinpath(*parts)
    found = [path for path in FILES if path.is_relative_to(inside)]
    assert len(found) > 3
    return found


def name(path: Path) -> str:
    return str(path.relative_to(ROOT))


def strangers(paths: list[Path], unwanted: Callable[[str], bool]) -> dict[str, set[str]]:
    """By file, what it imports and should not."""
    found = {name(path): {module for module in imported(path) if unwanted(module)} for path in paths}
    return {file: modules for file, modules in found.items() if modules}


def test_the_estimator_needs_numbers_and_toml_only():
    allowed = {"numba", "numpy", "scipy", "filterpy", "threadpoolctl", "tomlkit", "estimator"} | sys.stdlib_module_names
    assert not strangers(files("estimator"), lambda module: top(module) not in allowed)


def test_the_estimator_has_no_clock_thread_or_print():
    worldly = {"time", "datetime", "threading", "asyncio", "multiprocessing", "subprocess", "socket", "logging"}
    assert not strangers(files("estimator"), lambda module: top(module) in worldly)
    for path in files("estimator"):
        calls = [node.func for node in ast.walk(tree(path)) if isinstance(node, ast.Call)]
        barred = {"print", "input", "exec", "eval"} - ({"exec"} if path == RUNS_ITS_OWN_TEXT else set())
        called = [call.id for call in calls if isinstance(call, ast.Name) and call.id in barred]
        assert not called, f"{name(path)} calls {called}"


def test_the_virtual_rig_shares_nothing_with_what_is_judged_on_it():
    own = "drivers.virtual_rig"
    assert not strangers(files("drivers", "virtual_rig"), lambda m: top(m) in OURS and not m.startswith(own))


@pytest.mark.parametrize(("package", "beside"), [("drivers", set()), ("viz", SAID)])
def test_drivers_and_views_know_the_estimator_s_types_only(package, beside):
    def unknown(module: str) -> bool:
        parts = module.split(".")
        return parts[0] != "estimator" or (len(parts) > 1 and parts[1] not in TYPES)

    assert not strangers(files(package), lambda m: top(m) in OURS - {package} and m not in beside and unknown(m))


def test_nothing_runs_on_one_system_only():
    """Windows has none of these modules, and there a text without an encoding is in that of the country."""
    limits_memory = ROOT / "drivers" / "logs" / "outside_reader.py"  # and does without
    absent = {"fcntl", "grp", "posix", "pty", "pwd", "readline", "resource", "syslog", "termios", "tty"}
    assert not strangers([path for path in FILES if path != limits_memory], lambda module: top(module) in absent)
    for path in FILES:
        for call in (node for node in ast.walk(tree(path)) if isinstance(node, ast.Call)):
            if isinstance(call.func, ast.Attribute) and call.func.attr in {"read_text", "write_text"}:
                assert "encoding" in {word.arg for word in call.keywords}, f"{name(path)}, line {call.lineno}"


def test_nobody_imports_the_application():
    users = {name(path) for path in FILES if "ballscrew" in {top(module) for module in imported(path)}}
    assert {Path(user).parts[0] for user in users} == {"ballscrew"}


def test_no_command_imports_another():
    assert not strangers(files("ballscrew", "commands"), lambda module: module.startswith("ballscrew.commands"))


def test_the_filter_uses_filterpy():
    assert "filterpy.kalman" in imported(ROOT / "estimator" / "filter.py")
