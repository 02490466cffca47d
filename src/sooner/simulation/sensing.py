"""What agents read: looks at all cells in view, written to a log as they come."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from sooner.errors import InvalidProblemError
from sooner.grid import Grid
from sooner.sensors.graded import GradedSensor
from sooner.simulation.agents import Agent, Team

__all__ = ["HALF_CELL", "LookLog", "Sensing"]

HALF_CELL = (0.5, 0.5)  # cells east and north: the offset that may stand behind the published figures
MOST_RATIO = 1e100  # that one sensor may tell in one look: the product of two such is a number still
_EVERYWHERE = np.empty(0)  # the glimpse of open ground, for the kernel


@dataclass(frozen=True, eq=False)
class Sensing:
    """How a team's sensors see a world on a grid: what each look reads is settled by seed, second, agent and cell.

    Parameters
    ----------
    grid : Grid
    agents : tuple of Agent               they may differ
    target_offset : (float, float)        cells east and north by which targets are put wrong when they are sorted into
                                          cells for the target sensor. `HALF_CELL` is a hypothesis for the published
                                          figures of [Wolek2020], where our model finds more than they do; not proven
    glimpse : (M,) or (H, W) float, or None   P(a look sees the cell): with that probability both sensors read what
                                          they would in the open, and else both read noise. Left out: all looks see

    Raises
    ------
    InvalidProblemError                   if an agent sees less far than half a cell; if the offset is more than a cell,
                                          or not a number; if the glimpse is not one probability for each cell

    Notes
    -----
    Where there is canopy, one draw for each look settles whether it finds a gap. Draws of different seconds, agents and
    cells are independent, so that patience helps. What a belief is told of a look with share g,

    P(l, f | C) / P(l, f | V) = 1 - g + g p(l | C) p(f | C) / (p(l | V) p(f | V)),  C in {U, O}

    is the ratio of the readings' joint likelihoods: G and Z through one gap are not independent given the state. The
    log holds U : V as the map's ratio and O : U as the target's, so that eq. (7) to (9) of [Wolek2020] and a tracker of
    targets on nodes take in both as they are. Ratios of the open are kept within 1e-100 and 1e100: all stay finite.
    """

    grid: Grid
    agents: tuple[Agent, ...]
    target_offset: tuple[float, float] = (0.0, 0.0)
    glimpse: NDArray[np.float64] | None = None

    def __post_init__(self) -> None:
        for agent in self.agents:
            if agent.radius_m < self.grid.cell_m / 2.0:
                raise InvalidProblemError(
                    f"an agent with radius_m = {agent.radius_m:g} came, and cells of {self.grid.cell_m:g} m; "
                    f"expected at least half a cell, {self.grid.cell_m / 2.0:g} m: looks must cover the path"
                )
        if not all(np.isfinite(part) and abs(part) <= 1.0 for part in self.target_offset):
            raise InvalidProblemError(f"a target offset of {self.target_offset} came; expected at most a cell each way")
        if self.glimpse is not None:
            object.__setattr__(self, "glimpse", _checked_glimpse(self.glimpse, self.grid))

    @cached_property
    def shape(self) -> NDArray[np.int64]:
        """(2,) int64: rows and columns."""
        return np.array(self.grid.shape, np.int64)

    @cached_property
    def cumulative(self) -> NDArray[np.float64]:
        """(A, 4, n) float: P(level <= l) in map noise, map signal, target noise and target signal; 2 past the last."""
        rows = [
            [
                _cumulative(sensor, mean)
                for sensor in (agent.map_sensor, agent.target_sensor)
                for mean in (0, sensor.sensitivity)
            ]
            for agent in self.agents
        ]
        out = np.full((len(rows), 4, self._most_levels), 2.0)
        for agent, tables in enumerate(rows):
            for row, table in enumerate(tables):
                out[agent, row, : len(table)] = table
        return out

    @cached_property
    def ratios(self) -> NDArray[np.float64]:
        """(A, 2, n) float: P(level | signal) / P(level | noise) of each agent's map and target sensor."""
        out = np.ones((len(self.agents), 2, self._most_levels))
        for agent, searcher in enumerate(self.agents):
            for row, sensor in enumerate((searcher.map_sensor, searcher.target_sensor)):
                out[agent, row, : sensor.levels] = sensor.likelihood_ratios
        return np.clip(out, 1.0 / MOST_RATIO, MOST_RATIO)

    @property
    def _most_levels(self) -> int:
        return max(max(agent.map_sensor.levels, agent.target_sensor.levels) for agent in self.agents)

    @cached_property
    def radius_m(self) -> NDArray[np.float64]:
        """(A,) float."""
        return Team(self.agents).radius_m

    @cached_property
    def most_looks(self) -> int:
        """No more looks than this can come in one second."""
        across = 2.0 * self.radius_m / self.grid.cell_m + 1.0
        return int(np.minimum(across**2, self.grid.n_cells).sum()) + len(self.agents)

    def cells_of(self, places_m: NDArray[np.float64]) -> NDArray[np.int64]:
        """(Q,) int64: cells where the target sensor has a signal for targets at (Q, 2) places; -1 off the map."""
        height, width = self.grid.shape
        east, north = np.floor(places_m / self.grid.cell_m + 0.5 + np.array(self.target_offset)).astype(np.int64).T
        inside = (east >= 0) & (east < width) & (north >= 0) & (north < height)
        return np.where(inside, (height - 1 - north) * width + east, -1)

    def look(
        self,
        second: int,
        places_m: NDArray[np.float64],
        nodes: NDArray[np.bool_],
        targets: NDArray[np.int64],
        seed: int,
        log: LookLog,
    ) -> None:
        """Write to the log what all agents read now.

        Parameters
        ----------
        places_m : (A, 2) float      where the agents are
        nodes : (M,) bool            cells that are not void
        targets : (Q,) int64         cells where targets are, -1 for none
        seed : int                   of the noise
        """
        from sooner.simulation._sensing_kernels import sense

        log.begin(second, self.most_looks)
        log.end = sense(
            places_m, self.radius_m, self.shape, self.grid.cell_m, nodes, targets,
            _EVERYWHERE if self.glimpse is None else self.glimpse, seed, second, self.cumulative, self.ratios,
            log.start, log.cells, log.agents, log.map_levels, log.target_levels, log.map_ratios, log.target_ratios,
        )  # fmt: skip


class LookLog:
    """Looks of one search, second by second; the newest second is `start` to `end`.

    cells (L,) int32, agents (L,) int16, map_levels and target_levels (L,) int16; map_ratios and target_ratios (L,)
    float: the likelihood ratios that beliefs take in, P(levels | node) / P(levels | void) and P(levels | target) /
    P(levels | node without one); on open ground those of each sensor's own level.

    Parameters
    ----------
    keep : bool       whether looks of past seconds stay; the log then grows
    """

    def __init__(self, room: int, keep: bool = False) -> None:
        self.keep = keep
        self.start = self.end = 0
        self.firsts: list[int] = []
        self.cells = np.empty(room, np.int32)
        self.agents = np.empty(room, np.int16)
        self.map_levels = np.empty(room, np.int16)
        self.target_levels = np.empty(room, np.int16)
        self.map_ratios = np.empty(room)
        self.target_ratios = np.empty(room)

    @property
    def newest_cells(self) -> NDArray[np.int32]:
        """(k,) int32: the cells of the newest second's looks."""
        return self.cells[self.start : self.end]

    @property
    def newest_target_ratios(self) -> NDArray[np.float64]:
        """(k,) float: what the target sensor read there."""
        return self.target_ratios[self.start : self.end]

    def begin(self, second: int, most: int) -> None:
        """Make room for the looks of one more second."""
        self.start = self.end if self.keep else 0
        if self.keep:
            self.firsts.append(self.start)
        if self.start + most > self.cells.shape[0]:
            self._grow(2 * (self.start + most))

    def _grow(self, room: int) -> None:
        for name, column in list(vars(self).items()):
            if isinstance(column, np.ndarray):
                wider = np.empty(room, column.dtype)
                wider[: self.end] = column[: self.end]
                setattr(self, name, wider)


def _checked_glimpse(glimpse: NDArray[np.float64], grid: Grid) -> NDArray[np.float64]:
    shares = np.array(glimpse, float)
    if shares.shape not in ((grid.n_cells,), grid.shape):
        raise InvalidProblemError(f"a glimpse of shape {shares.shape} came; expected {grid.shape}, one for each cell")
    if not ((shares >= 0.0) & (shares <= 1.0)).all():
        wrong = shares.ravel()[~((shares >= 0.0) & (shares <= 1.0)).ravel()][0]
        raise InvalidProblemError(f"a glimpse of {wrong} came; expected probabilities in [0, 1]")
    return shares.ravel()


def _cumulative(sensor: GradedSensor, mean: float) -> NDArray[np.float64]:
    """(n - 1,) float: P(level <= l) of a normal draw about `mean` that is rounded to the nearest level."""
    from scipy.special import ndtr

    table: NDArray[np.float64] = ndtr(sensor.values[:-1] + 0.5 * sensor.step - mean)
    return table
