"""Episodes in files: an .npz of plain arrays and one line of JSON; nothing in it is ever run."""

from __future__ import annotations

import json
from itertools import pairwise
from pathlib import Path

import numpy as np

from sooner.errors import DataFormatError, Fault, InvalidProblemError
from sooner.io.arrays import Arrays, array_like, arrays_npz, read_arrays
from sooner.simulation.episode import Beliefs, Call, Episode, Looks
from sooner.simulation.loop import Keep, simulate
from sooner.simulation.scene import Scene
from sooner.simulation.scene_description import described, scene_of, strategy_of

__all__ = ["load_episode", "replayed", "save_episode"]

FORMAT = "sooner episode 1"
_ALWAYS = (
    "about", "cells", "edges", "node_places_m", "targets", "places_m", "node_seconds", "sums", "calls", "waypoints",
    "route_lengths",
)  # fmt: skip
_GLIMPSE = "glimpse"  # where looks are in vain in places
_LOOKS = ("firsts", "cells", "agents", "map_levels", "target_levels")
_BELIEFS = ("seconds", "void", "occupied", "explored")
_BY_AGENT = "agents_node_seconds"
_FOLLOWED = "followed"
_EXPECTED = "expected an episode that sooner wrote"


def save_episode(episode: Episode, path: Path) -> None:
    """Write an episode.

    Raises
    ------
    InvalidProblemError      where the target walks by a function of your own: no file can hold it
    """
    graph = episode.scene.world.graph
    routes = [route for plan in episode.plans for route in plan]
    about = {"format": FORMAT, "seed": episode.seed, **described(episode.scene, episode.strategy)}
    arrays: Arrays = {
        "about": np.frombuffer(json.dumps(about).encode(), np.uint8),
        "cells": graph.cells,
        "edges": graph.edges,
        "node_places_m": graph.positions_m,
        "targets": episode.targets,
        "places_m": episode.places_m,
        "node_seconds": episode.node_seconds,
        "sums": episode.sums,
        "calls": np.array([(call.second, call.cell, call.target) for call in episode.calls], np.int64).reshape(-1, 3),
        "waypoints": np.concatenate([np.empty((0, 2)), *routes]),
        "route_lengths": np.array([len(route) for route in routes], np.int64),
    }
    if episode.scene.glimpse is not None:
        arrays[_GLIMPSE] = episode.scene.glimpse
    if episode.looks is not None:
        arrays |= {f"looks_{name}": getattr(episode.looks, name) for name in _LOOKS}
    if episode.beliefs is not None:
        arrays |= {f"beliefs_{name}": getattr(episode.beliefs, name) for name in _BELIEFS}
    if episode.agents_node_seconds is not None:
        arrays[_BY_AGENT] = episode.agents_node_seconds
    if len(episode.followed):
        arrays[_FOLLOWED] = episode.followed
    path.write_bytes(arrays_npz(arrays))


def load_episode(path: Path) -> Episode:
    """Read an episode.

    Raises
    ------
    DataFormatError      missing, too large, not an episode, or one that contradicts itself
    """
    kept = (*(f"looks_{name}" for name in _LOOKS), *(f"beliefs_{name}" for name in _BELIEFS))
    arrays = read_arrays(path, _ALWAYS, (_BY_AGENT, _FOLLOWED, _GLIMPSE, *kept), _EXPECTED)
    try:
        return _episode(arrays)
    except (ValueError, RecursionError, KeyError, TypeError) as error:  # InvalidProblemError is a ValueError
        raise DataFormatError(Fault(str(path), "", f"{error}", _EXPECTED)) from None


def replayed(episode: Episode) -> Episode:
    """The same search flown again: what is not the same then was not flown by this version of sooner.

    Raises
    ------
    InvalidProblemError      where the strategy is not known
    """
    if episode.strategy is None:
        raise InvalidProblemError("an episode by a strategy that is not ours came; it cannot be flown again")
    beliefs_s = 0
    if episode.beliefs is not None:
        apart = np.diff(episode.beliefs.seconds)
        beliefs_s = int(apart[0]) if len(apart) else episode.seconds
    return simulate(episode.scene, episode.strategy, episode.seed, Keep(episode.looks is not None, beliefs_s))


def _episode(arrays: Arrays) -> Episode:
    about = json.loads(bytes(arrays["about"].astype(np.uint8)).decode())
    if not isinstance(about, dict) or about.get("format") != FORMAT:
        raise InvalidProblemError("the format of another version, or none, came")
    scene = scene_of(about, arrays["cells"], arrays["edges"], arrays["node_places_m"], arrays.get(_GLIMPSE))
    _check(arrays, scene)
    n_agents = len(scene.agents)
    bounds = np.concatenate([[0], np.cumsum(arrays["route_lengths"])])
    routes = [arrays["waypoints"][first:last] for first, last in pairwise(bounds)]
    return Episode(
        scene=scene,
        strategy=strategy_of(about),
        seed=int(about["seed"]),
        targets=arrays["targets"],
        places_m=arrays["places_m"],
        node_seconds=arrays["node_seconds"],
        sums=arrays["sums"],
        calls=tuple(Call(*row) for row in arrays["calls"].tolist()),
        plans=tuple(tuple(routes[n : n + n_agents]) for n in range(0, len(routes), n_agents)),
        looks=Looks(*(arrays[f"looks_{name}"] for name in _LOOKS)) if "looks_firsts" in arrays else None,
        beliefs=Beliefs(*(arrays[f"beliefs_{name}"] for name in _BELIEFS)) if "beliefs_seconds" in arrays else None,
        agents_node_seconds=arrays.get(_BY_AGENT),
        followed=arrays.get(_FOLLOWED, np.empty((0, 3), np.int64)),
    )


def _check(arrays: Arrays, scene: Scene) -> None:
    """Refuse arrays that do not belong together."""
    T, A, M = scene.seconds, len(scene.agents), scene.grid.n_cells
    N, Q = scene.world.graph.n_nodes, scene.world.n_targets
    array_like(arrays, "targets", "i", (T + 1, Q), 0, N - 1)
    array_like(arrays, "places_m", "f", (T + 1, A, 2))
    array_like(arrays, "node_seconds", "i", (M,), -1, T - 1)
    if _BY_AGENT in arrays:
        array_like(arrays, _BY_AGENT, "i", (A, M), -1, T - 1)
    array_like(arrays, "sums", "f", (T,), 0.0)
    calls = array_like(arrays, "calls", "i", (None, 3), -1)
    if len(calls) and not (calls.min(axis=0) >= [0, 0, -1]).all() & (calls.max(axis=0) < [T, M, max(Q, 1)]).all():
        raise InvalidProblemError("calls out of the mission's seconds, cells or targets came")
    if _FOLLOWED in arrays:
        followed = array_like(arrays, _FOLLOWED, "i", (None, 3), 0)
        if len(followed) and not (followed.max(axis=0) < [T, T * A + 1, M]).all():
            raise InvalidProblemError("targets followed out of the mission's seconds or cells came")
    lengths = array_like(arrays, "route_lengths", "i", (None,), 0, 1_000_000)
    array_like(arrays, "waypoints", "f", (int(lengths.sum()), 2))
    if len(lengths) % A:
        raise InvalidProblemError(f"{len(lengths)} routes came for {A} agents")
    if any(name.startswith("looks_") for name in arrays):
        _check_looks(arrays, T, A, M)
    if any(name.startswith("beliefs_") for name in arrays):
        B = len(array_like(arrays, "beliefs_seconds", "i", (None,), 0, T - 1))
        for name in ("void", "occupied"):
            array_like(arrays, f"beliefs_{name}", "f", (B, M), 0.0, 1.0)
        array_like(arrays, "beliefs_explored", "b", (B, M))


def _check_looks(arrays: Arrays, T: int, A: int, M: int) -> None:
    cells = array_like(arrays, "looks_cells", "i", (None,), 0, M - 1)
    firsts = array_like(arrays, "looks_firsts", "i", (T + 1,), 0, len(cells))
    if firsts[0] != 0 or firsts[-1] != len(cells) or (np.diff(firsts) < 0).any():
        raise InvalidProblemError("looks whose seconds do not follow one another came")
    array_like(arrays, "looks_agents", "i", cells.shape, 0, A - 1)
    for name in ("looks_map_levels", "looks_target_levels"):
        array_like(arrays, name, "i", cells.shape, 0)
