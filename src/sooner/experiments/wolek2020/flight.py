"""One trial: a mission of a team on one of the maps, flown by one strategy with one way to estimate."""

from __future__ import annotations

import time
from collections.abc import Mapping
from dataclasses import fields, replace
from math import isfinite
from pathlib import Path
from typing import Any

import numpy as np

from sooner.campaigns.trial import Place, Trial
from sooner.experiments.wolek2020.scenes import scene
from sooner.simulation import Episode, Estimator, Scene, simulate
from sooner.simulation.strategies import Strategy, make_strategy

__all__ = ["SAMPLES", "fly", "parts"]

SAMPLES = 60  # of the curves that a trial answers, after the start
OF_ESTIMATOR = frozenset(field.name for field in fields(Estimator))


def fly(trial: Trial, place: Place) -> Mapping[str, Any]:
    """Fly one mission, in a process whose kernels are loaded; where the target walks depends on map and seed alone.

    The instance is what `scenes.scene` takes, the budget the seconds of the mission. The planner is `{ strategy = NAME,
    ... }` with settings of the strategy and of `sooner.simulation.Estimator`.

    Answers `e`, `e_nodes`, `e_targets` [Wolek2020, eq. (20)] and `found`, `found_s`, the target's detection (null
    without a target or a detection); `nodes_end`, the share of nodes detected in the end, and `all_nodes_s`; of false
    detections `false_calls`, `called_falsely` and `false_nodes`; `by_half`, the share of nodes detected by half time;
    `parts` and `alone`, connected streets and lone nodes among the nodes detected in the first quarter; `nodes`, the
    share of nodes detected at 61 times, start and end among them; under `timing` the seconds of the mission, by the
    clock and of the process.
    """
    strategy, estimator = _made(trial.planner)
    seconds = None if trial.budget is None else int(trial.budget)
    where = scene(Path(place.data), trial.instance, estimator, seconds)
    _load_kernels(where, strategy)
    wall, cpu = time.perf_counter(), time.process_time()
    flown = simulate(where, strategy, trial.seed)
    timing = {"seconds": time.perf_counter() - wall, "cpu_seconds": time.process_time() - cpu}
    return {**_scored(flown), **_false(flown), **_progress(flown), "timing": timing}


def _made(said: Mapping[str, Any]) -> tuple[Strategy, Estimator]:
    settings = {key: value for key, value in said.items() if key not in OF_ESTIMATOR and key != "strategy"}
    estimator = Estimator(**{key: value for key, value in said.items() if key in OF_ESTIMATOR})
    return make_strategy(said["strategy"], **settings), estimator


def _scored(flown: Episode) -> dict[str, Any]:
    found = int(flown.found_targets[0]) if flown.n_targets else -1
    return {
        "e": _known(flown.e),
        "e_nodes": flown.e_nodes,
        "e_targets": _known(flown.e_targets),
        "found": found >= 0 if flown.n_targets else None,
        "found_s": found if found >= 0 else None,
    }


def _false(flown: Episode) -> dict[str, Any]:
    return {
        "false_calls": flown.false_calls,
        "called_falsely": flown.false_calls > 0,
        "false_nodes": flown.false_nodes,
    }


def _progress(flown: Episode) -> dict[str, Any]:
    curve, last = flown.nodes_curve, int(flown.found_nodes.max())
    streets, alone = parts(flown, flown.seconds // 4)
    at = np.linspace(0, flown.seconds, SAMPLES + 1).round().astype(int)
    return {
        "nodes_end": float(curve[-1]),
        "all_nodes_s": last if (flown.found_nodes >= 0).all() else None,
        "by_half": float(curve[flown.seconds // 2]),
        "parts": streets,
        "alone": alone,
        "nodes": curve[at].round(5).tolist(),
    }


def parts(flown: Episode, second: int) -> tuple[int, int]:
    """How many connected streets of two nodes or more, and how many lone nodes, were detected by a second."""
    from scipy.sparse import coo_array
    from scipy.sparse.csgraph import connected_components

    detected = (flown.found_nodes >= 0) & (flown.found_nodes <= second)
    edges = flown.scene.world.graph.explored_edges(detected)
    joined = coo_array((np.ones(len(edges)), (edges[:, 0], edges[:, 1])), shape=(detected.size, detected.size))
    _, labels = connected_components(joined, directed=False)
    sizes = np.bincount(labels[detected])
    return int((sizes > 1).sum()), int((sizes == 1).sum())


def _known(value: float) -> float | None:
    return value if isfinite(value) else None


_loaded: set[tuple[str, str, int]] = set()


def _load_kernels(where: Scene, strategy: Strategy) -> None:
    """Once a process for each scene and strategy, with what a scene makes once, so that no trial pays for it."""
    key = repr(strategy), repr(where.estimator), id(where.world)
    if key not in _loaded:
        _loaded.add(key)
        simulate(replace(where, seconds=2 * where.replan_s), strategy, 0)
