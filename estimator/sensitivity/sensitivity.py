"""How the open-loop run moves with each parameter."""

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from itertools import islice

import numpy as np

from estimator.batch.kernels import coast
from estimator.batch.nominal import lagging
from estimator.batch.trial import Posed
from estimator.network.regime import rows_of
from estimator.record import Array
from estimator.sensitivity.tangent import Tangent
from estimator.state.open_loop import lag_filter

TOGETHER = 32  # tangents that run side by side, of a run of so many ticks or less: fewer of a longer one, or all that
TICKS = 2500  # is worked out of them leaves the processor's cache


@dataclass(frozen=True)
class NominalColumn:
    """How the open-loop run moves with one parameter: reading (T, m) of each channel, growth of the span (T,), states
    z (T, n)."""

    reading: Array
    grown: Array
    z: Array


def nominal_columns(posed: Posed, moved: Iterable[Tangent]) -> Iterator[NominalColumn]:
    """Take tangents through the open-loop run, some side by side."""
    rest, together = iter(moved), max(4, TOGETHER * TICKS // max(TICKS, len(posed.heat)))
    while some := list(islice(rest, together)):
        yield from _side_by_side(posed, some)


def _side_by_side(posed: Posed, moved: Sequence[Tangent]) -> Iterator[NominalColumn]:
    run, zeros = posed.run, np.zeros((len(moved), posed.state.size))
    for x0, each in zip(zeros, moved, strict=True):
        x0[:] = each.readings.x0 if each.readings is not None else 0.0
    z0 = zeros[:, posed.state.temperatures]
    z = np.concatenate([z0[:, None], coast(posed.system.F, posed.system.regime, pushed(posed, moved), z0)], axis=1)
    spot, grown = z @ run.readings.rows.T, (z[:, 1:] - z[:, :1]) @ run.growth
    quick = np.zeros_like(spot[:, 1:])
    before = np.vstack([run.spot[:1], run.lagged[:-1]])
    for k, each in enumerate(moved):
        if each.readings is not None and each.readings.moves:
            spot[k] += run.z @ each.readings.rows.T
            grown[k] += (run.z[1:] - run.z[0]) @ each.readings.growth
            quick[k] = (before - run.spot[:-1]) * each.readings.keep + np.diff(run.spot, axis=0) * each.readings.ramp
    lagged = lagging(*lag_filter(run.readings.tau, run.tick_s), spot, quick)
    late = -np.diff(spot, axis=1) * run.late_share
    for k, each in enumerate(moved):
        zero = posed.state.channel_zeros(zeros[k])
        yield NominalColumn(each.offset + lagged[k] + late[k] + zero, grown[k], z[k, 1:])


def pushed(posed: Posed, moved: Sequence[Tangent]) -> Array:
    """What each tick adds to how the states move, K, beside what is carried over from the tick before: (k, T, n)."""
    regime, forcing, before = posed.system.regime, posed.forcing, posed.run.z[:-1]
    conducting = [k for k, each in enumerate(moved) if np.any(each.network.mass) or np.any(each.network.conductance)]
    mass, conductance = ([getattr(moved[k].network, key) for k in conducting] for key in ("mass", "conductance"))
    shifts = [bool(np.any(each.network.inflow) or np.any(each.outside)) for each in moved]
    out = np.zeros((len(moved), *posed.heat.shape))
    for r in np.unique(regime):
        at = rows_of(regime, r)
        J, outside, given = forcing.transition(r).J, posed.outside[at], np.hstack([posed.heat[at], before[at]])
        for b, each, shifted in zip(out, moved, shifts, strict=True):
            put = each.heat[at]
            if shifted:
                put = put + outside @ each.network.inflow[r].T + each.outside[at] @ forcing.inflow(r).T
            if shifted or put.any():
                b[at] = put @ J.T
        if conducting:
            of_F, of_J = forcing.modes_of(r).along(np.array(mass), np.array([each[r] for each in conductance]))
            for k, more in zip(conducting, given @ np.concatenate([of_J, of_F], axis=2).mT, strict=True):
                out[k][at] += more
    return out
