"""A diagnosis in two or three plain sentences."""

from collections.abc import Sequence

import numpy as np

from estimator.accuracy.noise_floor import Error
from estimator.inputs.follower import ALWAYS
from estimator.inputs.phase import PHASES
from estimator.missing_heat.follows import Follows
from estimator.missing_heat.missing_heat import ALL
from estimator.missing_heat.where import Deficit, together
from estimator.missing_heat.wrong_reading import Wrong

NOTHING = "Nothing: what is left is as large as the sensors' own errors."
NOTHING_ELSE = NOTHING.replace("Nothing", "Nothing else")
FINDINGS = 2


def sentences(
    adequate: bool, alone: Error, floor: Error, heat: Sequence[Deficit], wrong: Sequence[Wrong], moves: bool = True,
    broken: bool = False,
) -> tuple[str, ...]:  # fmt: skip
    """How far the model is off, and the two findings that matter most; without phases on a rig that never moves.

    broken  channels were left out, and that has been said
    """
    if adequate and not heat and not wrong:
        return (NOTHING_ELSE if broken else NOTHING,)
    first = _size(alone, floor) + (" That is good enough; still:" if adequate else "")
    found = [(max(h.effect for h in same), _heat(same, moves)) for same in together(heat)]
    found += [(each.effect, _reading(each, moves)) for each in wrong]
    best = [sentence for _, sentence in sorted(found, key=lambda pair: -pair[0])[:FINDINGS]]
    return (first, *(best or ["Neither heat at some place nor a single reading explains it."]))


def _size(alone: Error, floor: Error) -> str:
    pairs = [(alone.temperature_K, floor.temperature_K, "K"), (alone.elongation_um, floor.elongation_um, "um")]
    known = [pair for pair in pairs if np.isfinite(pair[0])]
    off = " and ".join(f"{value:.2g} {unit}" for value, _, unit in known)
    times = max(value / least for value, least, _ in known)
    return f"The model alone is {off} off, {times:.0f} times what the sensors leave."


def _heat(same: Sequence[Deficit], moves: bool) -> str:
    most = same[0]
    place = f"in {most.node}" if most.node is not None else f"between {most.from_mm:.0f} and {most.to_mm:.0f} mm"
    when = " and ".join(PHASES[phase] for phase in PHASES if phase in {each.phase for each in same})
    if not moves or len({each.phase for each in same}) == len(PHASES):
        when = "all the time" if moves or most.follows.follower in (None, ALWAYS) else ""
    verb = "It lacks" if most.heat_W > 0 else "It has too much:"
    return f"{verb} {abs(most.heat_W):.2g} W +- {most.sd_W:.1g} {place}{when and ' ' + when}{_follows(most.follows)}."


def _reading(wrong: Wrong, moves: bool) -> str:
    name = "All thermometers together" if wrong.channel == ALL else wrong.channel
    reads = "read" if wrong.channel == ALL else "reads"
    if wrong.follows.follower == ALWAYS:
        way = "high" if wrong.offset > 0 else "low"
        since = "from the first motion on" if moves else "all the time"
        return f"{name} {reads} {abs(wrong.offset):.2f} {wrong.unit} {way} {since}."
    return f"{name} {reads} {wrong.rms:.2g} {wrong.unit} (rms) wrong{_follows(wrong.follows)}."


def _follows(found: Follows) -> str:
    if found.follower is None or found.follower == ALWAYS:
        return ""
    told = f"; that follows {found.follower.words} (p {'<' if found.p < 0.002 else '='} {max(found.p, 0.002):.2g})"
    others = "; or ".join(rival.words for rival in found.rivals)
    return told + (f", or as well {others}" if others else "")
