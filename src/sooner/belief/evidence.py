"""Evidence: what looks have said of each cell by itself. Cells are independent; nothing totals one."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import ArrayLike, NDArray

from sooner.errors import ImpossibleObservationError, InvalidProblemError

__all__ = ["BetaGrid", "EvidenceGrid", "binary_entropy", "stationary_theta", "theta_from_counts"]

Floats = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class EvidenceGrid:
    """The probability of a target in each cell, every cell by itself             [Kuhlman2017, section 3, eq. (13)].

    theta = P(X = 1 | all looks so far); 0.5 where nothing is known. Log-odds are kept beside theta, so that cells
    remember how sure they are: beyond 20 hits theta rounds to 1, from which no miss would lead back.

    Parameters
    ----------
    theta : (H, W) float     in [0, 1]; 0 and 1 are certain, and no possible look changes them

    Attributes
    ----------
    log_odds : (H, W) float  log(theta / (1 - theta)), from -inf to inf

    Raises
    ------
    InvalidProblemError      if theta is no map, or a probability lies outside [0, 1]

    Examples
    --------
    >>> evidence = EvidenceGrid.uniform((1, 3)).update([0, 1, 1], [True, True, False], detect=0.85, false_alarm=0.15)
    >>> evidence.theta.round(6)
    array([[0.85, 0.5 , 0.5 ]])
    """

    theta: Floats
    log_odds: Floats = field(init=False, repr=False)

    def __post_init__(self) -> None:
        theta = _checked_map(self.theta, "theta", 0.0, 1.0)
        object.__setattr__(self, "theta", theta)
        object.__setattr__(self, "log_odds", _log_odds(theta))

    @classmethod
    def uniform(cls, shape: tuple[int, int], theta: float = 0.5) -> EvidenceGrid:
        """The same theta everywhere; 0.5, one bit a cell, is the least that can be known."""
        return cls(np.full(shape, theta))

    @classmethod
    def from_log_odds(cls, log_odds: ArrayLike) -> EvidenceGrid:
        """Evidence from log-odds (H, W), which may be infinite but not NaN."""
        values = _checked_map(log_odds, "log_odds", -np.inf, np.inf)
        grid = cls(_from_log_odds(values))
        object.__setattr__(grid, "log_odds", values)
        return grid

    @property
    def shape(self) -> tuple[int, int]:
        """Rows and columns of the map."""
        height, width = self.theta.shape
        return height, width

    @property
    def entropy(self) -> Floats:
        """(H, W) bits: what a perfect look at each cell would teach; precise near theta = 1 as near 0."""
        return _entropy(self.theta, _from_log_odds(-self.log_odds))

    def update(
        self, cells: ArrayLike, hits: ArrayLike, detect: ArrayLike, false_alarm: ArrayLike = 0.0
    ) -> EvidenceGrid:
        """Evidence after looks, in whatever order they came                            [Kuhlman2017, eq. (14)].

        theta' = p_d theta / (p_d theta + p_f (1 - theta))                               after a hit
        theta' = (1 - p_d) theta / ((1 - p_d) theta + (1 - p_f) (1 - theta))             after a miss

        Parameters
        ----------
        cells : (M,) int              cells looked at, row by row as in `Grid.index`; a cell may come more than once
        hits : (M,) bool              what each look said
        detect, false_alarm           p_d and p_f, floats or (M,), in [0, 1]

        Raises
        ------
        ImpossibleObservationError    if a cell's looks had probability zero, as a hit has where theta = 0 and p_f = 0
        InvalidProblemError           if cells and hits do not match or a cell is not on the map

        Notes
        -----
        The equation is applied as log-odds' = log-odds + log(p_d / p_f), or + log((1 - p_d) / (1 - p_f)): the same
        number, with certainty as an infinity and the impossible as the one sum that is undefined, inf - inf.
        """
        where, hit = _checked_looks(cells, hits, self.theta.size)
        on_miss, on_hit = _log_likelihood_ratios(detect, false_alarm)
        log_odds = self.log_odds.flatten()
        with np.errstate(invalid="ignore"):
            np.add.at(log_odds, where, np.where(hit, on_hit, on_miss))
        _refuse_impossible(log_odds)
        return EvidenceGrid.from_log_odds(log_odds.reshape(self.shape))

    def predict(self, appear: ArrayLike, disappear: ArrayLike, steps: int = 1) -> EvidenceGrid:
        """Evidence some steps later, where targets come and go by themselves.

        theta' = (1 - b) theta + a (1 - theta); after n steps with a and b replaced by
        a_n = a (1 - (1 - a - b)^n) / (a + b), b_n = b (1 - (1 - a - b)^n) / (a + b)

        Every cell is a two-state Markov chain; `stationary_theta` is where it tends. The paper's targets stay,
        a = b = 0; it leaves others open [Kuhlman2017, section 3].

        Parameters
        ----------
        appear, disappear        a = P(1 next | 0 now) and b = P(0 next | 1 now), floats or (H, W), in [0, 1]
        steps : int              n >= 0

        Examples
        --------
        >>> EvidenceGrid.uniform((1, 1), 1.0).predict(0.1, 0.3).theta
        array([[0.7]])
        """
        a, b = probabilities(appear, "appear"), probabilities(disappear, "disappear")
        if steps < 0:
            raise InvalidProblemError(f"{steps} steps came; expected at least 0")
        share = np.divide(1.0 - (1.0 - a - b) ** steps, a + b, out=np.zeros(np.broadcast(a, b).shape), where=a + b > 0)
        come, go = a * share, b * share
        absent = _from_log_odds(-self.log_odds)
        with np.errstate(divide="ignore"):
            present_later = np.log(self.theta * (1.0 - go) + absent * come)
            return EvidenceGrid.from_log_odds(present_later - np.log(self.theta * go + absent * (1.0 - come)))


@dataclass(frozen=True, eq=False)
class BetaGrid:
    """How often a target is in view in each cell, itself unknown                      [Kuhlman2017, section 3].

    X ~ Beta(alpha, beta) and Z ~ Bernoulli(X): targets that come and go from view at random. A look has no error
    of its own; the rate X is what is learnt.

    Parameters
    ----------
    alpha, beta : (H, W) float     above 0: hits and misses so far, on top of those that the prior stands for

    Raises
    ------
    InvalidProblemError            if they are no maps of one shape, or not above 0 and finite

    Examples
    --------
    >>> rate = BetaGrid.uniform((1, 2)).update([1, 1, 1], [True, True, False])
    >>> rate.alpha, rate.mean
    (array([[1., 3.]]), array([[0.5, 0.6]]))
    """

    alpha: Floats
    beta: Floats

    def __post_init__(self) -> None:
        alpha, beta = (
            _checked_map(values, name, np.nextafter(0.0, 1.0), np.finfo(np.float64).max)
            for values, name in ((self.alpha, "alpha"), (self.beta, "beta"))
        )
        if alpha.shape != beta.shape:
            raise InvalidProblemError(f"alpha of shape {alpha.shape} and beta of shape {beta.shape} came")
        object.__setattr__(self, "alpha", alpha)
        object.__setattr__(self, "beta", beta)

    @classmethod
    def uniform(cls, shape: tuple[int, int], alpha: float = 1.0, beta: float = 1.0) -> BetaGrid:
        """The same Beta law everywhere; with (1, 1) every rate is as likely as another."""
        return cls(np.full(shape, alpha), np.full(shape, beta))

    @property
    def shape(self) -> tuple[int, int]:
        """Rows and columns of the map."""
        height, width = self.alpha.shape
        return height, width

    @property
    def mean(self) -> Floats:
        """(H, W): expected rate, which is the probability that the next look hits."""
        return np.asarray(self.alpha / (self.alpha + self.beta))

    def update(self, cells: ArrayLike, hits: ArrayLike) -> BetaGrid:
        """Evidence after looks at `cells` (M,) that said `hits` (M,): each hit adds one to alpha, each miss to beta."""
        where, hit = _checked_looks(cells, hits, self.alpha.size)
        counts = [np.bincount(where[chosen], minlength=self.alpha.size).reshape(self.shape) for chosen in (hit, ~hit)]
        return BetaGrid(self.alpha + counts[0], self.beta + counts[1])


def theta_from_counts(
    prior: ArrayLike, misses: ArrayLike, hits: ArrayLike, detect: ArrayLike, false_alarm: ArrayLike = 0.0
) -> Floats:
    """P(a target is there | so many misses and hits), in closed form.

    log-odds = prior log-odds + nz0 log((1 - p_d) / (1 - p_f)) + nz1 log(p_d / p_f)      [Kuhlman2017, eq. (14)]

    Parameters
    ----------
    prior                      theta before the looks, in [0, 1]
    misses, hits               nz0 and nz1, whole numbers of at least 0
    detect, false_alarm        p_d and p_f, in [0, 1]; all five of any shapes that broadcast

    Raises
    ------
    ImpossibleObservationError if such counts had probability zero

    Examples
    --------
    >>> theta_from_counts(0.5, [2, 1, 0], [0, 1, 2], 0.85, 0.15).round(4)
    array([0.0302, 0.5   , 0.9698])
    """
    log_odds = log_odds_from_counts(prior, misses, hits, detect, false_alarm)
    _refuse_impossible(log_odds)
    return _from_log_odds(log_odds)


def log_odds_from_counts(
    prior: ArrayLike, misses: ArrayLike, hits: ArrayLike, detect: ArrayLike, false_alarm: ArrayLike
) -> Floats:
    """As `theta_from_counts`, in log-odds, and NaN where the counts cannot be."""
    counts = [np.asarray(count) for count in (misses, hits)]
    if any((count < 0).any() for count in counts):
        raise InvalidProblemError("counts of looks came negative; expected at least 0")
    log_odds = _log_odds(probabilities(prior, "prior"))
    with np.errstate(invalid="ignore"):
        for count, ratio in zip(counts, _log_likelihood_ratios(detect, false_alarm), strict=True):
            log_odds = log_odds + np.where(count > 0, count * ratio, 0.0)
    return np.asarray(log_odds)


def stationary_theta(appear: ArrayLike, disappear: ArrayLike) -> Floats:
    """Where `EvidenceGrid.predict` tends when nobody looks: theta = a / (a + b).

    Raises
    ------
    InvalidProblemError        where nothing ever changes (a = b = 0): the start is never forgotten

    Examples
    --------
    >>> stationary_theta(0.1, 0.3)
    array(0.25)
    """
    a, b = probabilities(appear, "appear"), probabilities(disappear, "disappear")
    if (a + b == 0).any():
        raise InvalidProblemError("appear = disappear = 0 came: such a cell never changes and has no limit")
    return np.asarray(a / (a + b))


def binary_entropy(theta: ArrayLike) -> Floats:
    """Entropy of a yes or no in bits, -theta log2 theta - (1 - theta) log2(1 - theta).

    >>> binary_entropy([0.0, 0.5, 1.0])
    array([0., 1., 0.])
    """
    values = np.asarray(theta, np.float64)
    return _entropy(values, 1.0 - values)


def _entropy(present: Floats, absent: Floats) -> Floats:
    """As `binary_entropy`, of both probabilities, so that the smaller is not lost beside one."""
    nats = np.zeros(np.shape(present))
    for p, other in ((present, absent), (absent, present)):
        with np.errstate(divide="ignore", invalid="ignore"):
            log = np.where(p > 0.5, np.log1p(-other), np.log(p))
            nats -= np.where(p > 0, p * log, 0.0)
    return np.asarray(nats / np.log(2.0))


def _log_odds(theta: Floats) -> Floats:
    with np.errstate(divide="ignore"):
        return np.asarray(np.log(theta) - np.log1p(-theta))


def _from_log_odds(log_odds: Floats) -> Floats:
    return np.asarray(np.exp(-np.logaddexp(0.0, -log_odds)))


def _log_likelihood_ratios(detect: ArrayLike, false_alarm: ArrayLike) -> tuple[Floats, Floats]:
    """What a miss and what a hit add to log-odds; NaN where the look could not say so at all."""
    d, f = probabilities(detect, "detect"), probabilities(false_alarm, "false_alarm")
    with np.errstate(divide="ignore", invalid="ignore"):
        return np.log1p(-d) - np.log1p(-f), np.log(d) - np.log(f)


def _refuse_impossible(log_odds: Floats) -> None:
    impossible = np.flatnonzero(np.isnan(log_odds))
    if len(impossible):
        raise ImpossibleObservationError(
            f"looks came that cannot be, at {len(impossible)} cells, the first at cell {impossible[0]}: what they say "
            "has probability zero with and without a target (a hit without false alarms where none can be, or a miss "
            "of a sensor that never misses where one must be)"
        )


def _checked_map(values: ArrayLike, name: str, low: float, high: float) -> Floats:
    checked = np.ascontiguousarray(values, np.float64)
    if checked.ndim != 2 or checked.size == 0:
        raise InvalidProblemError(f"{name} of shape {checked.shape} came; expected rows and columns (H, W)")
    wrong = ~((checked >= low) & (checked <= high))
    if wrong.any():
        row, col = np.argwhere(wrong)[0]
        raise InvalidProblemError(
            f"{name} is {checked[row, col]} at [{row}, {col}], and wrong in {int(wrong.sum())} cells; "
            f"expected numbers from {low:g} to {high:g}"
        )
    return checked


def probabilities(values: ArrayLike, name: str) -> Floats:
    """The values as an array, all in [0, 1]."""
    checked = np.asarray(values, np.float64)
    if not ((checked >= 0) & (checked <= 1)).all():
        raise InvalidProblemError(f"{name} came outside [0, 1]; expected probabilities")
    return checked


def _checked_looks(cells: ArrayLike, hits: ArrayLike, n_cells: int) -> tuple[NDArray[np.intp], NDArray[np.bool_]]:
    where, hit = np.asarray(cells), np.asarray(hits, bool)
    if where.size == 0:
        where = where.astype(np.intp)
    if where.ndim != 1 or where.shape != hit.shape or where.dtype.kind not in "iu":
        raise InvalidProblemError(
            f"looks at cells of shape {where.shape} and type {where.dtype} with hits of shape {hit.shape} came; "
            "expected cell numbers (M,) and as many hits (M,)"
        )
    if len(where) and not 0 <= where.min() <= where.max() < n_cells:
        raise InvalidProblemError(f"a look at cell {where.max()} or {where.min()} came; the map has {n_cells} cells")
    return where.astype(np.intp), hit
