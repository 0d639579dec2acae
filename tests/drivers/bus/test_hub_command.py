"""`ballscrew hub`: it serves, and ends on Ctrl-C and SIGTERM."""

import re
import signal
import subprocess
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager

from tests.drivers.bus.test_hub import raw
from tests.hub_fake import hub_running
from tests.processes import PATIENCE_S, ended, started


@contextmanager
def command(*words: str) -> Iterator[tuple[subprocess.Popen[str], int]]:
    """`ballscrew hub` as a process, and its port."""
    whole = ["hub", "--port", "0", *words]
    with started("ballscrew", *whole, stdout=subprocess.PIPE, stderr=subprocess.PIPE) as process:
        assert process.stdout
        first = process.stdout.readline()
        assert first.startswith("hub: socketcand on ")
        yield process, int(first.rpartition(":")[2])


def test_the_command_serves_simulate_and_ends_on_ctrl_c(bus, port) -> None:
    """What it prints is what connects."""
    with command() as (process, own):
        example = process.stdout.readline().split()
        listener = bus(port=own)
        play = [*example[1:], "--seconds", "3", "--max-drive", "3s", "--speed-up", "100"]
        done = ended("ballscrew", *play)
        assert done.returncode == 0, done.stderr
        heard = set()
        while not heard >= {0x210, 0x214, 0x230, 0x240}:
            one = listener.recv(PATIENCE_S)
            assert one is not None
            heard.add(one.arbitration_id)
        process.send_signal(signal.SIGINT)
        out, err = process.communicate(timeout=PATIENCE_S)
    assert process.returncode == 130
    assert re.search(r"hub: ended after \d+ frames, 0 dropped", out)
    assert err.strip() == "stopped by Ctrl-C"


def test_a_rig_that_plays_to_a_hub_that_goes_ends_with_one_line() -> None:
    with ExitStack() as stack:
        with hub_running() as port:
            where = ["--interface", "socketcand", "--channel", "can0", "--bus-kwargs", "host=127.0.0.1", f"port={port}"]
            words = ["simulate", "FS-20", "--seconds", "60", *where]
            process = stack.enter_context(started("ballscrew", *words, stderr=subprocess.PIPE, stdout=subprocess.PIPE))
            assert process.stdout.readline().startswith("playing FS-20")
        _, err = process.communicate(timeout=PATIENCE_S)
    assert process.returncode == 2
    assert re.fullmatch(rf"error: socketcand can0 host=127.0.0.1 port={port}: the bus is gone: \w+: .*\n", err)


def test_the_command_ends_on_sigterm_and_warns_when_others_can_reach_it() -> None:
    with command("--bind", "0.0.0.0") as (process, port):
        with raw(port) as client:
            client.joins()
            process.terminate()
            _, err = process.communicate(timeout=PATIENCE_S)
        assert process.returncode == 0
        assert err == (
            "note: --bind 0.0.0.0: whoever reaches this address can read and send frames, without a password\n"
        )
