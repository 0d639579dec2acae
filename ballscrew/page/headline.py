"""What is to be known first: how well the estimate follows, whether the model is this machine's, what was not used."""

from collections.abc import Iterator, Sequence

import numpy as np

from ballscrew.report.review_report import skipped
from ballscrew.report.sections import number
from ballscrew.reviewing import Reviewed
from estimator.accuracy.machine import LIMIT_SD
from estimator.accuracy.review import Review, overall
from estimator.faults.fault import MAY_DRIFT
from estimator.faults.sentences import place_of
from estimator.rig import Rig

REFERENCES = {"truth": "the true elongation", "readings": "the displacement readings"}


def headline(found: Reviewed, rig: Rig) -> list[str]:
    """A sentence or two each."""
    return [follows(found.reviews), found.verdict.sentence or well(found), left_out(found, rig)]


def follows(reviews: Sequence[Review]) -> str:
    """How well the estimate follows the reference."""
    known = sorted({r.reference_name for r in reviews if np.isfinite(r.errors["filter"]).any()}, reverse=True)
    if not known:
        off = ", ".join(number(r.one_step_K, 3) for r in reviews if np.isfinite(r.one_step_K))
        return "No reference: how far the elongation is off is not known." + (
            f" Thermometers are {off} K rms from what is expected of them a tick ahead." if off else ""
        )
    a = overall(reviews, "filter")
    cooling = (
        f", {a.cooldown_max_um:.2f} um at most within 60 min after a stop" if np.isfinite(a.cooldown_max_um) else ""
    )
    inside = (
        f"; {100 * a.coverage_2sigma:.1f} % of its errors are within two of its standard deviations, 95 % were expected"
    )
    return (
        f"The filter follows {' and '.join(REFERENCES[name] for name in known)} within {a.band_um[0]:+.2f} .. "
        f"{a.band_um[1]:+.2f} um ({a.rms_um:.2f} um rms{cooling}){inside if np.isfinite(a.coverage_2sigma) else ''}."
    )


def well(found: Reviewed) -> str:
    """That the model is this machine's, or that nothing tells."""
    name, off = found.verdict.model.name, [r.off_sd for r in found.reviews if np.isfinite(r.off_sd)]
    if not off:
        return f"Whether {name} is this machine's these recordings do not tell."
    return (
        f"{name} is this machine's as far as these recordings tell: alone it is {max(off):.1f} times as far off as it "
        f"says, up to {LIMIT_SD:.1f} is chance."
    )


def left_out(found: Reviewed, rig: Rig) -> str:
    """What the filter was not to use, which sensors failed, and how much was not used."""
    reviews = found.reviews
    failed = list(dict.fromkeys(name for r in reviews for name in _failed(r, rig)))
    count, notes = sum(n for _, n in skipped(reviews)), sum(len(r.recording.notes) for r in reviews)
    said = [f"As asked without {', '.join(found.without)}."] if found.without else []
    said += [f"{r.recording.name}: {doubt}." for r in reviews for doubt in r.recording.doubts]
    said += [f"Could not be used: {len(found.failed)}."] if found.failed else []
    said += [f"Sensors to check: {', '.join(failed)}." if failed else "No sensor failed."]
    rest = [f"{count} x not used" if count else "", f"{notes} x noted" if notes else ""]
    said += [f"Of what was recorded: {', '.join(filter(None, rest))}; at the end of the report."] if any(rest) else []
    return " ".join(said)


def _failed(review: Review, rig: Rig) -> Iterator[str]:
    """Channels and inputs that were broken, or suspected for a while."""
    use = review.use
    for one in use.channels:
        if one.suspect:
            yield f"{place_of(rig, rig.index(one.channel))} ({one.suspect.word})"
        elif one.suspicions:
            yield f"{place_of(rig, rig.index(one.channel))} ({MAY_DRIFT}, used)"
    yield from (f"input {name} ({spells[0].fault.word})" for name, spells in use.inputs.items())
    yield from (f"input {name} (never read)" for name in use.never)
