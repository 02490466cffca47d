"""Swath: the effort that a flight along straight legs puts on the ground beside it."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from math import pi
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from sooner.errors import InvalidProblemError, UnsupportedProblemError
from sooner.grid import Grid

__all__ = ["CUBE_REACH", "Law", "Swath", "pod"]

Law = Literal["seen", "even", "cube", "edged"]
_LAWS = ("seen", "even", "cube", "edged")
CUBE_REACH = 3.0  # sweep widths as far as which the inverse cube is followed: 8 % of its width lie beyond


@dataclass(frozen=True, eq=False)
class Swath:
    """What one look along a leg is worth: effort e on each cell near to it, and POD = 1 - exp(-e) of all effort.

    "seen"   whoever comes within the radius is seen: effort without end
    "edged"  the same, but across an edge of the radius a leg sees ever less of the ground: a share f, e = -ln(1 - f)
    "even"   e = rate * (metres for which the cell is in view)                 [Koopman1956, random search]
             rate = W / (pi R^2) gives a coverage of C = W L / A over any ground, and POD = 1 - exp(-C)
    "cube"   de/ds = W^2 / (8 pi r^3) at a distance r                          [Koopman1956, inverse-cube law]
             a long leg at x to the side has e = W^2 / (4 pi x^2), legs S apart POD = erf(sqrt(pi) W / 2 S)

    Effort is what adds up: over legs, flights and days. It does not count how often a place comes into view, so that
    nothing is gained by flying to and fro at the border of what is in view.

    Parameters
    ----------
    radius_m : float            farthest that anything is seen, R
    law : str                   "seen", "edged", "even" or "cube"
    strength : (N,) float       of each cell: "even": effort a metre in view; "cube": sweep width W; 0: nothing is seen
                                there; "seen": whether anything is; "edged": width of the edge

    Raises
    ------
    InvalidProblemError         if the radius or a strength makes no sense

    Examples
    --------
    >>> ground = Grid((3, 41), cell_m=1.0)
    >>> cube = Swath.of_width(ground, 8.0, law="cube")
    >>> cells, effort, at_m = cube.effort(ground, [[-1000.0, 1.0], [1000.0, 1.0]])
    >>> round(float(effort[cells == ground.index((0, 20))][0]), 3), round(8.0**2 / (4 * np.pi * 1.0**2), 3)
    (5.089, 5.093)
    """

    radius_m: float
    law: Law
    strength: NDArray[np.float64]

    def __post_init__(self) -> None:
        if self.law not in _LAWS:
            raise InvalidProblemError(f"law {self.law!r} came; expected one of {', '.join(_LAWS)}")
        if not (np.isfinite(self.radius_m) and self.radius_m > 0):
            raise InvalidProblemError(f"a radius of {self.radius_m} m came; expected a positive number")
        strength = np.ascontiguousarray(self.strength, np.float64)
        if not (np.isfinite(strength).all() and (strength >= 0).all()):
            raise InvalidProblemError("strengths came negative or not finite; expected numbers of at least 0")
        object.__setattr__(self, "strength", strength.ravel())

    @classmethod
    def seen(cls, grid: Grid, radius_m: float) -> Swath:
        """A perfect sensor over cells that are seen where their centres come within the radius."""
        return cls(radius_m, "seen", np.ones(grid.n_cells))

    @classmethod
    def edged(cls, grid: Grid, radius_m: float) -> Swath:
        """A perfect sensor over ground: of a cell at the border of what is in view a leg sees a part, f.

        f = (R + h / 2 - d) / h within [0, 1],   d to the cell's centre, h the side of a cell

        So a lane is as wide as it is, wherever it lies between the centres of cells. Parts of one cell that different
        legs see count as if they lay at random: 1 - (1 - f_1)(1 - f_2); where lanes just meet, they see more. A part of
        a pass has that part of its effort -ln(1 - f), so that to cut a leg in two gains nothing.
        """
        return cls(radius_m + grid.cell_m / 2, "edged", np.full(grid.n_cells, grid.cell_m))

    @classmethod
    def of_width(cls, grid: Grid, width_m: ArrayLike, radius_m: float | None = None, law: Law = "even") -> Swath:
        """By sweep width W, one for all or one for each cell (H, W); the radius is W / 2 or 3 W if left out."""
        width = np.broadcast_to(np.asarray(width_m, np.float64), grid.shape).ravel()
        widest = float(width.max())
        if radius_m is None:
            radius_m = CUBE_REACH * widest if law == "cube" else widest / 2
        if law == "even" and widest > 2 * radius_m * (1 + 1e-9):
            raise InvalidProblemError(
                f"a sweep width of {widest:g} m and a radius of {radius_m:g} m came; "
                f"expected a radius of at least half the width, {widest / 2:g} m"
            )
        return cls(radius_m, law, width if law == "cube" else width / (pi * radius_m**2))

    @classmethod
    def of_glimpse(cls, grid: Grid, glimpse: ArrayLike, radius_m: float) -> Swath:
        """By the probability g that one pass over a place, as long as passes are on average, detects who is there.

        rate = -ln(1 - g) / (pi R / 2);   where g = 1 everywhere, "edged"; where it is 1 in places, 0.999 stands there
        """
        detect = np.broadcast_to(np.asarray(glimpse, np.float64), grid.shape).ravel()
        if (detect == 1.0).all():
            return cls.edged(grid, radius_m)
        return cls(radius_m, "even", -np.log1p(-np.minimum(detect, 0.999)) / (pi * radius_m / 2))

    @property
    def code(self) -> int:
        """The law's number in compiled code."""
        return _LAWS.index(self.law)

    @cached_property
    def width_m(self) -> float:
        """Sweep width of the best cell, metres: the integral over x of 1 - exp(-e(x)) for a long leg at x to the side.

        This is what one leg finds of people who lie anywhere, for each metre flown [Koopman1956].

        >>> round(Swath.of_width(Grid((1, 1), cell_m=1.0), 10.0, law="cube").width_m, 2)
        9.21
        """
        strength, radius = float(self.strength.max()), self.radius_m
        if self.law == "seen":
            return 2 * radius * float(strength > 0)
        if self.law == "edged":
            return 2 * radius - strength
        x = (np.arange(20_000) + 0.5) / 20_000 * radius
        half = np.sqrt(radius**2 - x**2)
        effort = strength * 2 * half
        if self.law == "cube":
            effort = strength**2 / (4 * pi * x**2) * half / radius
        return float(2 * pod(effort).mean() * radius)

    def effort(
        self, grid: Grid, points: ArrayLike
    ) -> tuple[NDArray[np.int64], NDArray[np.float64], NDArray[np.float64]]:
        """What a flight along a polyline puts on the cells that it sees, leg by leg.

        Parameters
        ----------
        grid : Grid                 square cells, whose centres stand for their ground
        points : (n, 2) float       metres in the frame of `Grid.centres_m`, n >= 1; they may leave the map

        Returns
        -------
        cells : (m,) int64          cell numbers, as often as a leg sees them, in order of legs
        effort : (m,) float         above 0
        at_m : (m,) float           metres along the polyline at which the leg is nearest to the cell
        """
        from sooner.sensors._swath_kernels import line_effort

        if grid.connectivity == "hex":
            raise UnsupportedProblemError("a hexagonal grid came; legs look at square cells only")
        line = np.ascontiguousarray(points, np.float64)
        if line.ndim != 2 or line.shape[1] != 2 or len(line) == 0 or not np.isfinite(line).all():
            raise InvalidProblemError(
                f"a polyline of shape {line.shape} came; expected finite metres east and north, (n, 2) with n >= 1"
            )
        cells, effort, at_m = line_effort(line, grid.cell_m, *grid.shape, self.radius_m, self.code, self.strength)
        return cells, effort, at_m


def pod(effort: ArrayLike) -> NDArray[np.float64]:
    """Probability of detection after so much effort, 1 - exp(-e); for an even rate effort is coverage C.

    >>> pod([0.5, 1.0, 2.0]).round(3)
    array([0.393, 0.632, 0.865])
    """
    return np.asarray(-np.expm1(-np.asarray(effort, np.float64)))
