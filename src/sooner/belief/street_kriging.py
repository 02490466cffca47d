"""Kriging along streets: where nodes are likely that nobody has seen, from the cells that were seen."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike, NDArray

from sooner.errors import InvalidProblemError
from sooner.grid import Grid

__all__ = ["KrigingSession", "StreetKriging", "street_directions"]

Floats = NDArray[np.float64]

ERROR = 5e-4  # root mean square that a solution may leave of the void probabilities it is to meet
LEAST = 5e-4  # covariances below it are left out of the stencil
MOST = 60  # rounds of conjugate gradients


def street_directions(angles: ArrayLike, most: int = 4, bin_degrees: int = 2) -> tuple[Floats, Floats]:
    """The dominant directions of streets, and the weight of each: peaks of a histogram of edge directions.

    Parameters
    ----------
    angles : (E,) float          radians, of the edges explored so far; opposite directions are one
    most : int                   P, how many directions at most
    bin_degrees : int            width of a bin, a divisor of 180

    Returns
    -------
    angles : (P or fewer,) float radians in [0, pi), the heaviest first
    weights : (P or fewer,)      total one

    Notes
    -----
    The paper says peaks and no more. A peak is here three neighbouring bins with the most edges, at the middle one,
    and weighs what they hold; they are then emptied. Before any edge is known, `most` equal parts of the circle.

    Examples
    --------
    >>> angles, weights = street_directions(np.radians([11, 13, 191, 101]))
    >>> np.degrees(angles).round(), weights
    (array([ 11., 101.]), array([0.75, 0.25]))
    """
    if most < 1 or bin_degrees < 1 or 180 % bin_degrees:
        raise InvalidProblemError(
            f"{most} directions and bins of {bin_degrees} degrees came; expected at least 1, and a divisor of 180"
        )
    edges = np.ascontiguousarray(angles, np.float64)
    if not np.isfinite(edges).all():
        raise InvalidProblemError("an edge direction came that is not finite; expected radians")
    from sooner.belief._street_kriging_kernels import peaks

    found, shares = np.empty(most), np.empty(most)
    n = peaks(edges, np.empty(180 // bin_degrees), found, shares)
    return found[:n], shares[:n]


@dataclass(frozen=True)
class StreetKriging:
    """Ordinary kriging of void probabilities, with cells alike along the directions of streets.

    K(h) = sum_p w_p exp(-|T R_p h|),  T = diag(1 / a_max, 1 / a_min)          [Wolek2020, section III.C]

    R_p turns the lag h into direction p. There is no nugget; weights of the explored cells total one.

    Parameters
    ----------
    along_m : float          a_max, the scale along a street
    across_m : float         a_min, the scale across it
    directions : int         P
    floor : float            predictions are clipped to [floor, 1 - floor]: 0 or 1 would never be taken back

    Raises
    ------
    InvalidProblemError      if a scale is not positive, there is no direction, or the floor is not in (0, 0.5)

    Examples
    --------
    >>> void = np.array([[0.0, 0.0, 0.9, 0.9, 0.9], [1.0, 1.0, 0.9, 0.9, 0.9]]).ravel()
    >>> explored = np.array([[True, True, False, False, False]] * 2).ravel()
    >>> east = np.array([0.0]), np.array([1.0])
    >>> StreetKriging().dense(Grid((2, 5), cell_m=5.0), void, explored, *east).reshape(2, 5).round(2)
    array([[0.  , 0.  , 0.32, 0.43, 0.48],
           [1.  , 1.  , 0.68, 0.57, 0.52]])
    """

    along_m: float = 5.0
    across_m: float = 0.5
    directions: int = 4
    floor: float = 0.01

    def __post_init__(self) -> None:
        if not all(np.isfinite(scale) and scale > 0 for scale in (self.along_m, self.across_m)):
            raise InvalidProblemError(f"scales of {self.along_m} and {self.across_m} m came; expected positive numbers")
        if self.directions < 1 or not 0.0 < self.floor < 0.5:
            raise InvalidProblemError(
                f"{self.directions} directions and a floor of {self.floor} came; expected at least 1, and (0, 0.5)"
            )

    def dense(self, grid: Grid, void: ArrayLike, explored: ArrayLike, angles: Floats, weights: Floats) -> Floats:
        """(M,) void probabilities: of explored cells as they are, of others as kriged; by the full linear system.

        [K 1; 1' 0] [l; m] = [k; 1],  v_krig = l' v

        Parameters
        ----------
        void : (M,) float; explored : (M,) bool, some true
        angles, weights : (P,) float       as `street_directions` gives them

        Notes
        -----
        To read and to test with: time grows with the cube of the number of explored cells. `session` is for flying.
        """
        v, seen = np.asarray(void, np.float64), np.asarray(explored, bool)
        if not seen.any():
            raise InvalidProblemError("no explored cell came; expected some to krige from")
        known, places = np.flatnonzero(seen), grid.centres_m
        K = self._covariances(places[known], places[known], angles, weights)
        k = self._covariances(places[known], places[~seen], angles, weights)
        ones = np.ones((known.size, 1))
        system = np.block([[K, ones], [ones.T, np.zeros((1, 1))]])
        solution = np.linalg.solve(system, np.vstack([k, np.ones((1, k.shape[1]))]))
        out = v.copy()
        out[~seen] = np.clip(v[known] @ solution[:-1], self.floor, 1.0 - self.floor)
        return out

    def session(self, grid: Grid) -> KrigingSession:
        """One search on one grid, which begins each solution where the last ended."""
        if grid.connectivity == "hex":
            raise InvalidProblemError("hexagonal cells came; expected square ones")
        return KrigingSession(self, grid)

    def reach(self, grid: Grid) -> int:
        """Cells each way beyond which covariance is left out: four scales, exp(-4) = 0.02 of a direction's weight."""
        return int(np.ceil(4.0 * max(self.along_m, self.across_m) / grid.cell_m))

    def _covariances(self, a: Floats, b: Floats, angles: Floats, weights: Floats) -> Floats:
        """(n, m) of places (n, 2) and (m, 2)."""
        east, north = (a[:, None, axis] - b[None, :, axis] for axis in (0, 1))
        total = np.zeros(east.shape)
        for angle, weight in zip(angles, weights, strict=True):
            along = (np.cos(angle) * east + np.sin(angle) * north) / self.along_m
            across = (np.cos(angle) * north - np.sin(angle) * east) / self.across_m
            total += weight * np.exp(-np.hypot(along, across))
        return total


@dataclass(frozen=True, eq=False)
class KrigingSession:
    """Kriging again and again as a search goes on, by conjugate gradients on a stencil.

    Not a value: it keeps its last solutions, to begin the next from.
    """

    method: StreetKriging
    grid: Grid

    @cached_property
    def _room(self) -> Floats:
        rows, cols = (size + 2 * self.method.reach(self.grid) for size in self.grid.shape)
        return np.zeros((8, rows * cols))

    def copy(self) -> KrigingSession:
        """The same session, to go on by itself."""
        other = KrigingSession(self.method, self.grid)
        other.restore(self)
        return other

    def restore(self, kept: KrigingSession) -> None:
        """Begin the next solution where the session that was kept would."""
        np.copyto(self._room, kept._room)

    def expected_void(
        self, void: Floats, explored: NDArray[np.bool_], edge_angles: ArrayLike, out: Floats | None = None
    ) -> Floats:
        """(M,) void probabilities, of explored cells as they are and of others as kriged.

        Parameters
        ----------
        void : (M,) float; explored : (M,) bool
        edge_angles : (E,) float       radians, directions of the edges explored so far
        out : (M,) float               where to write; None: a new array

        Returns
        -------
        (M,) float                     as `void` where nothing is explored yet

        Notes
        -----
        Differs from `StreetKriging.dense` by what the stencil leaves out and by where the solution stops, at most by
        0.005 with the paper's scales.
        """
        from sooner.belief._street_kriging_kernels import krige

        told = np.empty_like(void) if out is None else out
        angles, weights = street_directions(edge_angles, self.method.directions)
        height, width = self.grid.shape
        rounds = krige(
            void, explored, height, width, self.method.reach(self.grid), angles, weights, self.method.along_m,
            self.method.across_m, self.grid.cell_m, LEAST, ERROR, MOST, self.method.floor, self._room, told,
        )  # fmt: skip
        if rounds < 0:
            told[:] = void
        return told
