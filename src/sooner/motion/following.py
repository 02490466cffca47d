"""Heights of a flight that follows the ground by straight lines: few places, near to a surface, never too low."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from sooner.errors import InvalidProblemError
from sooner.motion.pace import Terrain

__all__ = ["followed"]

Floats = NDArray[np.float64]
PIECES = 2  # of the stretch of a leg within one cell, at least


def followed(
    points: ArrayLike, surface: Terrain, ground: Terrain, above_m: float, off_m: float = 2.0
) -> tuple[Floats, Floats]:
    """Where along a flight its height is told, and how high, so that straight lines between stay near a surface.

    |w - (s + a)| <= off   and   w >= g + a      s the surface, g the ground beneath, a metres above, w the flight

    Along a straight leg heights between the centres of cells are quadratic. They are held against the lines by
    Bernstein's coefficients, so that what holds for a few numbers holds everywhere in between. From each place the line
    goes on as far as it can. Where the surface itself is nearer to the ground than its bends, all is lifted by what is
    missing, which is mostly nothing.

    Parameters
    ----------
    points : (n, 2) float       metres east and north; its corners are always told
    surface : Terrain           to follow; nowhere beneath the ground, as `Terrain.smoothed` makes it
    ground : Terrain            on the same cells
    above_m : float             metres to keep above the ground
    off_m : float               farthest from the surface

    Returns
    -------
    along_m : (m,) float        metres along the polyline, rising
    heights : (m,) float        metres, in the surface's own count

    Examples
    --------
    >>> ridge = Terrain(np.array([[0.0, 0, 0, 9, 0, 0, 0]]), cell_m=10.0)
    >>> along, heights = followed([[0, 0], [60, 0]], ridge.smoothed(10.0), ridge, above_m=50.0)
    >>> along, heights
    (array([ 0., 30., 60.]), array([50., 59., 50.]))
    """
    line = np.asarray(points, np.float64)
    if not off_m > 0:
        raise InvalidProblemError(f"off_m = {off_m} came; expected metres above 0")
    if len(line) == 1:
        return np.zeros(1), surface.heights_at(line) + above_m
    lengths = np.hypot(*np.diff(line, axis=0).T)
    found_m, found, missing, begun = [np.zeros(1)], [surface.heights_at(line[:1]) + above_m], 0.0, 0.0
    for start, end, length in zip(line[:-1], line[1:], lengths, strict=True):
        if length > 0.0:
            shares = _ends(start, end, surface.cell_m)
            wanted = _coefficients(start, end, shares, surface) + above_m
            least = _coefficients(start, end, shares, ground) + above_m
            kept = _kept(shares * length, wanted, least, off_m)
            at = np.ravel(np.column_stack([shares[:-1], (shares[:-1] + shares[1:]) / 2]))
            heights = wanted[::2][kept]
            flown = np.interp(np.append(at, 1.0), shares[kept], heights)
            missing = max(missing, float((least - flown).max()))
            found_m.append(begun + shares[kept[1:]] * length)
            found.append(heights[1:])
        begun += length
    return np.concatenate(found_m), np.concatenate(found) + missing


def _ends(start: Floats, end: Floats, cell_m: float) -> Floats:
    """(k,) float: shares of a leg at which it passes from cell to cell, and some between; 0 first and 1 last."""
    crossed = [np.array([0.0, 1.0])]
    for a, b in zip(start / cell_m, end / cell_m, strict=True):
        if a != b:
            lines = np.arange(np.ceil(min(a, b)), np.floor(max(a, b)) + 1)
            crossed.append((lines - a) / (b - a))
    shares = np.unique(np.clip(np.concatenate(crossed), 0.0, 1.0))
    shares = shares[np.append(True, np.diff(shares) > 1e-12)]
    shares[-1] = 1.0
    between = shares[:-1, None] + np.diff(shares)[:, None] * np.arange(PIECES) / PIECES
    return np.append(between.ravel(), 1.0)


def _coefficients(start: Floats, end: Floats, shares: Floats, terrain: Terrain) -> Floats:
    """(2 k - 1,) float: heights at the shares, and between any two Bernstein's middle coefficient of the quadratic."""
    middles = (shares[:-1] + shares[1:]) / 2
    at, between = (terrain.heights_at(start + each[:, None] * (end - start)) for each in (shares, middles))
    found = np.empty(2 * len(shares) - 1)
    found[::2] = at
    found[1::2] = 2.0 * between - (at[:-1] + at[1:]) / 2
    return found


def _kept(at_m: Floats, wanted: Floats, least: Floats, off_m: float) -> NDArray[np.intp]:
    """Which ends of pieces are told: from each the farthest to which a straight line keeps to the rules."""
    all_m = np.empty(len(wanted))
    all_m[::2], all_m[1::2] = at_m, (at_m[:-1] + at_m[1:]) / 2
    low, high = np.maximum(wanted - off_m, np.minimum(least, wanted)), wanted + off_m
    kept, here = [0], 0
    while here < len(wanted) - 1:
        run = all_m[here + 1 :] - all_m[here]
        slopes = (wanted[here + 1 :] - wanted[here]) / run
        floor = np.maximum.accumulate((low[here + 1 :] - wanted[here]) / run)
        roof = np.minimum.accumulate((high[here + 1 :] - wanted[here]) / run)
        tiny = 1e-12 * (1.0 + np.abs(slopes))
        reached = np.flatnonzero((slopes >= floor - tiny) & (slopes <= roof + tiny))
        ends = reached[reached % 2 == 1]  # control points between ends are no places
        here += int(ends[-1]) + 1 if len(ends) else 2
        kept.append(here // 2)
    return np.array(kept)
