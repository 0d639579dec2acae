"""What was used of recordings, on the terminal and for programs."""

from collections.abc import Sequence
from dataclasses import asdict
from typing import Any

import numpy as np

from ballscrew.terminal import Rows, Terminal
from estimator.faults.fault import MAY_DRIFT, Spell, Suspicion
from estimator.faults.sentences import place_of, sentences
from estimator.faults.use import ChannelUse, Use
from estimator.rig import Rig


def print_use(terminal: Terminal, uses: Sequence[Use], rig: Rig) -> None:
    """What was not used of each recording; nothing where all was."""
    for sentence in sentences(uses, rig):
        terminal.say(sentence)


def left_out(uses: Sequence[Use], rig: Rig) -> Rows:
    """A table of the channels and inputs that were broken, its head first; nothing where none was."""
    rows = [
        [use.name, place_of(rig, rig.index(one.channel)), *_when(one.spells), str(one.refused)]
        for use in uses
        for one in use.suspects
    ]
    rows += [
        [use.name, place_of(rig, rig.index(one.channel)), f"{MAY_DRIFT}, {each.most_K:+.2f} K", *_span(each), "0"]
        for use in uses
        for one in use.channels
        for each in one.suspicions
    ]
    rows += [[use.name, f"input {name}", *_when(spells), ""] for use in uses for name, spells in use.inputs.items()]
    return [["recording", "sensor", "why", "since", "until", "readings refused"], *rows] if rows else []


def _when(spells: Sequence[Spell]) -> list[str]:
    """Why, from when on, and until when."""
    kinds = dict.fromkeys(spell.fault.word for spell in spells)
    often = f", {len(spells)} times" if len(spells) > 1 else ""
    return [f"{', '.join(kinds)}{often}", _span(spells[0])[0], _span(spells[-1])[1]]


def _span(spell: Spell | Suspicion) -> list[str]:
    """From when on, and until when."""
    return [f"{spell.from_s:.0f} s", f"{spell.to_s:.0f} s" if np.isfinite(spell.to_s) else "the end"]


def as_json(use: Use) -> dict[str, Any]:
    """What was used of a recording, for programs."""
    return {
        "channels": {one.channel: channel_json(one) for one in use.channels},
        "begun": {"at_s": use.begun_s, "again": use.again},
        "jumps": [{"at_s": jump.time_s, "sizes": dict(jump.sizes)} for jump in use.jumps],
        "inputs": {name: _spells_json(spells) for name, spells in use.inputs.items()},
        "silent_inputs": dict(use.silent),
        "inputs_never_read": list(use.never),
        "travel": [{"from_s": from_s, "why": why} for from_s, why in use.travel],
    }


def channel_json(one: ChannelUse) -> dict[str, Any]:
    """What was used of a channel, for programs."""
    told = {"used": one.share, "refused": one.refused, "why": dict(one.why)}
    may_drift = [asdict(suspicion) for suspicion in one.suspicions]
    return {**told, "suspect": one.suspect.word or None, "spells": _spells_json(one.spells), "may_drift": may_drift}


def _spells_json(spells: Sequence[Spell]) -> list[dict[str, Any]]:
    return [{"fault": spell.fault.word, "from_s": spell.from_s, "to_s": spell.to_s} for spell in spells]


def recordings_json(uses: Sequence[Use]) -> list[dict[str, Any]]:
    """What was used of each recording, for programs."""
    return [{"name": use.name, **as_json(use)} for use in uses]
