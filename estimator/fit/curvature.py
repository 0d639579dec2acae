"""The curvature of a sum of squares f'f / 2, and the step that it leads to, inside bounds.

    J'J + B          J: how f moves with p parameters, so that J'J would be all if it did so evenly
    B <- B + w w' / (w'd)      w = g(x + d) - g(x) - (J'J + B) d      g = J'f      (symmetric rank one)

B is what slopes have changed by beyond J'J. Heat that moves along the screw does so from cell to cell: the sum is least
where it bends, and only B leads along such a bend.
"""

import numpy as np
import scipy

from estimator.record import Array

SURE = 1e-12  # of a parameter's own: the least curvature of a direction
PLAIN = 1e-8  # below which the cosine between w and d makes B unsure


class Curvature:
    """What is known of the curvature by p parameters beside J'J, from one place to the next."""

    def __init__(self, parameters: int) -> None:
        self._beyond = np.zeros((parameters, parameters))

    def step(self, slope: Array, square: Array, room: Array) -> tuple[Array, float]:
        """The step (p,) within room (2, p) that leads lowest, and by how much f'f should fall; J'f (p,), J'J (p, p)."""
        H = square + self._beyond
        size = np.sqrt(np.maximum(np.abs(np.diag(H)), SURE))
        rates, ways = np.linalg.eigh(H / np.outer(size, size))
        roots = np.sqrt(np.maximum(np.abs(rates), SURE))
        goal = -(ways / roots).T @ (slope / size)
        step = scipy.optimize.lsq_linear((ways * roots).T, goal, room * size, method="bvls").x / size
        return step, float(-2.0 * slope @ step - step @ H @ step)

    def learn(self, step: Array, before: Array, square: Array, after: Array) -> None:
        """What a step (p,) has changed the slope by, from before with J'J to after."""
        beyond = after - before - (square + self._beyond) @ step
        along = float(beyond @ step)
        if abs(along) > PLAIN * float(np.linalg.norm(beyond) * np.linalg.norm(step)):
            self._beyond = self._beyond + np.outer(beyond, beyond) / along
