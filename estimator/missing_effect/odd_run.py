"""The recording among several that the others do not foretell, while they agree with each other."""

import numpy as np

from estimator.batch.trials import Trials
from estimator.hypotheses.ground import Ground
from estimator.hypotheses.moments import moments
from estimator.hypotheses.panel import Panel
from estimator.hypotheses.slopes import Column

ODD = 3.0  # times the others' misfit makes a run odd ...
BAD = 2.0  # ... if it is no good model either
FEWEST = 3  # recordings, of which two agree


def odd_run(ground: Ground, trials: Trials) -> int | None:
    """The one without which the others are foretold best; None where it is no worse than they are."""
    if len(trials) < FEWEST:
        return None
    columns = [Column(ground.model, path) for path in ground.paths]
    known, found = ground.belief(ground.model, ground.paths), moments(trials, ground.model, columns, ground.model)
    missed = Panel(columns, found, known).judge().runs
    without = [Panel(columns, [*found[:i], *found[i + 1 :]], known).judge() for i in range(len(found))]
    at = int(np.argmin([each.misfit for each in without]))
    return at if missed[at] > max(BAD, ODD * float(np.median(without[at].runs))) else None
