"""The example of a service starts a command that there is."""

import shlex

import click
import pytest

from ballscrew.commands.live import command
from tests.conftest import PAPER

UNIT = (PAPER.parent / "examples" / "systemd" / "ballscrew-live.service").read_text()


def test_its_command_line_is_understood():
    (line,) = [line.partition("=")[2] for line in UNIT.splitlines() if line.startswith("ExecStart=")]
    program, name, *words = shlex.split(line)
    assert (program.rpartition("/")[2], name) == ("ballscrew", "live")
    given = command.make_context("live", words).params
    assert given["publish"]
    assert given["json_path"]
    assert str(given["record"]) == "/var/lib/ballscrew"
    with pytest.raises(click.NoSuchOption):
        command.make_context("live", [*words, "--recrod"])


def test_it_starts_again_whatever_ended_it_and_waits_longer_than_the_monitor_needs_to_end():
    keys = dict(line.split("=", 1) for line in UNIT.splitlines() if "=" in line and not line.startswith("#"))
    assert (keys["Restart"], keys["StartLimitIntervalSec"]) == ("always", "0")
    assert float(keys["TimeoutStopSec"]) > 2.0
    assert keys["StateDirectory"] in keys["ExecStart"]
