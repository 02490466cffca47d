"""What a team makes of its looks: one belief in one place, about cells and about the target."""

from __future__ import annotations

from collections.abc import Iterator
from copy import copy
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from sooner.belief.cell_states import CellStates
from sooner.belief.street_kriging import StreetKriging
from sooner.belief.track_before_detect import Track, TrackBeforeDetect
from sooner.belief.tracks import Tracks
from sooner.errors import InvalidProblemError
from sooner.simulation.sensing import LookLog
from sooner.simulation.world import World

__all__ = ["Detector", "Estimator", "Prior", "TeamBelief", "Tracking"]

Detector = Literal["cbht", "lrdt"]
Tracking = Literal["one", "restarted", "each"]
Prior = Literal["uniform", "kriged", "known"]


@dataclass(frozen=True)
class Estimator:
    """How a team estimates the map and the target   [Wolek2020, sections II.D and III].

    Parameters
    ----------
    detector : str       "cbht" tests each cell by itself; "lrdt" tracks a target along the streets before it is
                         detected, by likelihood ratios
    prior : str          of nodes in cells that nobody has seen: "uniform", "kriged" from those seen, or a "known" map
    void : float         prior probability that a cell holds no node
    absent : float       probability that there is no target
    odds : float         at which a node, or a target, is detected; 19 is a confidence of 95 %
    decay : float        alpha in (0, 1]: how fast an unseen target's likelihood ratio returns to its prior
    tracks : str         what becomes of the tracker when it has called. "one": it goes on as it is, and nobody else is
                         sought, as where there is one target. How many there are is not known in the others, and the
                         search goes on to the end. "each": what it has found is followed by a track of its own, which
                         explains what is seen of it, and the tracker searches for another; see `Tracks`. "restarted":
                         it begins again from its prior, and will soon call what is still in view

    Raises
    ------
    InvalidProblemError  if a name or number is none of these, cells are tested though the map is known (on a known map
                         they are settled from the start), or tracks are asked for where cells are tested
    """

    detector: Detector = "lrdt"
    prior: Prior = "uniform"
    void: float = 0.9
    absent: float = 0.5
    odds: float = 19.0
    decay: float = 0.1
    tracks: Tracking = "one"

    def __post_init__(self) -> None:
        if self.detector not in ("cbht", "lrdt"):
            raise InvalidProblemError(f"detector {self.detector!r} came; expected 'cbht' or 'lrdt'")
        if self.prior not in ("uniform", "kriged", "known"):
            raise InvalidProblemError(f"prior {self.prior!r} came; expected 'uniform', 'kriged' or 'known'")
        if self.tracks not in ("one", "restarted", "each"):
            raise InvalidProblemError(f"tracks {self.tracks!r} came; expected 'one', 'restarted' or 'each'")
        if self.tracks != "one" and self.detector == "cbht":
            raise InvalidProblemError(
                f"tracks = {self.tracks!r} and the cell-wise test came; it tracks nobody: expected 'one', or 'lrdt'"
            )
        if self.prior == "known" and self.detector == "cbht":
            raise InvalidProblemError("the cell-wise test on a known map came; it tests only cells with no node yet")
        if not (0.0 < self.void < 1.0 and 0.0 < self.absent < 1.0):
            raise InvalidProblemError(
                f"void = {self.void} and absent = {self.absent} came; expected probabilities between 0 and 1"
            )
        if not (np.isfinite(self.odds) and self.odds > 0.0):
            raise InvalidProblemError(f"odds of {self.odds} came; expected a positive number")
        if not 0.0 < self.decay <= 1.0:
            raise InvalidProblemError(f"a decay of {self.decay} came; expected a number in (0, 1]")

    def begun(self, world: World, most_looks: int) -> TeamBelief:
        """The belief of a search in which nothing has been seen.

        world : World         of which only what the estimator may know is used: how targets walk, the streets between
                              detected nodes, and all of the map where it is known
        most_looks : int      that may come in one second
        """
        return TeamBelief(self, world, most_looks)


class TeamBelief:
    """The belief of one search, changed in place by every second's looks.

    states : CellStates            of all cells
    node_seconds : (M,) int64      when each cell's node was detected, -1 not yet; 0 on a known map
    track : Track or None          of the target that is sought, if the detector tracks
    tracks : Tracks or None        that one and those of targets found, if each has its own
    newest_ratios : (k,) float     what the newest looks say of the target that is sought
    """

    def __init__(self, estimator: Estimator, world: World, most_looks: int) -> None:
        n_cells = world.graph.grid.n_cells
        self.estimator = estimator
        if estimator.prior == "known":
            self.states = CellStates.known_map(world.nodes, estimator.absent)
        else:
            self.states = CellStates.unknown(n_cells, estimator.void, estimator.absent)
        self.node_seconds = np.where(self.states.nodes, 0, -1).astype(np.int64)
        self._world = world
        self._kriging = StreetKriging().session(world.graph.grid) if estimator.prior == "kriged" else None
        self.track = _begun(estimator, world) if estimator.detector == "lrdt" else None
        self.tracks = Tracks(self.track) if self.track is not None and estimator.tracks == "each" else None
        self._found = np.empty(most_looks, np.int64)
        self._ratios = np.zeros(n_cells)
        self.newest_ratios = np.empty(0)
        self._above, self._called = False, 0

    @property
    def has_called(self) -> bool:
        """Whether the detector has called."""
        return self._called > 0

    @property
    def sought(self) -> bool:
        """Whether a target is still sought."""
        return self._called == 0 or self.estimator.tracks != "one"

    @property
    def followed(self) -> dict[int, int]:
        """The cell where each target that was found is likeliest, while it is followed; by the number of its call."""
        return {} if self.tracks is None else self.tracks.places

    def see(self, second: int, log: LookLog) -> tuple[float, tuple[int, ...]]:
        """Take in this second's looks: Bayes' law in each cell, nodes detected, the target tracked.

        Returns
        -------
        (float, tuple of int)      what the detector holds against its threshold, and cells where it calls: a tracker
                                   when it crosses the threshold from below, a test of cells at each that passes
        """
        total, cell = self._detect(second, log)
        above = total >= self.estimator.odds
        calls = above and (not self._above or self.track is None)
        self._above, self._called = above, self._called + calls
        if calls and self.track is not None and self.estimator.tracks != "one":
            self._search_on(self.track, cell)
        return total, (cell,) if calls else ()

    def _search_on(self, track: Track, cell: int) -> None:
        """One target is found; the tracker searches for another."""
        if self.tracks is None:
            track.restart()
        else:
            self.tracks.confirm(cell)
        self._ratios[:], self._above = track.node_ratios, False

    def _detect(self, second: int, log: LookLog) -> tuple[float, int]:
        """What the detector holds against its threshold, and the cell where a target is likeliest."""
        from sooner.simulation._assimilation_kernels import take_in

        states, track = self.states, self.track
        new, cell, odds = take_in(
            second, log.cells, log.map_ratios, log.target_ratios, log.start, log.end, states.void, states.unoccupied,
            states.occupied, states.explored, states.nodes, self.estimator.odds, self._found, self.node_seconds,
        )  # fmt: skip
        self.newest_ratios = log.newest_target_ratios
        if track is None:
            return odds, cell
        if self.tracks is None:
            return track.second(self._found[:new], log.newest_cells, log.newest_target_ratios, self._ratios)
        told = self.tracks.second(self._found[:new], log.newest_cells, log.newest_target_ratios, self._ratios)
        self.newest_ratios = self.tracks.left
        return told

    def predict(self) -> None:
        """Before a replan: what was seen says where nodes are likely that nobody has seen, if the prior is kriged."""
        self.settle()
        if self._kriging is None:
            return
        from sooner.belief._cell_state_kernels import expect_void

        states, world = self.states, self._world
        angles = world.edge_angles[states.nodes[world.edge_cells].all(axis=1)]
        void = self._kriging.expected_void(states.void, states.explored, angles)
        expect_void(states.void, states.unoccupied, states.occupied, states.explored, void, self.estimator.absent)

    def settle(self) -> None:
        """Cells of nodes are told by the tracker; nothing else changes."""
        from sooner.belief._cell_state_kernels import set_nodes

        if self.track is not None:
            states, cells = self.states, np.flatnonzero(self.states.nodes)
            set_nodes(states.void, states.unoccupied, states.occupied, cells, self._ratios[cells])

    def copy(self) -> TeamBelief:
        """The same belief, to come back to with `restore`."""
        other = copy(self)
        other.states, other.node_seconds, other._ratios = (
            self.states.copy(), self.node_seconds.copy(), self._ratios.copy(),
        )  # fmt: skip
        other.track = None if self.track is None else self.track.copy()
        other.tracks = None if self.tracks is None or other.track is None else self.tracks.copy(other.track)
        other._kriging = None if self._kriging is None else self._kriging.copy()
        return other

    def restore(self, kept: TeamBelief) -> None:
        """Be again as a copy was, in the arrays that are here."""
        for own, other in zip(self._arrays(), kept._arrays(), strict=True):
            np.copyto(own, other)
        if self._kriging is not None and kept._kriging is not None:
            self._kriging.restore(kept._kriging)
        if self.tracks is not None and kept.tracks is not None:
            self.tracks.restore(kept.tracks)
        self._above, self._called = kept._above, kept._called

    def _arrays(self) -> Iterator[NDArray[Any]]:
        states, track = self.states, self.track
        yield from (states.void, states.unoccupied, states.occupied, states.explored, states.nodes)
        yield from (self.node_seconds, self._ratios)
        if track is not None:
            yield from (track.probability, track.explored, track.found, track.confined)


def _begun(estimator: Estimator, world: World) -> Track:
    track = TrackBeforeDetect(estimator.absent, estimator.decay).begun(world.cell_states, world.cell_weights)
    if estimator.prior == "known":
        track.explore(world.graph.cells)
    return track
