"""sooner plans where drones look, so that a lost person is found sooner.

The names below are imported when they are first used, so that `import sooner` costs nothing.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from sooner.belief import Belief
    from sooner.grid import Grid
    from sooner.planners import gap_below, max_seconds, max_ticks, solve
    from sooner.planners.registry import make_planner
    from sooner.problem import CellMoves, Gains, Objective, Plan, Searcher, SearchProblem, detection_gains, evaluate
    from sooner.sensors import glimpse_from_difficulty

__version__ = "0.1.0"

__all__ = [
    "Belief",
    "CellMoves",
    "Gains",
    "Grid",
    "Objective",
    "Plan",
    "SearchProblem",
    "Searcher",
    "__version__",
    "detection_gains",
    "evaluate",
    "gap_below",
    "glimpse_from_difficulty",
    "make_planner",
    "max_seconds",
    "max_ticks",
    "solve",
]

_ROOMS = {
    "sooner.belief": ("Belief",),
    "sooner.grid": ("Grid",),
    "sooner.planners": ("gap_below", "max_seconds", "max_ticks", "solve"),
    "sooner.planners.registry": ("make_planner",),
    "sooner.problem": (
        "CellMoves",
        "Gains",
        "Objective",
        "Plan",
        "SearchProblem",
        "Searcher",
        "detection_gains",
        "evaluate",
    ),
    "sooner.sensors": ("glimpse_from_difficulty",),
}


def __getattr__(name: str) -> Any:
    from importlib import import_module

    for room, names in _ROOMS.items():
        if name in names:
            return getattr(import_module(room), name)
    raise AttributeError(f"module 'sooner' has no attribute {name!r}")


def __dir__() -> list[str]:
    return sorted(__all__)
