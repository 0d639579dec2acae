"""The run that would tell rivals apart."""

from __future__ import annotations

from estimator.batch.trials import slow_trials_of
from estimator.effects import CATALOGUE
from estimator.hypotheses.candidates import candidates
from estimator.hypotheses.ground import Ground
from estimator.hypotheses.hypothesis import refined
from estimator.missing_effect.next_run import next_run
from estimator.work import Runs
from tests.estimator.conftest import with_effect


def test_a_run_that_decides_sets_rivals_apart(plain, bar, lives):
    """Churning against a nut that simply rubs more: a long drive tells, since churning fades."""
    runs = lives(with_effect(plain, "churning", share=0.3))[:1]
    wide, found = candidates(plain, bar, [CATALOGUE["churning"]])
    trials = slow_trials_of(wide, Runs(bar, runs))
    churning = refined(Ground(plain, ()), trials, found, {"churning.share": 0.3})
    rubbing = refined(Ground(plain, ("nut_friction.power",)), trials, [])
    run = next_run(churning, rubbing, Runs(bar, runs))
    assert run.separation_sd > 3
    assert run.pattern in ("FS", "CS", "ES")
    itself = next_run(churning, churning, Runs(bar, runs))
    assert itself.separation_sd < 0.2
