"""The flight test, flown once, with what its figure shows besides the episode: surfaces, tasks and a track."""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
from numpy.random import Generator
from numpy.typing import NDArray

from sooner.belief.track_before_detect import Track
from sooner.experiments.wolek2020.scenes import FLIGHT_TEST, scene
from sooner.grid import Grid
from sooner.simulation import Agent, Episode, Estimator, Keep, simulate
from sooner.simulation.sensing import LookLog
from sooner.simulation.strategies import Information, Routes, Situation
from sooner.simulation.strategies.information import InformationSession

__all__ = ["Replan", "Watched", "flight_test", "track_at"]


@dataclass(frozen=True, eq=False)
class Replan:
    """What the strategy saw and chose at one replan.

    information : (M,) float         bits that a look teaches of each cell
    owner : (M,) int                 the Voronoi cell of each grid cell
    places_m : (A, 2) float          where agents were
    routes : Routes
    """

    second: float
    information: NDArray[np.float64]
    owner: NDArray[np.int64]
    places_m: NDArray[np.float64]
    routes: Routes


@dataclass(frozen=True, eq=False)
class Watched:
    """The information strategy, with a note of every replan."""

    inner: Information
    replans: list[Replan] = field(default_factory=list)

    @property
    def capture(self) -> float:
        """That of the strategy."""
        return self.inner.capture

    def starts(self, grid: Grid, agents: tuple[Agent, ...], drawn: NDArray[np.float64]) -> NDArray[np.float64]:
        """Those of the strategy."""
        return self.inner.starts(grid, agents, drawn)

    def session(self, situation: Situation, rng: Generator) -> WatchedSession:
        """Begin a search."""
        return WatchedSession(self.inner.session(situation, rng), self.replans)


@dataclass(frozen=True, eq=False)
class WatchedSession:
    """A session that is watched."""

    inner: InformationSession
    replans: list[Replan]

    def routes(self, situation: Situation) -> Routes:
        """Those of the strategy, noted."""
        information = self.inner.information(situation).mean(axis=0)
        routes = self.inner.routes(situation)
        apart = ((situation.grid.centres_m[:, None] - self.inner.sites) ** 2).sum(axis=2)
        copies = tuple(route.copy() for route in routes)
        places = situation.places_m.copy()
        self.replans.append(Replan(situation.now_s, information, apart.argmin(axis=1), places, copies))
        return routes


def flight_test(seed: int) -> tuple[Episode, list[Replan]]:
    """One flight over the three blocks, with all of its looks, and beliefs at every second."""
    watched = Watched(Information())
    where = scene(Path(), {"map": FLIGHT_TEST}, Estimator(prior="kriged"))
    return simulate(where, watched, seed, Keep(looks=True, beliefs_s=1)), watched.replans


def track_at(episode: Episode, second: int) -> Track:
    """The track of the target after the looks of a second, made again from the looks that were kept."""
    where, looks = episode.scene, episode.looks
    if looks is None:
        raise ValueError("an episode without its looks came; expected one that kept them")
    belief = where.estimator.begun(where.world, where.sensing.most_looks)
    agents = looks.agents.astype(np.int64)
    log = LookLog(0)
    log.cells = looks.cells
    log.map_ratios = where.sensing.ratios[agents, 0, looks.map_levels]
    log.target_ratios = where.sensing.ratios[agents, 1, looks.target_levels]
    for now in range(second + 1):
        log.start, log.end = int(looks.firsts[now]), int(looks.firsts[now + 1])
        belief.see(now, log)
        if now % where.replan_s == 0:
            belief.predict()
    if belief.track is None:
        raise ValueError("an episode without a tracker came; expected the detector 'lrdt'")
    return belief.track
