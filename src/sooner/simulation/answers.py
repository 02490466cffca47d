"""What is known before a flight over cells or regions, how looks answer, and what their answers teach."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.random import Generator
from numpy.typing import NDArray

from sooner.belief import Belief, BetaGrid, EvidenceGrid
from sooner.belief.evidence import binary_entropy, log_odds_from_counts, theta_from_counts
from sooner.errors import ImpossibleObservationError, InvalidProblemError
from sooner.sensors import miss_after_looks

__all__ = ["AnswerModel", "Known"]

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]
Known = Belief | EvidenceGrid | BetaGrid

MOST_SURE = np.nextafter(1.0, 0.0)  # that a person is not on the map: a belief leaves some chance


@dataclass(frozen=True, eq=False)
class AnswerModel:
    """Who may be where, and how likely a look says yes; N cells.

    A yes is an alarm: it says that somebody may be there, and the flight goes on whatever it says. Who is there counts
    as found by the first yes at his own cell; that others are false is found out by those who go and see.

    Parameters
    ----------
    known : Belief             where the one person may be; or EvidenceGrid or BetaGrid, of each cell by itself
    detect : float or (N,)     P(a look says yes | somebody is there)
    false_alarm : float        P(a look says yes | nobody is there)
    correlation : float        of two looks at one place; only where a person is sought without false alarms

    Raises
    ------
    InvalidProblemError        if probabilities are none, or looks correlate where that means nothing

    Examples
    --------
    >>> model = AnswerModel(Belief.from_weights([[1.0, 1.0, 2.0]]), detect=0.8, false_alarm=0.2)
    >>> looks, yes = np.array([1, 1, 0]), np.array([0, 1, 0])
    >>> model.after(looks, yes).poc.round(3)  # odds of a cell times 0.2 / 0.8 by its no, times 0.8 / 0.2 by its yes
    array([[0.04, 0.64, 0.32]])
    """

    known: Known
    detect: float | Floats = 1.0
    false_alarm: float = 0.0
    correlation: float = 0.0

    def __post_init__(self) -> None:
        detect = np.asarray(self.detect, np.float64)
        if detect.ndim and detect.shape != (self.n_cells,):
            raise InvalidProblemError(f"detect of shape {detect.shape} came; the map has {self.n_cells} cells")
        if not ((detect >= 0) & (detect <= 1)).all() or not 0.0 <= self.false_alarm <= 1.0:
            raise InvalidProblemError("probabilities of a yes came outside [0, 1]")
        if not 0.0 <= self.correlation <= 1.0:
            raise InvalidProblemError(f"correlation {self.correlation} came; expected a number in [0, 1]")
        if self.correlation and (not isinstance(self.known, Belief) or self.false_alarm):
            raise InvalidProblemError(
                f"correlation {self.correlation} came; expected 0, or one person and no false alarms"
            )
        if isinstance(self.known, BetaGrid) and (self.false_alarm or (detect != 1).any()):
            raise InvalidProblemError("a sensor that errs came beside rates; how often it says yes is what is learnt")

    @property
    def n_cells(self) -> int:
        """Number of cells N."""
        return int(np.prod(self.known.shape))

    @property
    def theta(self) -> Floats:
        """(N,) float: P(somebody is in each cell), or P(a look would say yes) where targets come and go."""
        return theta_of(self.known)

    @cached_property
    def detects(self) -> Floats:
        """(N,) float: P(a look says yes | somebody is there)."""
        return np.array(np.broadcast_to(self.detect, (self.n_cells,)), np.float64)

    def person(self, rng: Generator) -> int:
        """The cell of the one person, drawn; N where he is not on the map."""
        return int(np.searchsorted(self._ends, rng.random(), side="right"))

    @cached_property
    def _ends(self) -> Floats:
        return np.cumsum(self.theta)

    def truth(self, rng: Generator) -> Floats:
        """(N,) float, drawn: 1 where somebody is, 0 where nobody; where targets come and go, P(one is in view)."""
        if isinstance(self.known, BetaGrid):
            return rng.beta(self.known.alpha.ravel(), self.known.beta.ravel())
        if isinstance(self.known, EvidenceGrid):
            return (rng.random(self.n_cells) < self.theta).astype(np.float64)
        truth = np.zeros(self.n_cells + 1)
        truth[self.person(rng)] = 1.0
        return truth[:-1]

    def chance(self, cells: Ints, truth: Floats) -> Floats:
        """(n,) float: P(yes) of looks at cells (n,) that hold `truth` (n,), whatever others have answered."""
        return truth * self.detects[cells] + (1.0 - truth) * self.false_alarm

    def first_chance(self, cell: int, looks: int) -> Floats:
        """(looks,) float: P(each of so many looks at the person's cell says yes | all before it have said no)."""
        misses = miss_after_looks(self.detects[[cell]], looks, self.correlation)[0]
        return np.asarray(1.0 - np.divide(misses[1:], misses[:-1], out=np.zeros(looks), where=misses[:-1] > 0))

    def after(self, looks: Ints, hits: Ints) -> Known:
        """What is known after looks (N,) of which `hits` (N,) said yes.

        odds_i' = odds_i (d_i / f)^hits_i ((1 - d_i) / (1 - f))^(looks_i - hits_i)   each cell by itself
        p_i' ~ p_i times the same                                                   of one person; times 1 outside
        (alpha_i + hits_i, beta_i + looks_i - hits_i)                               of rates [Kuhlman2017, section 3]

        Raises
        ------
        ImpossibleObservationError    if that had probability zero
        """
        misses = looks - hits
        if isinstance(self.known, BetaGrid):
            shape = self.known.shape
            return BetaGrid(self.known.alpha + hits.reshape(shape), self.known.beta + misses.reshape(shape))
        if isinstance(self.known, EvidenceGrid):
            theta = theta_from_counts(self.theta, misses, hits, self.detects, self.false_alarm)
            return EvidenceGrid(theta.reshape(self.known.shape))
        return self._person_after(self.known, misses, hits)

    def _person_after(self, belief: Belief, misses: Ints, hits: Ints) -> Belief:
        """One person is in one cell: all cells and the world outside are weighed against one another."""
        seen = np.flatnonzero(misses + hits)
        with np.errstate(divide="ignore", invalid="ignore"):
            logs = np.log(np.append(belief.poc.ravel(), belief.outside))
            logs[seen] += self._log_ratios(seen, misses[seen], hits[seen])
        most = logs.max()
        if not most > -np.inf:  # not a number either: a yes where nobody can be
            raise ImpossibleObservationError("answers came that cannot be, wherever the person is")
        weights = np.where(logs == np.inf, 1.0, 0.0) if most == np.inf else np.exp(logs - most)
        weights /= weights.sum()
        return Belief(weights[:-1].reshape(belief.shape), min(float(weights[-1]), MOST_SURE))

    def _log_ratios(self, cells: Ints, misses: Ints, hits: Ints) -> Floats:
        """(n,) float: log of P(what looks at each cell answered | he is there) / P(the same | he is elsewhere)."""
        if not self.correlation:
            return log_odds_from_counts(0.5, misses, hits, self.detects[cells], self.false_alarm)
        missed = miss_after_looks(self.detects[cells], int(misses.max(initial=0)), self.correlation)
        return np.where(hits > 0, np.inf, np.log(missed[np.arange(len(cells)), misses]))

    def bits(self, known: Known) -> float:
        """How uncertain that is, in bits: of the person's place, or summed over cells, of rates by density."""
        if isinstance(known, Belief):
            shares = np.append(known.poc.ravel(), known.outside)
            shares = shares[shares > 0]
            return float(-(shares * np.log2(shares)).sum())
        if isinstance(known, EvidenceGrid):
            return float(binary_entropy(known.theta).sum())
        return float(rate_entropy(known.alpha, known.beta).sum())

    def narrowed(self, cells: Ints) -> AnswerModel:
        """The same of some cells (n,) alone; of one person the others count as outside."""
        if isinstance(self.known, BetaGrid):
            known: Known = BetaGrid(self.known.alpha.ravel()[None, cells], self.known.beta.ravel()[None, cells])
        elif isinstance(self.known, EvidenceGrid):
            known = EvidenceGrid(self.theta[None, cells])
        else:
            poc = self.theta[None, cells]
            known = Belief(poc, min(max(1.0 - float(poc.sum()), 0.0), MOST_SURE))
        return AnswerModel(known, self.detects[cells], self.false_alarm, self.correlation)


def theta_of(known: Known) -> Floats:
    """(N,) float: P(somebody is in each cell), or P(a look would say yes) where targets come and go."""
    if isinstance(known, BetaGrid):
        return known.mean.ravel()
    return np.minimum(known.poc, 1.0).ravel() if isinstance(known, Belief) else known.theta.ravel()


def rate_entropy(alpha: Floats, beta: Floats) -> Floats:
    """Differential entropy of Beta laws, bits.

    ln B(a, b) - (a - 1) psi(a) - (b - 1) psi(b) + (a + b - 2) psi(a + b), over ln 2
    """
    from scipy.special import betaln, psi

    nats = (
        betaln(alpha, beta) - (alpha - 1.0) * psi(alpha) - (beta - 1.0) * psi(beta)
        + (alpha + beta - 2.0) * psi(alpha + beta)
    )  # fmt: skip
    return np.asarray(nats / np.log(2.0))
