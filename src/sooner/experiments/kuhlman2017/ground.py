"""The paper's environments as search problems: 20 of each kind, with four starts each."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from functools import lru_cache
from math import sqrt
from typing import Any

import numpy as np
from numpy.typing import NDArray

from sooner.belief import BetaGrid, EvidenceGrid
from sooner.decomposition import Regions, boustrophedon
from sooner.errors import InvalidProblemError
from sooner.problem import Gains, Searcher, SearchProblem
from sooner.problem.information_gains import information_gains
from sooner.problem.region_problem import PRESET_A, PRESET_B, region_problem, two_searches_s
from sooner.problem.regions import RegionGraph, RegionMoves
from sooner.scenarios.natural import NaturalEnvironment, experiment_2, natural_environments
from sooner.sensors import BinarySensor

__all__ = ["DETECT", "FALSE_ALARM", "STARTS", "Ground", "Posed", "environment", "ground", "posed"]

DETECT, FALSE_ALARM = 0.85, 0.15  # sec. 6.3
STARTS = 4  # of each environment, sec. 6.1
STARTS_SEED = 2017
PRESETS = {"A": PRESET_A, "B": PRESET_B}
THETA_UNKNOWN = 0.5
HITS = 2.0  # and no miss, where entropy is low
LONG_S = 1e9  # a budget until the paper's is known
KEPT = 64  # grounds a process remembers: trials come by seed, so that each is made once


@dataclass(frozen=True, eq=False)
class Ground:
    """An environment cut into regions, ready to be searched from any of its starts.

    Parameters
    ----------
    environment : NaturalEnvironment
    regions : Regions
    problems : of SearchProblem     one for each start
    budget_s : float                T_max, twice the time that a search of every region takes [Kuhlman2017, sec. 7.2]
    model : str                     of the sensor: "binary" or "beta"
    """

    environment: NaturalEnvironment
    regions: Regions
    problems: tuple[SearchProblem, ...]
    budget_s: float
    model: str = "binary"

    @property
    def graph(self) -> RegionGraph:
        """What can be flown."""
        moves = self.problems[0].searcher.moves
        assert isinstance(moves, RegionMoves)
        return moves.graph


@dataclass(frozen=True, eq=False)
class Posed:
    """One trial's search: a ground and one of its starts."""

    ground: Ground
    problem: SearchProblem

    def looks(self, actions: NDArray[np.int64]) -> NDArray[np.int64]:
        """(N,) int: how often a plan looks at each cell."""
        moves = self.problem.searcher.moves
        assert isinstance(moves, RegionMoves)
        return moves.cell_looks(self.problem.grid, actions)

    @property
    def theta(self) -> NDArray[np.float64]:
        """(N,) float: of every cell, before the flight."""
        return self.ground.environment.theta.ravel()

    @property
    def free(self) -> NDArray[np.bool_]:
        """(N,) bool: cells without an obstacle."""
        return self.problem.grid.passable


def posed(instance: Mapping[str, Any], seed: int) -> Posed:
    """The search of a trial: seed = 4 * (environment - 1) + start.

    Parameters
    ----------
    instance : mapping    `kind`, and if need be `nonuniform`, `preset` ("A" or "B"), `n_cells` (of Experiment 2),
                          `wide` (cells of which any part may be in reach, instead of those whose centre is),
                          `model` ("binary", or "beta": targets come and go, sec. 3)
    """
    number, start = divmod(seed, STARTS)
    found = ground(
        str(instance["kind"]),
        number + 1,
        bool(instance.get("nonuniform", False)),
        str(instance.get("preset", "A")),
        int(instance.get("n_cells", 0)),
        bool(instance.get("wide", False)),
        str(instance.get("model", "binary")),
    )
    return Posed(found, found.problems[start])


def ground(
    kind: str,
    number: int,
    nonuniform: bool = False,
    preset: str = "A",
    n_cells: int = 0,
    wide: bool = False,
    model: str = "binary",
) -> Ground:
    """The `number`-th environment of a kind, decomposed and timed; the same object for the same question.

    Starts are the centres of four regions, drawn without replacement where there are so many.
    """
    return _ground(kind, number, nonuniform, preset, n_cells, wide, model)


@lru_cache(maxsize=KEPT)
def _ground(kind: str, number: int, nonuniform: bool, preset: str, n_cells: int, wide: bool, model: str) -> Ground:
    place = environment(kind, number, nonuniform, n_cells)
    regions = boustrophedon(place.grid)
    rng = np.random.default_rng((STARTS_SEED, place.seed))
    drawn = rng.choice(regions.n_regions, STARTS, replace=regions.n_regions < STARTS)
    cells = [place.grid.cell(int(cell)) for cell in regions.centres[drawn]]
    gains = _gains(place, model)
    sweep = PRESETS[preset]
    if wide:
        sweep = replace(sweep, radius_m=sweep.radius_m + place.grid.cell_m / sqrt(2.0))
    whole = region_problem(place.grid, regions, sweep, gains, cells, LONG_S)
    budget_s = two_searches_s(whole)
    problems = tuple(_alone(whole, searcher, budget_s) for searcher in whole.searchers)
    return Ground(place, regions, problems, budget_s, model)


def _gains(place: NaturalEnvironment, model: str) -> Gains:
    """Bits by looks; of a rate of hits that any value is as likely for, or known from the two hits of low entropy."""
    if model == "binary":
        return information_gains(EvidenceGrid(place.theta), BinarySensor(DETECT, FALSE_ALARM))
    if model != "beta":
        raise InvalidProblemError(f"model {model!r} came; expected 'binary' or 'beta'")
    known = place.theta != THETA_UNKNOWN
    return information_gains(BetaGrid(np.where(known, 1.0 + HITS, 1.0), np.ones(place.theta.shape)))


def _alone(whole: SearchProblem, searcher: Searcher, budget_s: float) -> SearchProblem:
    return replace(whole, searchers=(replace(searcher, budget=budget_s),))


def environment(kind: str, number: int, nonuniform: bool = False, n_cells: int = 0) -> NaturalEnvironment:
    """The `number`-th environment of a kind; of Experiment 2 where a number of cells is given."""
    if n_cells:
        return experiment_2(number, n_cells)
    made, found = _made(kind, nonuniform)
    while len(found) < number:
        found.append(next(made))
    return found[number - 1]


@lru_cache(maxsize=16)
def _made(kind: str, nonuniform: bool) -> tuple[Iterator[NaturalEnvironment], list[NaturalEnvironment]]:
    """Environments of a kind that a process has made so far, and where the next come from."""
    return natural_environments(kind, nonuniform=nonuniform), []
