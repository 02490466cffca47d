"""Drift: a person who wanders, or heads somewhere, as a Markov chain over cells."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from sooner.errors import InvalidProblemError
from sooner.grid import Grid

__all__ = ["drift_transition"]


def drift_transition(grid: Grid, move: float, heading: float | None = None, persistence: float = 1.0) -> Any:
    """One-step transition of a person who leaves the cell with probability `move`.

    P(i -> j) = move exp(persistence cos(a_ij - heading)) / sum over neighbours,    P(i -> i) = 1 - move

    a_ij is the direction from i to j. A von Mises weight on the heading makes the walk biased; without a heading all
    neighbours are alike. What would step off the map or onto an obstacle goes to the other neighbours.

    Parameters
    ----------
    grid : Grid
    move : float               probability of leaving the cell in one step, in [0, 1]
    heading : float or None    where the person tends to go, radians counter-clockwise from east
    persistence : float        how strongly: 0 not at all

    Returns
    -------
    (N, N) scipy.sparse.csr_array, rows of passable cells total one

    Examples
    --------
    >>> drift_transition(Grid((1, 3)), move=0.5).toarray()
    array([[0.5 , 0.5 , 0.  ],
           [0.25, 0.5 , 0.25],
           [0.  , 0.5 , 0.5 ]])
    """
    from scipy.sparse import csr_array

    if not 0.0 <= move <= 1.0:
        raise InvalidProblemError(f"a probability to move of {move} came; expected a number in [0, 1]")
    cells, slots = np.nonzero(grid.neighbours >= 0)
    others = grid.neighbours[cells, slots].astype(np.int64)
    weights = _weights(grid, cells, others, heading, persistence)
    totals = np.bincount(cells, weights, grid.n_cells)
    stay = np.where(totals > 0, 1.0 - move, 1.0)
    everyone = np.arange(grid.n_cells)
    rows, cols = np.concatenate([cells, everyone]), np.concatenate([others, everyone])
    values = np.concatenate([move * weights / totals[cells], stay])
    return csr_array((values, (rows, cols)), shape=(grid.n_cells, grid.n_cells))


def _weights(
    grid: Grid, cells: NDArray[np.intp], others: NDArray[np.int64], heading: float | None, persistence: float
) -> NDArray[np.float64]:
    if heading is None:
        return np.ones(len(cells))
    east, north = (grid.centres_m[others] - grid.centres_m[cells]).T
    turned: NDArray[np.float64] = np.exp(persistence * np.cos(np.arctan2(north, east) - heading))
    return turned
