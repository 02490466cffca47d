"""Trials of a search over unknown streets: what each found, and what they say together."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from functools import partial
from typing import Any

from sooner.errors import DataFormatError, Fault, InvalidProblemError
from sooner.missions.estimates import Mean
from sooner.missions.over_waypoints import StreetMission
from sooner.missions.processes import for_each_seed
from sooner.simulation import Episode, Keep, Scene, simulate
from sooner.simulation.strategies import STRATEGIES, Strategy, make_strategy

__all__ = ["COLUMNS", "DEFAULT_STRATEGY", "StreetTrial", "StreetTrials", "episode_of", "fly_streets", "strategy_named"]

DEFAULT_STRATEGY = "joint"
COLUMNS = (
    "seed",
    "e",
    "e_nodes",
    "e_targets",
    "nodes",
    "targets",
    "detected_s",
    "false_calls",
    "false_nodes",
    "repeated_calls",
)
FRAMES = 4  # beliefs kept of the episode that is written


@dataclass(frozen=True)
class StreetTrial:
    """What one search found.

    Parameters
    ----------
    seed : int
    e, e_nodes, e_targets : float      [Wolek2020, eq. (20)] and its halves; not a number without targets
    nodes : float                      share of all nodes detected by the end
    found_s : tuple of int             the second in which each target was detected, -1 never
    false_calls, false_nodes : int     detections of a target with none near, and of nodes where there are none
    repeated_calls : int               detections of a target that had been detected before
    """

    seed: int
    e: float
    e_nodes: float
    e_targets: float
    nodes: float
    found_s: tuple[int, ...]
    false_calls: int
    false_nodes: int
    repeated_calls: int

    @classmethod
    def of(cls, episode: Episode) -> StreetTrial:
        """What an episode found."""
        return cls(
            episode.seed, episode.e, episode.e_nodes, episode.e_targets, float(episode.nodes_curve[-1]),
            tuple(episode.found_targets.tolist()), episode.false_calls, episode.false_nodes,
            episode.repeated_calls,
        )  # fmt: skip

    def row(self) -> list[str]:
        """A line of `trials.csv`; what there is not is left empty, a target of several that was not detected is "-"."""
        found = sum(second >= 0 for second in self.found_s)
        seconds = [str(second) if second >= 0 else "-" for second in self.found_s] if found else []
        there = bool(self.found_s)
        return [
            str(self.seed), f"{self.e:.6f}" if there else "", f"{self.e_nodes:.6f}",
            f"{self.e_targets:.6f}" if there else "", f"{self.nodes:.6f}", str(found) if there else "",
            " ".join(seconds), str(self.false_calls), str(self.false_nodes), str(self.repeated_calls),
        ]  # fmt: skip


@dataclass(frozen=True, eq=False)
class StreetTrials:
    """What trials say together.

    Parameters
    ----------
    mission : StreetMission
    strategy : str
    trials : tuple of StreetTrial
    """

    mission: StreetMission
    strategy: str
    trials: tuple[StreetTrial, ...]

    @property
    def n_targets(self) -> int:
        """How many targets each trial has."""
        return self.mission.scene.world.n_targets

    def means(self) -> dict[str, Mean]:
        """The mean of each measure; of the time to detection, of targets that were detected."""
        trials, there = self.trials, self.n_targets > 0
        seconds = [[second for second in trial.found_s if second >= 0] for trial in trials]
        return {
            "e": Mean.of([trial.e for trial in trials] if there else []),
            "e_nodes": Mean.of([trial.e_nodes for trial in trials]),
            "e_targets": Mean.of([trial.e_targets for trial in trials] if there else []),
            "nodes_detected": Mean.of([trial.nodes for trial in trials]),
            "targets_detected": Mean.of([len(found) / self.n_targets for found in seconds] if there else []),
            "detected_after_s": Mean.of([sum(found) / len(found) for found in seconds if found]),
            "false_detections": Mean.of([trial.false_calls for trial in trials]),
            "with_false_detections": Mean.of([float(trial.false_calls > 0) for trial in trials]),
            "false_nodes": Mean.of([trial.false_nodes for trial in trials]),
            "repeated_detections": Mean.of([trial.repeated_calls for trial in trials]),
            "all_targets_detected": Mean.of([float(all_found) for all_found in self._all_found] if there else []),
            "all_detected_after_s": Mean.of(
                [max(trial.found_s) for trial, all_found in zip(trials, self._all_found, strict=True) if all_found]
                if there
                else []
            ),
        }

    @property
    def _all_found(self) -> list[bool]:
        return [min(trial.found_s, default=-1) >= 0 for trial in self.trials]

    def by_target(self) -> list[tuple[Mean, Mean]]:
        """For each target the share of trials that detected it, and the seconds after which these did."""
        seconds = zip(*(trial.found_s for trial in self.trials), strict=True)
        return [
            (Mean.of([float(second >= 0) for second in each]), Mean.of([second for second in each if second >= 0]))
            for each in seconds
        ]

    def result(self) -> dict[str, Any]:
        """The object that `sooner simulate --json` prints."""
        scene = self.mission.scene
        return {
            "mission": self.mission.name,
            "moves": "waypoints",
            "strategy": self.strategy,
            "trials": len(self.trials),
            "seed": self.trials[0].seed,
            "seconds": scene.seconds,
            "replan_s": scene.replan_s,
            "searchers": len(scene.agents),
            "nodes": scene.world.graph.n_nodes,
            "targets": self.n_targets,
            "detector": scene.estimator.detector,
            "prior": scene.estimator.prior,
            "links": scene.links.said() if scene.links else None,
            "tracks": scene.estimator.tracks,
            **{name: mean.result() for name, mean in self.means().items()},
            "by_target": [
                {"detected": share.result(), "detected_after_s": after.result()} for share, after in self.by_target()
            ],
        }


def strategy_named(name: str | None) -> tuple[str, Strategy]:
    """The strategy of that name, or the default one.

    Raises
    ------
    DataFormatError      if there is no such strategy
    """
    name = DEFAULT_STRATEGY if name is None else name
    if name not in STRATEGIES:
        raise DataFormatError(Fault("--strategy", "", f"{name!r} came", f"expected one of {', '.join(STRATEGIES)}"))
    return name, make_strategy(name)


def fly_streets(mission: StreetMission, strategy: Strategy, seeds: range, workers: int = 1) -> Iterator[StreetTrial]:
    """Fly a mission once for each seed; what comes does not depend on the number of workers.

    Raises
    ------
    DataFormatError      where the strategy cannot fly this mission
    """
    try:
        yield from for_each_seed(partial(_fly, mission.scene, strategy), seeds, workers)
    except InvalidProblemError as error:
        came, _, expected = str(error).partition("; ")
        expected = expected or "expected another --strategy"
        raise DataFormatError(Fault(str(mission.path), "searcher", came, expected)) from None


def episode_of(mission: StreetMission, strategy: Strategy, seed: int) -> Episode:
    """One flight with what was believed at some times, to keep and to draw."""
    every_s = max(1, mission.scene.seconds // FRAMES)
    return simulate(mission.scene, strategy, seed, Keep(beliefs_s=every_s))


def _fly(scene: Scene, strategy: Strategy, seed: int) -> StreetTrial:
    return StreetTrial.of(simulate(scene, strategy, seed))
