"""What an improvement came to, as tables and as JSON."""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from ballscrew.report.felt_report import AtTheTable
from ballscrew.report.search.composed_words import composed_json, composed_sentence
from ballscrew.report.search.verdict import apart_sentence, sentence
from ballscrew.report.sections import Section, cells
from ballscrew.report.use_report import recordings_json
from ballscrew.search import Verdict
from ballscrew.terminal import Terminal
from ballscrew.workspace import Loaded, Workspace
from estimator.accuracy.noise_floor import Error
from estimator.missing_effect.improve import ImprovedModel, Improvement
from estimator.model import Model
from estimator.unknown.composed import Composed

ALSO_CHOSEN = "cross-validated: each recording left out once, but all of them were also used for choosing"
ONE = "not cross-validated: one recording, none left out, also used for choosing"
ONE_HELD_OUT = "not cross-validated: one recording, none left out; held out: used only to drop what makes them worse"
UNITS = {"temperature_K": "K", "elongation_um": "um"}
HELD_OUT = "cross-validated: each recording left out once; held out: used only to drop what makes them worse"


@dataclass(frozen=True)
class Outcome:
    """An improvement and what it was made of; `verdict` is the last one.

    before, after   the model as given and the best, under the names of their files
    felt  what both leave at the table; empty where no elongation is read
    own  how effects of the user's own were named
    """

    improvement: Improvement
    verdict: Verdict
    before: Model
    after: Model
    felt: Sequence[AtTheTable]
    work: Workspace
    own: Sequence[str]

    @property
    def models(self) -> list[Model]:
        """Before and after; one, where nothing made it better."""
        return before_and_after(self.improvement, self.after)

    @property
    def said(self) -> str:
        """The last verdict in words."""
        last, dropped = self.improvement.kept[-1], self.improvement.steps[-1]
        apart = [f"{one.apart} is left out: {apart_sentence(one)}" for one in self.improvement.apart]
        words = " ".join([*apart, sentence(self.verdict, self.work.rig)])
        if dropped.added and not dropped.kept:
            words += f" But what is held out it foretells worse: {dropped.added} is not in the model."
        return f"Before all was fitted again: {words}" if len(self.improvement.kept) > 1 and not last.added else words


def recordings_kept(improvement: Improvement, loaded: Sequence[Loaded]) -> list[Loaded]:
    """Recordings but for those that were left out on the way."""
    return [one for one in loaded if one.recording.name not in improvement.left_out]


def before_and_after(improvement: Improvement, after: Model) -> list[Model]:
    """The model as given and the best, under the name of its file; one, where nothing made it better."""
    before = improvement.steps[0].model
    return [before, after] if len(improvement.kept) > 1 else [before]


def added(steps: Sequence[ImprovedModel]) -> list[str]:
    """The effect that each step has more than the one before; "" where it has none."""
    had = [steps[0].model, *(step.model for step in steps)]
    return [step.added if step.added not in model.effects else "" for step, model in zip(steps, had, strict=False)]


def titles(steps: Sequence[ImprovedModel]) -> list[str]:
    """What each step is called."""
    again = [f"{step.added or 'all'} fitted again" for step in steps]
    said = [f"+ {new}" if new else old for new, old in zip(added(steps)[1:], again[1:], strict=True)]
    return ["as given", *(one if step.kept else f"({one})" for one, step in zip(said, steps[1:], strict=True))]


def steps_table(steps: Sequence[ImprovedModel]) -> list[list[str]]:
    """The error falling step by step, head first."""
    held = any(step.held_out for step in steps)
    head = ["added", "cross-validated, K", "um", *(["held out, K", "um"] if held else []), "tied with"]
    rows = []
    for title, step in zip(titles(steps), steps, strict=True):
        errors = [step.cross_validated, *([step.held_out] if step.held_out else [])]
        rows.append([title, *cells(errors), ", ".join(step.tie)])
    return [head, *rows]


def print_steps(terminal: Terminal, improvement: Improvement, file: Path | None) -> None:
    """The table of steps, what its errors were taken on, and effects that were composed and written into a file."""
    rows = steps_table(improvement.steps)
    terminal.table(rows, prose=len(rows[0]) - 1)
    terminal.say(f"({note(improvement)})")
    for words in worse_held_out(improvement.steps):
        terminal.warn(words)
    for made in improvement.composed:
        terminal.say(f"\n{made.effect.name}: {composed_sentence(made)}\n({file}: {made.effect.__name__} written)\n")


def worse_held_out(steps: Sequence[ImprovedModel]) -> list[str]:
    """Steps after which recordings that nothing was chosen by are foretold worse: what they add is not proven."""
    found = []
    for before, after, title in zip(steps, steps[1:], titles(steps)[1:], strict=False):
        then = "do not use it without more runs" if after.kept else "not kept; more runs would settle it"
        for name, (was, now) in after.worse(before).items():
            found.append(f"{title.strip('()')}: held out {was:.3f} -> {now:.3f} {UNITS[name]}, worse: {then}")
    return found


def note(improvement: Improvement) -> str:
    """What the errors of the table were taken on."""
    held_out = any(step.held_out for step in improvement.steps)
    if improvement.last is not None and improvement.last.one_recording:
        return ONE_HELD_OUT if held_out else ONE
    return HELD_OUT if held_out else ALSO_CHOSEN


def steps_section(out: Outcome) -> Section:
    """The first page of report and views."""
    steps, lengths = out.improvement.steps, "displacement" in out.work.rig.channels
    of_what = "um: of the displacement readings, at rest joined at the stop; " if lengths else ""
    said = [
        f"Added: {', '.join(filter(None, added(out.improvement.kept))) or 'nothing'}.",
        out.said,
        *worse_held_out(steps),
        f"Model alone (open loop), rms; {of_what}{note(out.improvement)}.",
    ]
    return Section(f"{out.after.name}: {out.before.name} improved", said, steps_table(steps))


def as_json(improvement: Improvement, file: Path | None) -> dict[str, Any]:
    """The steps for programs; a step that adds nothing has no `added`. `file`: where composed effects were written."""
    steps: dict[bool, list[dict[str, Any]]] = {True: [], False: []}
    for new, step in zip(added(improvement.steps), improvement.steps, strict=True):
        held_out = vars(step.held_out) if step.held_out else None
        row = {"added": new or None, "cross_validated": vars(step.cross_validated), "held_out": held_out}
        steps[step.kept].append(row)
    verdict = improvement.last.verdict if improvement.last else "stopped"
    apart = [{"run": one.apart, "sentence": apart_sentence(one)} for one in improvement.apart]
    made = [composed_json(one, *_held_out(improvement, one), file) for one in improvement.composed]
    uses = recordings_json(improvement.uses)
    return {
        "steps": steps[True], "not_kept": steps[False], "verdict": verdict, "apart": apart, "composed": made,
        "recordings": uses,
    }  # fmt: skip


def _held_out(improvement: Improvement, made: Composed) -> tuple[Error | None, Error | None]:
    """Errors held out before a composed effect and with it."""
    at = next(i for i, step in enumerate(improvement.steps) if step.added == made.effect.name)
    return improvement.steps[at - 1].held_out, improvement.steps[at].held_out
