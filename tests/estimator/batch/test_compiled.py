"""What is compiled is kept, where that can be written, and works where it cannot."""

import os
import runpy
import shutil
from pathlib import Path

from estimator.batch import batch
from estimator.batch.batch import ahead, compared, loglike, passes, score, smoothed
from tests.estimator.batch.test_batch import random_system
from tests.processes import ended


def test_it_works_where_nothing_can_be_written(tmp_path):
    """A read-only install without a home: no cache, and nothing but a slower start."""
    home = tmp_path / "estimator"
    shutil.copytree(Path(batch.__file__).parents[1], home, ignore=shutil.ignore_patterns("__pycache__"))
    (home / "batch" / "__pycache__").touch()  # nobody can make the folder now, root neither
    program = (
        "from estimator.batch import batch, kernels\n"
        "print(kernels.forward.dispatcher.stats.cache_path, batch.is_cold())"
    )
    clean = {key: value for key, value in os.environ.items() if not key.startswith(("HOME", "XDG", "NUMBA"))}
    clean |= {"HOME": "/proc/none", "PYTHONDONTWRITEBYTECODE": "1"}
    done = ended("-c", program, cwd=tmp_path, env=clean)
    assert (done.stdout, done.stderr) == ("None True\n", "")


def test_what_numba_keeps_counts_and_not_the_dates_of_files(tmp_path):
    """A checkout gives a file a new date and the same text: nothing is compiled again. Another text is."""
    source = tmp_path / "more.py"

    def kernel():
        return batch.kernels.kernel(runpy.run_path(str(source))["more"])

    source.write_text("def more(x):\n    return x + 1.0\n")
    assert not batch._is_compiled(kernel())
    kernel()(1.0)
    os.utime(source, (4e9, 4e9))
    assert batch._is_compiled(kernel())
    source.write_text("def more(x):\n    return x + 2.0\n")
    assert not batch._is_compiled(kernel())


def test_compiled_once_and_known_to_be():
    system = random_system()
    x = compared(system, system.data.use).x
    loglike(system), score(system), smoothed(system), list(passes(system)), ahead(system, x, 3, 3)
    assert not batch.is_cold()
    assert not batch.is_cold(passes, smoothed)
    used = batch.kernels
    for kernel in (used.forward, used.compare, used.smooth, used.score, used._coast):
        assert len(kernel.dispatcher.signatures) == 1
