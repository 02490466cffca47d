"""Cells that are void, unoccupied or occupied: where streets run, and where on them the target is."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from sooner.errors import InvalidProblemError

__all__ = ["CellStates", "odds_of_confidence"]

Floats = NDArray[np.float64]
Bools = NDArray[np.bool_]
TOTAL = 1e-9  # how far from one the three may total


def odds_of_confidence(confidence: float) -> float:
    """The odds p / (1 - p) at which a hypothesis is accepted; the paper's 95 % are odds of 19.

    >>> round(odds_of_confidence(0.95), 9)
    19.0
    """
    if not 0.0 < confidence < 1.0:
        raise InvalidProblemError(f"a confidence of {confidence} came; expected one between 0 and 1")
    return confidence / (1.0 - confidence)


@dataclass(frozen=True, eq=False)
class CellStates:
    """Probabilities of each cell's state, by itself: void (no node), unoccupied (a node), occupied (node and target).

    v + u + o = 1                                                             [Wolek2020, section II.D]

    Parameters
    ----------
    void, unoccupied, occupied : (M,) float    v, u, o, which total one in each cell
    explored : (M,) bool                       cells that have been in view
    nodes : (M,) bool                          cells whose node is detected

    Raises
    ------
    InvalidProblemError        if shapes differ, or the three are no probabilities that total one

    Notes
    -----
    A value of this type never changes under its methods, which return a new one. The kernels that they call write in
    place; a simulation that owns its arrays calls those.

    Examples
    --------
    >>> states = CellStates.unknown(1600)
    >>> f"{states.void[0]:.3f} {states.unoccupied[0]:.3f} {states.occupied[0]:.2e}"
    '0.900 0.100 3.12e-05'
    """

    void: Floats
    unoccupied: Floats
    occupied: Floats
    explored: Bools
    nodes: Bools

    def __post_init__(self) -> None:
        shapes = {a.shape for a in (self.void, self.unoccupied, self.occupied, self.explored, self.nodes)}
        if len(shapes) > 1 or len(next(iter(shapes))) != 1:
            raise InvalidProblemError(f"states of shapes {sorted(shapes)} came; expected (M,) five times")
        three = np.stack([self.void, self.unoccupied, self.occupied])
        if not (three >= 0).all() or not (np.abs(three.sum(axis=0) - 1.0) <= TOTAL).all():
            raise InvalidProblemError("void, unoccupied and occupied came; expected probabilities that total one")

    @classmethod
    def unknown(cls, n_cells: int, void: float = 0.9, absent: float = 0.5) -> CellStates:
        """Nothing is known: every cell alike.

        o = (1 - v) (1 - p_absent) / M,  u = 1 - v - o

        Parameters
        ----------
        n_cells : int          M
        void : float           v, in (0, 1)
        absent : float         P(there is no target), in [0, 1)

        Notes
        -----
        The paper prints eta = p_absent / M as the share of 1 - v that is unoccupied, which would make nearly every
        node occupied; the shares are exchanged here. It does not say v.
        """
        if n_cells < 1:
            raise InvalidProblemError(f"{n_cells} cells came; expected at least 1")
        if not (0.0 < void < 1.0 and 0.0 <= absent < 1.0):
            raise InvalidProblemError(f"void = {void} and absent = {absent} came; expected probabilities below 1")
        from sooner.belief._cell_state_kernels import expect_void

        v, u, o = np.full(n_cells, void), np.empty(n_cells), np.empty(n_cells)
        explored = np.zeros(n_cells, bool)
        expect_void(v, u, o, explored, v.copy(), float(absent))
        return cls(v, u, o, explored, np.zeros(n_cells, bool))

    @classmethod
    def known_map(cls, nodes: ArrayLike, absent: float = 0.5) -> CellStates:
        """The map is known, the target is not: (M,) bool says which cells hold a node.

        Raises
        ------
        InvalidProblemError    if no cell holds one
        """
        held = np.array(nodes, bool)
        if held.ndim != 1 or not held.any():
            raise InvalidProblemError(f"nodes of shape {held.shape}, {held.sum()} true, came; expected (M,), some true")
        o = held * ((1.0 - absent) / held.sum())
        return cls((~held).astype(np.float64), held - o, o, np.ones(held.size, bool), held)

    def see(self, cells: ArrayLike, map_ratios: ArrayLike, target_ratios: ArrayLike) -> CellStates:
        """What looks at some cells teach of them; cells whose node is detected stay as they are.

        v' = v / c,  u' = u G / c,  o' = o G Z / c,  c = v + u G + o G Z          [Wolek2020, eq. (7) to (9)]

        Parameters
        ----------
        cells : (k,) int                 a cell may come more than once
        map_ratios : (k,) float          G = P(level | node) / P(level | void) of what the map sensor reports
        target_ratios : (k,) float       Z = P(level | target) / P(level | none) of what the target sensor reports

        Raises
        ------
        InvalidProblemError              if the three differ in length, or a ratio is not positive and finite

        Notes
        -----
        Numerators and denominators of the paper are divided by g(l|V) z(f|V,U), so that sensors may differ.
        """
        from sooner.belief._cell_state_kernels import see

        where = np.ascontiguousarray(cells, np.int32)
        g, z = np.ascontiguousarray(map_ratios, np.float64), np.ascontiguousarray(target_ratios, np.float64)
        if not where.shape == g.shape == z.shape or not ((g > 0) & (z > 0) & np.isfinite(g * z)).all():
            raise InvalidProblemError(f"{g.size} and {z.size} ratios came for {where.size} cells; expected as many > 0")
        after = self.copy()
        see(after.void, after.unoccupied, after.occupied, after.explored, after.nodes, where, g, z, 0, where.size)
        return after

    def detect_nodes(self, odds: float = 19.0) -> tuple[CellStates, NDArray[np.int64]]:
        """Detect nodes where (1 - v) / v reaches the odds; also the cells that are new [Wolek2020, section II.D]."""
        from sooner.belief._cell_state_kernels import detect_nodes

        after, cells = self.copy(), self._seen
        found = np.empty(cells.size, np.int64)
        three = after.void, after.unoccupied, after.occupied
        n = detect_nodes(*three, after.nodes, cells, 0, cells.size, float(odds), found)
        return after, found[:n]

    def detect_target(self, odds: float = 19.0) -> int | None:
        """The cell likeliest to be occupied, if o / (1 - o) reaches the odds there: the cell-wise test (CBHT).

        [Wolek2020, section II.D]
        """
        from sooner.belief._cell_state_kernels import detect_target

        cells = self._seen
        cell = detect_target(self.void, self.unoccupied, self.occupied, cells, 0, cells.size, float(odds))
        return int(cell) if cell >= 0 else None

    @property
    def _seen(self) -> NDArray[np.int32]:
        return np.flatnonzero(self.explored).astype(np.int32)

    def with_ratios(self, cells: ArrayLike, ratios: ArrayLike) -> CellStates:
        """Cells of nodes set by the likelihood ratio of a target there: (v, u, o) = (0, 1, ratio) / (ratio + 1).

        [Wolek2020, section III.B]
        """
        from sooner.belief._cell_state_kernels import set_nodes

        after = self.copy()
        where, values = np.ascontiguousarray(cells, np.int64), np.ascontiguousarray(ratios, np.float64)
        if where.shape != values.shape or not (values >= 0).all() or not np.isfinite(values).all():
            raise InvalidProblemError(f"{values.size} ratios came for {where.size} cells; expected as many >= 0")
        set_nodes(after.void, after.unoccupied, after.occupied, where, values)
        return after

    def expecting(self, void: ArrayLike, absent: float = 0.5) -> CellStates:
        """Cells never in view given the void probability (M,) expected of them, as `StreetKriging` does.

        u' and o' share 1 - v as in `unknown`, with the number of cells never in view for M [Wolek2020, section III.C].
        """
        from sooner.belief._cell_state_kernels import expect_void

        expected = np.ascontiguousarray(void, np.float64)
        if expected.shape != self.void.shape or not ((expected >= 0) & (expected <= 1)).all():
            raise InvalidProblemError(f"void of shape {expected.shape} came; expected (M,) probabilities")
        after = self.copy()
        expect_void(after.void, after.unoccupied, after.occupied, after.explored, expected, float(absent))
        return after

    def copy(self) -> CellStates:
        """The same, on arrays of its own."""
        v, u, o = self.void.copy(), self.unoccupied.copy(), self.occupied.copy()
        return CellStates(v, u, o, self.explored.copy(), self.nodes.copy())
