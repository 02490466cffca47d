"""Gains: what the k-th look at each cell pays, wherever the numbers came from."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from sooner.belief import Belief
from sooner.errors import InvalidProblemError
from sooner.sensors import miss_after_looks

__all__ = ["Gains", "detection_gains", "effort_gains"]

CORRELATED_LOOKS = 16  # columns kept of a table that has no closed tail


@dataclass(frozen=True, eq=False)
class Gains:
    """What looks pay: a table of the first L looks of every cell, then a geometric tail.

    gain(i, k) = table[i, k]                           for look k = 0, 1, ..., L - 1
               = table[i, L - 1] ratio[i]^(k - L + 1)  afterwards

    Looks that are independent need one column: table = p g, ratio = 1 - g. Any other table that never rises
    fits as it stands, with ratio 0 where later looks pay nothing.

    Parameters
    ----------
    table : (N, L) float       gain of the first L looks; no row rises
    ratio : (N,) float         what each further look pays of the one before, in [0, 1]

    Raises
    ------
    InvalidProblemError        if a gain is negative, not finite or rises with the number of looks

    Examples
    --------
    >>> gains = Gains.independent(np.array([0.5, 0.5]), np.array([1.0, 0.5]))
    >>> gains.of(np.array([0, 1, 1, 1]), np.array([1, 0, 1, 2]))
    array([0.    , 0.25  , 0.125 , 0.0625])
    """

    table: NDArray[np.float64]
    ratio: NDArray[np.float64]

    def __post_init__(self) -> None:
        table = np.ascontiguousarray(self.table, np.float64)
        ratio = np.ascontiguousarray(self.ratio, np.float64)
        if table.ndim != 2 or table.shape[1] == 0 or ratio.shape != table.shape[:1]:
            raise InvalidProblemError(
                f"gains of shape {table.shape} with ratios {ratio.shape} came; expected (N, L) and (N,)"
            )
        if not np.isfinite(table).all() or (table < 0).any():
            raise InvalidProblemError("gains came negative or not finite; expected numbers of at least 0")
        if (np.diff(table, axis=1) > 0).any():
            cell, look = np.argwhere(np.diff(table, axis=1) > 0)[0]
            raise InvalidProblemError(
                f"look {look + 2} at cell {cell} pays {table[cell, look + 1]:.6g}, more than the "
                f"{table[cell, look]:.6g} of the look before; a further look may never pay more"
            )
        if not (np.isfinite(ratio).all() and (ratio >= 0).all() and (ratio <= 1).all()):
            raise InvalidProblemError("ratios of further looks came outside [0, 1]")
        object.__setattr__(self, "table", table)
        object.__setattr__(self, "ratio", ratio)

    @classmethod
    def independent(cls, poc: ArrayLike, glimpse: ArrayLike) -> Gains:
        """Detection by independent looks: p g, p g (1 - g), p g (1 - g)^2, ...   [Lin2014, eq. (7)]."""
        p, g = np.ravel(poc).astype(np.float64), np.ravel(glimpse).astype(np.float64)
        return cls((p * g)[:, None], 1.0 - g)

    @property
    def n_cells(self) -> int:
        """Number of cells N."""
        return int(self.table.shape[0])

    @property
    def first(self) -> NDArray[np.float64]:
        """(N,) float: what the first look pays."""
        return self.table[:, 0]

    def of(self, cells: NDArray[np.integer], looks: NDArray[np.integer]) -> NDArray[np.float64]:
        """Gain of look number `looks` (0 is the first) at `cells`; any shapes that broadcast."""
        last = self.table.shape[1] - 1
        beyond = np.maximum(looks - last, 0)
        gain: NDArray[np.float64] = self.table[cells, np.minimum(looks, last)] * self.ratio[cells] ** beyond
        return gain

    def total(self, cells: NDArray[np.integer], looks: NDArray[np.float64]) -> NDArray[np.float64]:
        """What so many looks at `cells` pay in all; looks may be parts of one, as effort is.

        Up to the table's last column the total is a straight line between whole looks, from there on the geometric
        tail's own curve; where the table has one column, as that of effort, it rises ever more slowly.

        Parameters
        ----------
        cells, looks : (n,)         any shapes that broadcast

        Examples
        --------
        >>> gains = Gains.independent(np.array([1.0]), np.array([0.75]))
        >>> gains.total(np.array([0, 0, 0]), np.array([0.5, 1.0, 2.0]))
        array([0.5   , 0.75  , 0.9375])
        """
        columns = self.table.shape[1] - 1
        before = np.concatenate([np.zeros((self.n_cells, 1)), np.cumsum(self.table[:, :columns], axis=1)], axis=1)
        whole = np.minimum(np.floor(looks), columns).astype(np.int64)
        paid, ratio = before[cells, whole], self.ratio[cells]
        more = np.asarray(looks) - whole
        with np.errstate(divide="ignore", invalid="ignore"):
            tail = np.where(ratio < 1.0, (1.0 - ratio**more) / (1.0 - ratio), more)
        within = np.where(whole < columns, more, tail)
        return np.asarray(paid + self.table[cells, whole] * within)

    def after(self, looked: NDArray[np.integer]) -> Gains:
        """The gains that remain once cell i has had `looked[i]` looks, (N,) int."""
        cells = np.arange(self.n_cells)
        columns = np.arange(self.table.shape[1])
        return Gains(self.of(cells[:, None], looked[:, None] + columns), self.ratio)


def effort_gains(poc: ArrayLike) -> Gains:
    """Gains of detection by effort: a look is a unit of effort, and e units detect with POD 1 - exp(-e).

    What one cell pays for all effort is its POC; how much effort a leg puts on it, `sensors.Swath` says.

    >>> effort_gains([0.5]).total(np.array([0]), np.array([2.0])).round(6)
    array([0.432332])
    """
    p = np.ravel(poc).astype(np.float64)
    return Gains((p * -np.expm1(-1.0))[:, None], np.full(len(p), np.exp(-1.0)))


def detection_gains(
    belief: Belief, glimpse: ArrayLike, correlation: float = 0.0, *, looks: int = CORRELATED_LOOKS
) -> Gains:
    """Gains of detection: POC times the share of detections that each further look adds.

    gain(i, k) = p_i (M_k - M_(k+1)), with M the probability that k looks all miss (`sensors.miss_after_looks`)

    Parameters
    ----------
    belief : Belief            where the person may be, (H, W)
    glimpse : (H, W) or float  P(detect in one look | there), in [0, 1]
    correlation : float        of two looks at one place: 0 is the paper's independence
    looks : int                columns of the table where looks correlate; later looks are worth as the geometric
                               tail through its last two columns, which is less than the true tail

    Raises
    ------
    InvalidProblemError        if shapes differ or a glimpse lies outside [0, 1]

    Examples
    --------
    >>> belief = Belief.from_weights([[1.0, 1.0]])
    >>> detection_gains(belief, 0.5).of(np.array([0, 0]), np.array([0, 1]))
    array([0.25 , 0.125])
    """
    g = np.asarray(glimpse, np.float64)
    if g.ndim and g.shape != belief.shape:
        raise InvalidProblemError(f"glimpse of shape {g.shape} came; the map has {belief.shape}")
    if not (np.isfinite(g).all() and (g >= 0).all() and (g <= 1).all()):
        raise InvalidProblemError("glimpse probabilities came outside [0, 1]")
    g = np.ravel(np.broadcast_to(g, belief.shape))
    if correlation == 0.0:
        return Gains.independent(belief.poc, g)
    if looks < 2:
        raise InvalidProblemError(f"a table of {looks} looks came; correlated looks need at least 2")
    shares = -np.diff(miss_after_looks(g, looks, correlation), axis=1)  # (N, looks)
    shares = np.minimum.accumulate(np.maximum(shares, 0.0), axis=1)  # rounding must not make a later look pay more
    before, last = shares[:, -2], shares[:, -1]
    ratio = np.divide(last, before, out=np.zeros_like(last), where=before > 0)
    return Gains(belief.poc.ravel()[:, None] * shares, ratio)
