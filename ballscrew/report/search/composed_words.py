"""An effect that no catalogue has, in words and as JSON."""

from pathlib import Path
from typing import Any

from ballscrew.report.sections import with_sd
from estimator.accuracy.noise_floor import Error
from estimator.hypotheses.hypothesis import Hypothesis
from estimator.unknown.composed import Composed

SENSE = {  # what heat, of a sign, that follows something often is
    ("warm", "speed"): "something that rubs: a wiper, a seal, a cover",
    ("warm", "drive"): "something that warms while the axis drives: a motor, oil, something that rubs",
    ("warm", "rest"): "something warm that lies or blows there at rest: chips, a guide that cools later",
    ("warm", "always"): "something warm beside it: chips, a cabinet, another machine",
    ("cold", "speed"): "cooling that grows with the speed: an air jet, air that the screw moves",
    ("cold", "drive"): "coolant or an air jet that runs while the axis drives",
    ("cold", "rest"): "air or coolant that reaches it at rest",
    ("cold", "always"): "something cold beside it: coolant, a draught",
}
AT_REST = ("rest", "early_stop", "slow_stop", "late_rest")


def own_words(h: Hypothesis) -> str:
    """The parameters of an effect that was added, or the one that was freed, with their sd."""
    return ", ".join(
        f"{path.partition('.')[2]} {with_sd(value, h.model.param(path).unit)}"
        for path, value in h.own().items()
        if path == (h.freed or path)
    )


def own_json(h: Hypothesis) -> dict[str, dict[str, Any]]:
    """Parameters of an effect that was added, for programs."""
    return {
        path.partition(".")[2]: {"value": value.value, "sd": value.sd, "unit": h.model.param(path).unit}
        for path, value in h.own().items()
    }


def composed_sentence(made: Composed) -> str:
    """What the effect is, how sure, and from how many it was chosen."""
    sentence = made.effect.sentence().rstrip(".")
    law = made.effect.equation().splitlines()[0].rstrip(",")
    off = 1.0 - made.hypothesis.misfit / made.before.misfit
    sense = f" Often that is {_sense(made)}." if _sense(made) else ""
    others = ", or ".join(one.follower.words for one in made.rivals)
    as_well = f" These recordings cannot tell it from what follows {others}." if others else ""
    return (
        f"As an effect: {sentence}; {law}, with {own_words(made.hypothesis)}."
        f" It takes {off:.0%} off the misfit; of {made.tried} that were tried the best"
        f" takes {made.by_chance:.0%} off by chance in one search of twenty.{as_well}{sense}"
    )


def _sense(made: Composed) -> str:
    """What on a machine such heat often is; "" where there is no usual thing."""
    follows = made.unknown.follower
    if made.unknown.channel is not None or follows.loss:
        return ""
    strength = next(iter(made.hypothesis.own().values())).value
    speed = "speed" if follows.name.startswith("speed") else "drive" if follows.phase == "drive" else ""
    phase = speed or ("rest" if follows.name in AT_REST else follows.name)
    return SENSE.get(("warm" if strength > 0 else "cold", phase), "")


def composed_json(
    made: Composed | None, held_before: Error | None, held: Error | None, file: Path | None
) -> dict[str, Any] | None:
    """The effect for programs."""
    if made is None:
        return None
    from_mm, to_mm = _ends(made)
    h, follower = made.hypothesis, made.unknown.follower
    return {
        "name": made.effect.name, "equation": made.effect.equation(), "sentence": made.effect.sentence(),
        "from_mm": from_mm, "to_mm": to_mm, "node": made.unknown.node, "channel": made.unknown.channel,
        "follows": follower.name,
        "rivals": [{"what": one.place, "follows": one.follower.name} for one in made.rivals],
        "parameters": own_json(h),
        "before": vars(made.before.error), "after": vars(h.judged.error),
        "held_out_before": vars(held_before) if held_before else None,
        "held_out_after": vars(held) if held else None,
        "tried": made.tried, "text": made.text, "effect_file": str(file) if file else None,
    }  # fmt: skip


def _ends(made: Composed) -> tuple[float | None, float | None]:
    at = made.unknown.at_mm
    if at is None:
        return None, None
    half = float(made.hypothesis.model[f"{made.effect.name}.width"]) / 2.0
    screw = made.effect.params["at"]
    return max(at - half, screw.lo), min(at + half, screw.hi)
