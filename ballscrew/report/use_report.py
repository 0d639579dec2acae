"""What was used of recordings, on the terminal and for programs."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from ballscrew.terminal import Terminal
from estimator.faults.sentences import sentences
from estimator.faults.use import ChannelUse, Spell, Use
from estimator.rig import Rig


def print_use(terminal: Terminal, uses: Sequence[Use], rig: Rig) -> None:
    """What was not used of each recording; nothing where all was."""
    for sentence in sentences(uses, rig):
        terminal.say(sentence)


def as_json(use: Use) -> dict[str, Any]:
    """What was used of a recording, for programs."""
    return {
        "channels": {one.channel: channel_json(one) for one in use.channels},
        "begun": {"at_s": use.begun_s, "again": use.again},
        "jumps": [{"at_s": jump.time_s, "sizes": dict(jump.sizes)} for jump in use.jumps],
        "inputs": {name: _spells_json(spells) for name, spells in use.inputs.items()},
        "silent_inputs": dict(use.silent),
        "travel": [{"from_s": from_s, "why": why} for from_s, why in use.travel],
    }


def channel_json(one: ChannelUse) -> dict[str, Any]:
    """What was used of a channel, for programs."""
    told = {"used": one.share, "refused": one.refused, "why": dict(one.why)}
    return {**told, "suspect": one.suspect.word or None, "spells": _spells_json(one.spells)}


def _spells_json(spells: Sequence[Spell]) -> list[dict[str, Any]]:
    return [{"fault": spell.fault.word, "from_s": spell.from_s, "to_s": spell.to_s} for spell in spells]


def recordings_json(uses: Sequence[Use]) -> list[dict[str, Any]]:
    """What was used of each recording, for programs."""
    return [{"name": use.name, **as_json(use)} for use in uses]
