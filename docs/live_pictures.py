"""Make the pictures of the live views: of `ballscrew live` beside a simulated rig on a bus, while both run.

As somebody sees them who looks on after the second stop; between the stops a thermometer has jumped. The second set is
of a while after the rig has ended. `make pictures` runs it: some five minutes.
"""

import subprocess
import sys
import tempfile
import time
from pathlib import Path

from benchmarks.loopback import hub, lines_of, monitor, views_of
from viz.viewer.pictures import render_stream

PICTURES = Path(__file__).parent / "pictures" / "live"
SPEED_UP, RUN = 20, ("FS-20", "--plant", "channel_offset", "--onset", "64min", "--seconds", "5200")
UNTIL_S, AFTER_S = 4150.0, 15.0  # of the rig when pictures are taken, and of the wall after its end
WINDOW = "1366x768"


def reached(folder: Path, rig: subprocess.Popen[bytes]) -> bool:
    """Whether the rig is where pictures are taken."""
    if rig.poll() is not None:
        sys.exit("live_pictures: the rig has ended before its time")
    lines = lines_of(folder) if (folder / "live.jsonl").exists() else []
    return bool(lines) and float(str(lines[-1]["t"])) >= UNTIL_S


def main() -> None:
    """Run, look, write."""
    fast = "--speed-up", str(SPEED_UP)
    with tempfile.TemporaryDirectory() as name, hub() as port:
        folder = Path(name)
        bus = "--interface", "socketcand", "--channel", "can0", "--bus-kwargs", "host=127.0.0.1", f"port={port}"
        with monitor(port, folder, "--view", "native", "--publish", *fast):
            rig = subprocess.Popen([sys.executable, "-m", "ballscrew", "simulate", *RUN, *bus, *fast, "--quiet"])
            while not reached(folder, rig):
                time.sleep(0.5)
            for path in render_stream(views_of(folder), PICTURES, WINDOW, only={"Overview", "At the table"}):
                print(path)
            rig.wait()
            time.sleep(AFTER_S)
            for path in render_stream(views_of(folder), PICTURES / "ended", WINDOW, only={"Overview"}):
                print(path)


if __name__ == "__main__":
    main()
