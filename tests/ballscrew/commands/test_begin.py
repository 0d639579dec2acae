"""Help and errors come at once: nothing that takes long to import is loaded before it is needed."""

import subprocess
import sys

from ballscrew.cli import COMMANDS
from tests.log_fake import DBC

SLOW = {
    "numba", "scipy.interpolate", "scipy.linalg", "scipy.optimize", "scipy.signal", "scipy.special", "scipy.stats",
    "rerun", "matplotlib", "pandas", "pyarrow",
}  # fmt: skip


def test_no_command_loads_what_is_slow_to_say_what_it_does_nor_for_a_dbc():
    program = """if True:
        import importlib, pathlib, sys
        from ballscrew.cli import module_of
        from drivers.mended import read_dbc
        read_dbc(pathlib.Path(sys.argv[3]))
        for name in sys.argv[1].split():
            importlib.import_module(module_of(name))
            print(name, *sorted(set(sys.argv[2].split()) & set(sys.modules)))
    """
    words = [" ".join(COMMANDS), " ".join(SLOW), DBC]
    done = subprocess.run([sys.executable, "-c", program, *words], capture_output=True, text=True, check=True)
    assert done.stdout.split("\n") == [*COMMANDS, ""]


def test_numpy_is_not_there_before_it_is_told_how_many_threads_to_take():
    program = "import sys, ballscrew.cli; print('numpy' in sys.modules)"
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=True)
    assert done.stdout == "False\n"
