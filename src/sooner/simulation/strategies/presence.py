"""A planner's own belief where the target is, which does not forget, and what each cell weighs in a plan."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from sooner.belief.cell_states import CellStates
from sooner.grid import Grid

__all__ = ["Presence"]


@dataclass(eq=False)
class Presence:
    """Where the target is, given that there is one: uniform over likely nodes at first, then looked for as it walks.

    b_c = r_c (1 - v_c),   r'_c = r_c / 2 + (1 / 2) sum_j b_j / max(sum of 1 - v around j, least),   j beside c

    and a look multiplies r by its likelihood ratio. Half of the targets stay for a second, the others go to a node
    beside, as far as nodes are known; the tracker of the estimator returns to its prior within ten seconds or so.

    Parameters
    ----------
    grid : Grid
    states : CellStates      what is believed of cells now; replaced at a replan, never written
    least : float            nodes that there are around any node, at least
    """

    grid: Grid
    states: CellStates
    least: float = 0.3
    near: int = 6
    shares: NDArray[np.float64] = field(init=False)

    def __post_init__(self) -> None:
        self.shares = np.full(self.grid.n_cells, 1.0 / max(float((1.0 - self.states.void).sum()), 1e-9))
        self._room = np.empty((2, self.grid.n_cells))

    def watch(self, cells: NDArray[np.int32], target_ratios: NDArray[np.float64]) -> None:
        """One second: looks, and then the target moves.

        cells : (k,) int32; target_ratios : (k,) float, P(level | target) / P(level | none)
        """
        from sooner.simulation.strategies._coverage_kernels import drift, look

        look(self.shares, cells, target_ratios)
        drift(self.shares, self.states.void, *self.grid.shape, 1, self.least, *self._room)

    def found(self, cell: int) -> None:
        """A target was found in a cell; there is another: near the cell nothing says more for it than elsewhere."""
        rows, cols = np.divmod(np.arange(self.grid.n_cells), self.grid.shape[1])
        near = np.maximum(np.abs(rows - rows[cell]), np.abs(cols - cols[cell])) <= self.near
        likely = (1.0 - self.states.void)[~near]
        level = float((self.shares[~near] * likely).sum() / max(float(likely.sum()), 1e-9))
        self.shares[near] = np.minimum(self.shares[near], level)
        self.shares /= float((self.shares * (1.0 - self.states.void)).sum())

    def weigh(self, target: float, weights: NDArray[np.float64], expected: NDArray[np.float64] | None = None) -> None:
        """Write (M,) w = n / N + target b: the worth of a cell's first view coming a second sooner.

        expected : (M,) float or None      void probabilities that are thought better than those of the states
        """
        from sooner.simulation.strategies._coverage_kernels import weigh

        void = self.states.void if expected is None else expected
        weigh(void, self.states.nodes, self.shares, target, weights)
