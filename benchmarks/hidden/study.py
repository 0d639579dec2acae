"""One case, from the machine's runs to what is said of them."""

from time import perf_counter

from benchmarks import paper_rig
from benchmarks.hidden.cases import Case
from benchmarks.hidden.models import model_of
from benchmarks.hidden.outcome import Outcome, figures, of_improvement, of_suggestion
from benchmarks.hidden.recorded import Recorded, recorded
from benchmarks.hidden.true_law import true_law
from benchmarks.measure import timed
from drivers.virtual_rig.machine.drawn import DRAWN, drawn
from estimator.accuracy.horizon import open_loop_error
from estimator.batch.trials import trials_of
from estimator.effects import CATALOGUE
from estimator.events.events import events
from estimator.fit.open_loop_fit import follow
from estimator.missing_effect.improve import improve
from estimator.missing_effect.suggest import suggest
from estimator.model import Model
from estimator.rig import Rig
from estimator.work import Runs

COMPOSED = ("drawn", "reading", "bare")  # rows that ask `improve --compose`; the last of them without any catalogue
IMPROVED = ("two", "three", *COMPOSED)  # rows that ask `improve`; the others ask `suggest`
TIMED = ("event", "none")  # rows that are asked what began within a run, by `diagnose` and by `suggest`
PLACED = {"local_heat": "at", "local_heat_driving": "at", "channel_offset": "channel", "channel_gain": "channel"}


def study(case: Case) -> Outcome:
    """What comes out of a case; what is raised on the way comes out as well."""
    began = perf_counter()
    try:
        out = _searched(case)
    except Exception as error:  # a case that fails is one of those that came out wrong
        out = Outcome(error=f"{type(error).__name__}: {error}")
    out.seconds = perf_counter() - began
    return out


def _searched(case: Case) -> Outcome:
    rig = paper_rig.rig()
    of = recorded(case, rig)
    model = model_of(case, rig, of.seen)
    runs, effects = Runs(rig, of.seen), [] if case.row == COMPOSED[-1] else list(CATALOGUE.values())
    if case.row in IMPROVED:
        compose = () if case.row in COMPOSED else None
        done, search_s, _ = timed(lambda: improve(model, runs, Runs(rig, of.held_out), effects, compose))
        out = of_improvement(done, model)
        if case.hidden.names:
            out.knowing = _held_out(knowing(case, model, of, rig), of, rig)
    else:
        found, search_s, _ = timed(lambda: suggest(model, runs, effects))
        out = of_suggestion(found, model, rig)
        out.before = _held_out(found.before.model, of, rig)
        out.after = _held_out(found.found[0].model, of, rig) if out.said else out.before
    if case.row in TIMED:
        told = [*events(model, runs), *found.events]
        out.began = [(event.run, event.since_s, event.kind) for event in told]
    out.search_s, out.broken, out.happened = search_s, (of.odd, of.channel), (of.odd, of.onset_s)
    return out


def knowing(case: Case, model: Model, of: Recorded, rig: Rig) -> Model:
    """The model with what is planted added where it sits, all its free parameters fitted."""
    known_laws = {**CATALOGUE, DRAWN: true_law(drawn(case.seed))}
    for name in case.hidden.names:
        model = model + known_laws[name] if name not in model.effects else model
    at = {f"{name}.{PLACED[name]}": place for name, place in of.places.items() if name in PLACED}
    known = model.with_values(at)
    return follow(known, Runs(rig, of.seen), known.free()).model


def _held_out(model: Model, of: Recorded, rig: Rig) -> tuple[float, ...]:
    return figures(open_loop_error(model, trials_of(model, Runs(rig, of.held_out)))) if of.held_out else ()
