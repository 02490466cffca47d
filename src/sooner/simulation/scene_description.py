"""A scene and a strategy in words that JSON has, and back."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict, fields
from typing import Any

import numpy as np
from numpy.typing import NDArray

from sooner.errors import InvalidProblemError
from sooner.grid import Grid
from sooner.sensors.graded import GradedSensor
from sooner.simulation.agents import Agent
from sooner.simulation.estimation import Estimator
from sooner.simulation.links import Links
from sooner.simulation.scene import Scene
from sooner.simulation.strategies.registry import STRATEGIES, make_strategy, settings_of
from sooner.simulation.strategies.strategy import Strategy
from sooner.simulation.world import World
from sooner.streets import Evasive, OccupancyGraph, TargetWalk

__all__ = ["described", "scene_of", "strategy_of"]


def described(scene: Scene, strategy: Strategy | None) -> dict[str, Any]:
    """Everything of a scene but its graph and its glimpse, and the strategy.

    Raises
    ------
    InvalidProblemError      for a walk with a bias that is a function: no file can hold it
    """
    walk, evasive = scene.world.walk, scene.world.evasive
    if walk.bias is not None:
        raise InvalidProblemError("a walk with a bias of your own came; a file cannot hold a function")
    name, settings = settings_of(strategy) if strategy else ("", {})
    return {
        "shape": list(scene.grid.shape),
        "cell_m": scene.grid.cell_m,
        "walk": {key: value for key, value in asdict(walk).items() if key != "bias"},
        "evasive": {"reach_m": evasive.reach_m, "boldness": evasive.boldness} if evasive else None,
        "n_targets": scene.world.n_targets,
        "agents": [asdict(agent) for agent in scene.agents],
        "estimator": asdict(scene.estimator),
        "seconds": scene.seconds,
        "replan_s": scene.replan_s,
        "target_offset": list(scene.target_offset),
        "starts_m": None if scene.starts_m is None else scene.starts_m.tolist(),
        "links": scene.links.said() if scene.links else None,
        "strategy": {"name": name, "settings": settings},
    }


def scene_of(
    said: Mapping[str, Any],
    cells: NDArray[np.int64],
    edges: NDArray[np.int64],
    places_m: NDArray[np.float64],
    glimpse: NDArray[np.float64] | None = None,
) -> Scene:
    """The scene that was described.

    Raises
    ------
    InvalidProblemError      if it makes no sense, or says less or other things than `described` does
    """
    try:
        grid = Grid((int(said["shape"][0]), int(said["shape"][1])), "square8", float(said["cell_m"]))
        evasive = said["evasive"]
        world = World(
            OccupancyGraph(grid, cells, edges, places_m),
            TargetWalk(**_known(TargetWalk, said["walk"])),
            int(said["n_targets"]),
            None if evasive is None else Evasive(np.empty((0, 2)), **_known(Evasive, evasive)),
        )
        east, north = said["target_offset"]
        starts, links = said["starts_m"], said.get("links")
        return Scene(
            world,
            tuple(_agent(each) for each in said["agents"]),
            Estimator(**_known(Estimator, said["estimator"])),
            int(said["seconds"]),
            int(said["replan_s"]),
            (float(east), float(north)),
            None if starts is None else np.array(starts, float),
            None if links is None else Links.of(_known(Links, links)),
            glimpse,
        )
    except InvalidProblemError:
        raise
    except (KeyError, TypeError, ValueError, AttributeError, IndexError, OverflowError) as error:
        raise InvalidProblemError(f"a scene came that cannot be read ({type(error).__name__}: {error})") from None


def strategy_of(said: Mapping[str, Any]) -> Strategy | None:
    """The strategy that was described; None for one that is not in the list."""
    try:
        name, settings = str(said["strategy"]["name"]), dict(said["strategy"]["settings"])
    except (KeyError, TypeError, ValueError) as error:
        raise InvalidProblemError(f"a strategy came that cannot be read ({type(error).__name__}: {error})") from None
    return make_strategy(name, **settings) if name in STRATEGIES else None


def _agent(said: Mapping[str, Any]) -> Agent:
    own = _known(Agent, said)
    for sensor in ("map_sensor", "target_sensor"):
        if sensor in own:
            own[sensor] = GradedSensor(**_known(GradedSensor, own[sensor]))
    return Agent(**own)


def _known(kind: Any, said: Mapping[str, Any]) -> dict[str, Any]:
    unknown = said.keys() - {each.name for each in fields(kind)}
    if unknown:
        raise InvalidProblemError(f"setting {min(unknown)!r} came; {kind.__name__} has none of that name")
    return dict(said)
