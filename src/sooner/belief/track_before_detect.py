"""Likelihood ratio detection and tracking: where a target on streets is, and whether there is one at all."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from math import log
from typing import Protocol

import numpy as np
from numpy.typing import ArrayLike, NDArray

from sooner.belief import _track_kernels as kernels
from sooner.errors import InvalidProblemError
from sooner.streets import TargetStates

__all__ = ["Track", "TrackBeforeDetect", "TrackSettings", "start_ratio"]


class TrackSettings(Protocol):
    """How a target comes and goes, as far as a track is told."""

    @property
    def vanish(self) -> float:
        """q(phi | s), a second."""

    @property
    def appear(self) -> float:
        """The sum over states of q(s | phi), a second."""

    def start_ratio(self, n_cells: int) -> float:
        """Likelihood ratio at which a newly explored state begins."""


@dataclass(frozen=True)
class TrackBeforeDetect:
    """The parameters of a track, and how one begins   [Wolek2020, sec. III.B].

    Parameters
    ----------
    absent : float           p_phi in (0, 1), the probability that there is no target, to which an unseen search returns
    decay : float            alpha in [0, 1], how fast: by a factor 1 - alpha a second
    start : float or None    likelihood ratio at which a newly explored state begins; None for `start_ratio`

    Raises
    ------
    InvalidProblemError      if a parameter is out of its range

    Notes
    -----
    As printed, q(s | phi) = alpha (1 - p_phi) passes one where there are more than 1 / (alpha (1 - p_phi)) states; we
    divide it by the number of explored states, which keeps the equilibrium that the paper names.

    Examples
    --------
    >>> from sooner.grid import Grid
    >>> from sooner.streets import OccupancyGraph, TargetWalk
    >>> states = TargetStates(OccupancyGraph.of(Grid((1, 3)), [0, 1, 2], [(0, 1), (1, 2)]))
    >>> track = TrackBeforeDetect().begun(states, TargetWalk().weights(states))
    >>> track.explore([0, 1, 2])
    >>> for _ in range(10):
    ...     track.move()
    ...     track.see(cells=[0, 1], ratios=[0.2, 20.0])
    >>> track.likeliest, track.integrated_ratio > 19
    (1, True)
    """

    absent: float = 0.5
    decay: float = 0.1
    start: float | None = None

    def __post_init__(self) -> None:
        if not 0.0 < self.absent < 1.0:
            raise InvalidProblemError(f"a probability that there is no target of {self.absent} came; expected (0, 1)")
        if not 0.0 <= self.decay <= 1.0:
            raise InvalidProblemError(f"a rate of decay of {self.decay} came; expected a number in [0, 1]")
        if self.start is not None and not (np.isfinite(self.start) and self.start > 0.0):
            raise InvalidProblemError(f"a ratio to begin at of {self.start} came; expected a positive number")

    @property
    def vanish(self) -> float:
        """q(phi | s) = alpha p_phi."""
        return self.decay * self.absent

    @property
    def appear(self) -> float:
        """The sum over states of q(s | phi) = alpha (1 - p_phi)."""
        return self.decay * (1.0 - self.absent)

    def start_ratio(self, n_cells: int) -> float:
        """Likelihood ratio at which a newly explored state begins."""
        return start_ratio(self.absent, n_cells) if self.start is None else self.start

    def begun(self, states: TargetStates, weights: NDArray[np.float64]) -> Track:
        """A track that has explored nothing, of a target that walks by those transition probabilities."""
        weights = np.ascontiguousarray(weights, np.float64)
        if weights.shape != (states.n_transitions,):
            raise InvalidProblemError(f"{weights.shape} weights came; there are {states.n_transitions} transitions")
        probability = np.zeros(states.n_states + 1)
        probability[-1] = 1.0
        explored, found = np.zeros(states.n_states, bool), np.zeros(states.n_nodes + 1, np.int64)
        return Track(self, states, weights, probability, explored, found, np.zeros_like(weights))


def start_ratio(absent: float, n_cells: int) -> float:
    """Likelihood ratio at which a newly explored state begins: prior odds over a guess at the number of states.

    ((1 - p_phi) / p_phi) / (0.1 M^2 + M), M cells

    >>> start_ratio(0.5, 1600)
    3.881987577639752e-06
    """
    return (1.0 - absent) / absent / (0.1 * n_cells**2 + n_cells)


@dataclass(frozen=True, eq=False)
class Track:
    """What has been learnt of one target; its arrays change in place.

    A second is: `explore` what was detected, `move`, `see` what was measured. `second` does all three at once.

    Parameters
    ----------
    settings : TrackSettings            of the target's coming and going
    states : TargetStates               of the whole graph; what is not explored holds no probability
    weights : (transitions,) float      q_walk, as `TargetWalk.weights` gives it
    probability : (S + 1,) float        p(s), then p(phi); totals one
    explored : (S,) bool                states both of whose nodes are detected
    found : (N + 1,) int64              how many nodes are detected, and then they, in the order of their detection
    confined : (transitions,) float     q_walk confined to explored states, 0 elsewhere
    """

    settings: TrackSettings
    states: TargetStates
    weights: NDArray[np.float64]
    probability: NDArray[np.float64]
    explored: NDArray[np.bool_]
    found: NDArray[np.int64]
    confined: NDArray[np.float64]

    @cached_property
    def start_ratio(self) -> float:
        """Likelihood ratio at which a newly explored state begins."""
        return self.settings.start_ratio(self.states.graph.grid.n_cells)

    @cached_property
    def _scratch(self) -> NDArray[np.float64]:
        return np.empty(self.states.n_states)

    @property
    def detected(self) -> NDArray[np.bool_]:
        """(N,) bool: nodes of the explored graph."""
        return self.explored[: self.states.n_nodes]

    def copy(self) -> Track:
        """The same track, to go on by itself."""
        arrays = self.probability.copy(), self.explored.copy(), self.found.copy(), self.confined.copy()
        return Track(self.settings, self.states, self.weights, *arrays)

    @property
    def resting(self) -> float:
        """Probability of each explored state where nothing has been seen for long: its share of the prior odds.

        ((1 - p_phi) / p_phi) p(phi) / |S|, with p_phi the prior that vanishing and appearing keep up
        """
        vanish, appear = self.settings.vanish, self.settings.appear
        odds = appear / vanish if vanish > 0.0 else 1.0
        return odds * float(self.probability[-1]) / max(int(self.explored.sum()), 1)

    def hold(self, probability: ArrayLike) -> None:
        """Believe (S,) float of the states, and of no target what is believed now; made to total one."""
        self.probability[:-1] = np.where(self.explored, probability, 0.0)
        kernels.normalise(self.probability, self.explored, self.states.graph.starts, self.found)

    def restart(self) -> None:
        """Believe what is believed where nothing has been seen for long; what is explored stays so."""
        self.probability[-1] = 1.0
        self.hold(np.full(self.states.n_states, self.resting))

    def explore(self, nodes: ArrayLike) -> None:
        """Add newly detected nodes, and with them the states that they open."""
        new = _numbers(nodes, self.states.n_nodes, "node")
        graph, states = self.states.graph, self.states
        kernels.explore(
            *(self.probability, self.explored, self.found, self.confined, graph.starts, graph.neighbours),
            *(states.reverse, states.outgoing_starts, self.weights, new, self.start_ratio),
        )

    def move(self) -> None:
        """One second passes.

        p-(s)   = q(s | phi) p(phi) + sum_s' q(s | s') p(s'),        q(s | s') = (1 - q(phi | s')) q_walk(s | s')
        p-(phi) = q(phi | phi) p(phi) + sum_s' q(phi | s') p(s')     [Wolek2020, eq. (10), (11)]

        over explored states, to which the walk is confined: its moves are made to total one over explored neighbours.
        """
        states, settings = self.states, self.settings
        kernels.move(
            *(self.probability, self.explored, self.found, self.confined, states.graph.starts, states.reverse),
            *(states.outgoing_starts, settings.vanish, settings.appear, self._scratch),
        )

    def see(self, cells: ArrayLike, ratios: ArrayLike) -> None:
        """Looks at cells: Lambda(s) = L(z | s) / L(z | phi) Lambda-(s), whether a target showed or not [eq. (14)].

        cells : (L,) int      a cell may come more than once; cells without an explored node teach nothing here
        ratios : (L,) float   of likelihoods, each at least 0
        """
        graph, told = self.states.graph, np.asarray(ratios, np.float64)
        looked = _numbers(cells, graph.grid.n_cells, "cell").astype(np.int32)
        if told.shape != looked.shape or not (told >= 0.0).all():
            raise InvalidProblemError(f"likelihood ratios {told} came for cells {looked}; expected one >= 0 for each")
        rows = graph.starts, self.states.reverse, graph.node_of_cell
        kernels.see(self.probability, self.explored, self.found, *rows, looked, told, 0, len(looked))

    def second(
        self,
        nodes: NDArray[np.int64],
        cells: NDArray[np.int32],
        target_ratios: NDArray[np.float64],
        ratios: NDArray[np.float64],
    ) -> tuple[float, int]:
        """`explore`, `move`, `see`, and the ratios of detected nodes written to (N,) float.

        Returns the integrated likelihood ratio, and the likeliest node, -1 where none is explored. Nothing is checked:
        this runs a second of every trial.
        """
        graph, states, settings = self.states.graph, self.states, self.settings
        told: tuple[float, int] = kernels.second(
            *(self.probability, self.explored, self.found, self.confined, graph.starts, graph.neighbours),
            *(states.reverse, states.outgoing_starts, self.weights, graph.node_of_cell, nodes, cells, target_ratios),
            *(0, len(cells), self.start_ratio, settings.vanish, settings.appear, self._scratch, ratios),
        )
        return told

    @property
    def integrated_ratio(self) -> float:
        """The sum of Lambda(s) = p(s) / p(phi) over states: how much likelier a target is than none."""
        return float(self.probability[:-1].sum() / self.probability[-1])

    @property
    def node_ratios(self) -> NDArray[np.float64]:
        """(N,) float: Lambda_c, the sum over the states that are at each node; 0 where it is not explored."""
        here = np.bincount(self.states.current, self.probability[:-1], self.states.n_nodes)
        return np.asarray(here / self.probability[-1], np.float64)

    @property
    def likeliest(self) -> int:
        """The explored node where the target most probably is, -1 where none is explored."""
        return int(np.argmax(self.node_ratios)) if self.detected.any() else -1

    @property
    def log_ratios(self) -> NDArray[np.float64]:
        """(S,) float: log Lambda(s), finite for explored states, -inf for others."""
        with np.errstate(divide="ignore"):
            found: NDArray[np.float64] = np.log(self.probability[:-1]) - log(self.probability[-1])
        return found


def _numbers(given: ArrayLike, n: int, name: str) -> NDArray[np.int64]:
    numbers = np.asarray(given, np.int64)
    if numbers.ndim != 1 or (numbers.size and not (numbers.min() >= 0 and numbers.max() < n)):
        raise InvalidProblemError(f"{name}s {numbers} came; expected numbers from 0 to {n - 1}")
    return numbers
