"""From the first import to the first log-likelihood, with and without compiled code in numba's cache."""

import os
import pickle
import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np

from benchmarks import paper_rig
from benchmarks.measure import Row, say, table

RUN = "FS-20"
WARM = 5
CHILD = """
import sys, time
began, spent = time.perf_counter(), time.process_time()
import pickle
from pathlib import Path
from estimator.rig_folder.model_toml import load_model
from estimator.rig_folder.rig_folder import load_rig
from estimator.batch.trial import Trial
folder = Path(sys.argv[1])
recording = pickle.loads(Path(sys.argv[2]).read_bytes())
model = load_model(folder / "model.toml")
Trial(model, load_rig(folder), recording).loglike(model)
print(time.perf_counter() - began, time.process_time() - spent)
"""


def markdown() -> str:
    """Seconds in processes of their own."""
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "recording"
        file.write_bytes(pickle.dumps(paper_rig.recording(RUN)))
        say("  cold")
        cold, cold_cpu = _seconds(file, folder)
        say("  warm")
        warm, warm_cpu = np.median([_seconds(file, folder) for _ in range(WARM)], axis=0)
    rows = [
        Row(f"code in the cache, median of {WARM}", f"{warm:.2f} s ({warm_cpu:.2f} s CPU)", float(warm), 1.5),
        Row("nothing in the cache: compiled first", f"{cold:.1f} s ({cold_cpu:.1f} s CPU)", cold, 20.0),
    ]
    title = f"Engine: from the first import to the first log-likelihood, {RUN}"
    says = ["On the clock, in a new process; rig, model and the gate included, the log read before."]
    return table(title, rows, says)


def _seconds(file: Path, cache: str) -> tuple[float, float]:
    """On the clock and of the processor, of one new process with its compiled code in this folder."""
    env = {**os.environ, "NUMBA_CACHE_DIR": cache}
    command = [sys.executable, "-c", CHILD, str(paper_rig.FOLDER), str(file)]
    wall, cpu = subprocess.run(command, env=env, capture_output=True, check=True, text=True).stdout.split()
    return float(wall), float(cpu)
