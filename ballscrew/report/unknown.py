"""What no effect explains, in words: where it sits, and how to begin with an effect of one's own."""

from __future__ import annotations

from estimator.missing_effect.stand_ins import Unknown


def where(unknown: Unknown) -> str:
    """At 350 mm, in nut, T04."""
    if unknown.channel is not None:
        return unknown.channel or "all thermometers"
    return f"in {unknown.node}" if unknown.at_mm is None else f"at {unknown.at_mm:.0f} mm"


def new_effect_line(unknown: Unknown) -> str:
    """The command that writes an effect file to start from."""
    follows = f"--follows {unknown.follower.name}"
    if unknown.channel is not None:
        return f"ballscrew new-effect my_reading --reading {unknown.channel or 'all'} {follows}"
    at = unknown.node if unknown.at_mm is None else f"{unknown.at_mm:.0f}mm"
    return f"ballscrew new-effect my_heat --at {at} {follows}"
