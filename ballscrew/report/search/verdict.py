"""What a search for a missing effect found, in words."""

from dataclasses import replace

import numpy as np

from ballscrew import began
from ballscrew.report.search.composed_words import composed_sentence
from ballscrew.report.search.next_run_words import next_run_sentence
from ballscrew.report.sections import with_sd
from ballscrew.search import Verdict
from estimator.hypotheses.criterion import GOOD
from estimator.hypotheses.hypothesis import Hypothesis
from estimator.missing_effect.suggestion import Suggestion
from estimator.missing_effect.wrong_input import Mislabel
from estimator.rig import Rig
from estimator.unknown.stand_ins import Unknown, unknown_of
from estimator.unknown.unexplained import Unexplained

ONE = "By one recording, from which nothing could be left out: make another to be sure."
NAMED = 3  # rivals of something unknown, the rest counted


def sentence(verdict: Verdict, rig: Rig) -> str:
    """The verdict in words, and how far it can be trusted."""
    once = ONE if verdict.suggestion.one_recording else ""
    made = verdict.suggestion.composed
    parts = [
        _sentence(verdict, rig),
        _beside(verdict.suggestion.others),
        composed_sentence(made) if made is not None else "",
        once,
        next_run_sentence(verdict.next_run, rig),
        _begin(verdict.suggestion.others, rig),
    ]
    return " ".join(filter(None, parts))


def _sentence(verdict: Verdict, rig: Rig) -> str:
    suggestion = verdict.suggestion
    if suggestion.apart:
        return _of_one_run(verdict, rig)
    if suggestion.verdict == "input_error" and suggestion.wrong_input is not None:
        return _wrong_always(suggestion.wrong_input, suggestion.far)
    if suggestion.verdict == "nothing_in_catalogue" and suggestion.unexplained is not None:
        return unknown_sentence(suggestion.unexplained, rig)
    if suggestion.verdict == "nothing_in_catalogue":
        return _unnamed(suggestion)
    if suggestion.verdict == "nothing_missing":
        return _nothing(suggestion)
    best = suggestion.found[0]
    if suggestion.verdict == "effects":
        return f"{' and '.join(best.names)} are missing, neither alone: {_gain(suggestion.before, best)}."
    more = _besides(suggestion)
    if suggestion.verdict == "tie":
        tied = {h.names[0]: seated(h, rig) for h in reversed(suggestion.found)}
        return f"{' or '.join(tied.get(name, name) for name in suggestion.tie)}: these recordings cannot tell.{more}"
    return f"{seated(best, rig)} is missing: {_gain(suggestion.without(best), best)}.{more}"


def seated(h: Hypothesis, rig: Rig) -> str:
    """An effect and where it sits: channel_gain of T06, local_heat at 349 mm."""
    name = h.names[0]
    if thermometer := thermometer_of(h, rig):
        return f"{name} of {thermometer}"
    places = [key for key, param in h.model.effects[name].params.items() if param.over == "place"]
    return f"{name} at {h.model[f'{name}.{places[0]}']:.0f} mm" if places else name


def thermometer_of(h: Hypothesis, rig: Rig) -> str:
    """The thermometer that an effect of one is about; "" where it is about none, or more."""
    which = [
        h.model[f"{name}.{key}"]
        for name in h.names
        for key, param in h.model.effects[name].params.items()
        if param.over == "channel"
    ]
    return rig.thermometers[round(which[0]) - 1] if len(which) == 1 else ""


def _unnamed(suggestion: Suggestion) -> str:
    """Something is missing that nothing explains, or nothing more than a part of it."""
    explains = "explains it"
    if suggestion.partly:
        off = 1.0 - suggestion.found[0].misfit / suggestion.before.misfit
        explains = f"explains most of it ({suggestion.partly} takes {off:.0%} off the misfit)"
    return (
        f"Something is missing, for the model alone leaves {_left(suggestion)}, but no effect that was tried"
        f" {explains}, nor does anything at one place that follows one input. ballscrew diagnose says where and when."
    )


def _besides(suggestion: Suggestion) -> str:
    """What is missing beside the effect that is named, or its rivals; that something is, where a bad model is left."""
    if suggestion.second:
        return f" A second one besides: {suggestion.second}."
    bad = suggestion.found[0].misfit > GOOD
    return " With it the model is no good one yet: ballscrew improve adds it and looks for more." if bad else ""


def _beside(suggestion: Suggestion) -> str:
    """What the model holds fixed, and is another one beside the effect that was found."""
    if suggestion.verdict not in ("effect", "effects", "tie"):
        return ""
    here, was = suggestion.found[0].known(), suggestion.as_given.ground.model
    moved = [
        f"{path} is {with_sd(here.values[path], here.param(path).unit)} here, not {was[path]:.3g}"
        for path in suggestion.loosened[:NAMED]
    ]
    return f"Held fixed in the model, but {', '.join(moved)}." if moved else ""


def _wrong_always(wrong: Mislabel, far: bool) -> str:
    head = "First of all look at" if far or wrong.besides else "Nothing is missing but in"
    rest = f" Set right it still leaves {wrong.judged.error.temperature_K:.3f} K: more is missing." if far else ""
    more = f" Beside it {wrong.besides[0]} stands out: search again with it set right." if wrong.besides else ""
    return f"{head} all recordings, where {_off(wrong)}: check its zero and scale in rig.toml.{more}{rest}"


def _off(wrong: Mislabel) -> str:
    """By how much an input is wrong."""
    off = f"{wrong.shift_mm:+.0f} mm off" if wrong.shift_mm else f"{wrong.shift_K:+.1f} K off"
    size = f"{wrong.ratio:.2f} times" if wrong.ratio != 1 else off
    return f"{wrong.signal} is {size} what it should be"


def _of_one_run(verdict: Verdict, rig: Rig) -> str:
    """What is wrong with one run, or began within it, and what the others say."""
    suggestion = verdict.suggestion
    well = suggestion.by_others == "nothing_missing" and not suggestion.changed
    head = "Nothing is missing, but" if well else "First of all:"
    others = "" if well else _sentence(replace(verdict, suggestion=suggestion.others), rig)
    return f"{head} {apart_sentence(suggestion)}{others and f' By the other recordings: {others}'}"


def apart_sentence(suggestion: Suggestion) -> str:
    """What is wrong with one run, or began within it; either, where both explain it."""
    wrong = suggestion.wrong_input
    began_ = f"something began. {' '.join(map(began.sentence, suggestion.events))}" if suggestion.events else ""
    off = f"in {wrong.run} {_off(wrong)}: check that run." if wrong is not None else ""
    both = [off, began_] if suggestion.verdict == "input_error" else [began_, off]
    return " Or ".join(filter(None, both))


def unknown_sentence(found: Unexplained, rig: Rig) -> str:
    """Something that no catalogue has, and what it may be as well."""
    best, rivals = unknown_of(found.candidate, rig), [unknown_of(rival.candidate, rig) for rival in found.rivals]
    others = ", or ".join(_instead(rival, best) for rival in rivals[:NAMED])
    more = f", or {len(rivals) - NAMED} more" if len(rivals) > NAMED else ""
    return (
        f"No effect of the catalogue explains it. Something like {best.what} does, which follows"
        f" {best.follower.words}.{others and f' As well, by these recordings: {others}{more}.'}"
    )


def _instead(rival: Unknown, best: Unknown) -> str:
    """What a rival is, beside the best: another follower there, or another place."""
    if replace(rival, follower=best.follower) == best:
        return rival.follower.words
    return f"{rival.what} that follows {rival.follower.words}"


def _begin(suggestion: Suggestion, rig: Rig) -> str:
    """The command that writes an effect file, where something is unknown; "" where not."""
    if suggestion.unexplained is None or suggestion.verdict != "nothing_in_catalogue":
        return ""
    if suggestion.composed is not None:
        return "ballscrew improve with --compose effects.py adds it to the model."
    return f"Begin with: {_new_effect(unknown_of(suggestion.unexplained.candidate, rig))}"


def _new_effect(unknown: Unknown) -> str:
    follows = f"--follows {unknown.follower.name}"
    if unknown.channel is not None:
        return f"ballscrew new-effect my_reading --reading {unknown.channel or 'all'} {follows}"
    at = unknown.node or ("under-nut" if unknown.under_nut else "")
    if unknown.at_mm is not None:
        at = f"{unknown.at_mm:.0f}mm"
    return f"ballscrew new-effect my_heat {at and f'--at {at} '}{follows}"


def _nothing(suggestion: Suggestion) -> str:
    left, best = _left(suggestion), suggestion.found[0] if suggestion.changed else suggestion.before
    well = best.misfit <= GOOD
    head, more = ("Nothing is missing", "") if well else ("Nothing is proven", ", more than a good model")
    if suggestion.changed:
        value, unit = best.own()[suggestion.changed], best.model.param(suggestion.changed).unit
        here = f"{suggestion.changed} is {with_sd(value, unit)} here"
        was = suggestion.as_given.ground.model[suggestion.changed]
        return f"{head}, but {here}, not {was:.3g}: {_gain(suggestion.before, best)}{more}."
    if suggestion.before.refit and suggestion.as_given.misfit > max(GOOD, 1.2 * suggestion.before.misfit):
        fixed = f", of the fixed ones {', '.join(moved)}" if (moved := suggestion.loosened) else ""
        free = ", these free" if moved else ""
        return f"{head}, but the parameters are off{fixed}: fit the model again{free}, which leaves {left}{more}."
    return f"{head}: the model alone leaves {left}{more}, and no effect makes that clearly less."


def _left(suggestion: Suggestion) -> str:
    error = suggestion.before.judged.error
    um = f" and {error.elongation_um:.2f} um" if np.isfinite(error.elongation_um) else ""
    return f"{error.temperature_K:.3f} K{um}"


def _gain(before: Hypothesis, after: Hypothesis) -> str:
    a, b = before.judged.error, after.judged.error
    where = " on recordings left out" if len(after.judged.runs) > 1 else ""
    um = f", elongation {a.elongation_um:.2f} -> {b.elongation_um:.2f} um" if np.isfinite(b.elongation_um) else ""
    return f"temperatures {a.temperature_K:.3f} -> {b.temperature_K:.3f} K{um}{where}"
