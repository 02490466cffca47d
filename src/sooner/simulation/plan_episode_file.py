"""Episodes of plans in files: an .npz of plain arrays and one line of JSON; nothing in it is ever run."""

from __future__ import annotations

import json
from dataclasses import fields
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np

from sooner.belief import Belief, BetaGrid, EvidenceGrid
from sooner.errors import DataFormatError, Fault, InvalidProblemError, SoonerError
from sooner.grid import Grid
from sooner.io.arrays import Arrays, array_like, arrays_npz, read_arrays
from sooner.simulation.answers import AnswerModel, Known
from sooner.simulation.plan_episode import Answers, Course, Flown, Intent, PlanEpisode

__all__ = ["load_plan_episode", "plan_episode_npz"]

FORMAT = "sooner episode of a plan 1"
_EXPECTED = "expected an episode of a plan that sooner wrote"
_ALWAYS = (
    "about", "known", "detect", "truth", "looks_cells", "looks_times", "looks_searchers", "looks_yes", "actions",
    "action_counts", "plan_times", "course_lengths", "course_times", "course_places_m",
)  # fmt: skip
_KINDS = ("person", "targets", "rates")
_WISHES = ("mission", "seed", "planner", "every", "ticks", "unit", "unit_s")  # of `Flown`, but for its actions


def plan_episode_npz(episode: PlanEpisode) -> bytes:
    """An episode of a plan as an .npz."""
    model, grid, answers = episode.model, episode.grid, episode.answers
    known = model.known
    courses = [course for plan in episode.plans for course in plan.courses]
    about = {
        "format": FORMAT,
        "shape": list(grid.shape),
        "connectivity": grid.connectivity,
        "cell_m": grid.cell_m,
        "kind": "person" if isinstance(known, Belief) else "rates" if isinstance(known, BetaGrid) else "targets",
        "outside": known.outside if isinstance(known, Belief) else 0.0,
        "false_alarm": model.false_alarm,
        "correlation": model.correlation,
        **{name: getattr(episode.flown, name) for name in _WISHES},
    }
    arrays: Arrays = {
        "about": np.frombuffer(json.dumps(about).encode(), np.uint8),
        "known": _known_arrays(known),
        "detect": model.detects if np.ptp(model.detects) > 0 else model.detects[:1],
        "truth": episode.truth,
        **{f"looks_{field.name}": getattr(answers, field.name) for field in fields(answers)},
        "actions": np.concatenate(episode.flown.actions),
        "action_counts": np.array([len(actions) for actions in episode.flown.actions], np.int64),
        "plan_times": np.array([plan.time for plan in episode.plans]),
        "course_lengths": np.array([len(course.times) for course in courses], np.int64),
        "course_times": np.concatenate([course.times for course in courses]),
        "course_places_m": np.concatenate([course.places_m for course in courses]),
    }
    if grid.obstacles is not None:
        arrays["obstacles"] = grid.obstacles
    return arrays_npz(arrays)


def load_plan_episode(path: Path) -> PlanEpisode:
    """Read an episode of a plan.

    Raises
    ------
    DataFormatError      missing, too large, no such episode, or one that contradicts itself
    """
    arrays = read_arrays(path, _ALWAYS, ("obstacles",), _EXPECTED)
    try:
        return _episode(arrays)
    except (ValueError, RecursionError, KeyError, TypeError, OverflowError, SoonerError) as error:
        raise DataFormatError(Fault(str(path), "", f"{error}"[:300], _EXPECTED)) from None


def _known_arrays(known: Known) -> Any:
    if isinstance(known, BetaGrid):
        return np.stack([known.alpha.ravel(), known.beta.ravel()])
    return (known.poc if isinstance(known, Belief) else known.theta).reshape(1, -1)


def _episode(arrays: Arrays) -> PlanEpisode:
    about = json.loads(bytes(arrays["about"].astype(np.uint8)).decode())
    if not isinstance(about, dict) or about.get("format") != FORMAT:
        raise InvalidProblemError("the format of another version, or none, came")
    grid, team = _grid(about, arrays), len(arrays["action_counts"])
    flown = Flown(actions=_actions(arrays), **{name: about[name] for name in _WISHES})
    _check_flown(flown)
    return PlanEpisode(
        grid=grid,
        model=_model(about, arrays, grid),
        flown=flown,
        truth=array_like(arrays, "truth", "f", (grid.n_cells,), 0.0, 1.0),
        answers=_answers(arrays, grid.n_cells, team),
        plans=_plans(arrays, team),
    )


def _grid(about: dict[str, Any], arrays: Arrays) -> Grid:
    rows, cols = (_whole(number) for number in about["shape"])
    n_cells = arrays["truth"].size
    if rows * cols != n_cells:
        raise InvalidProblemError(f"a map of {rows} x {cols} cells came, and the truth of {n_cells}")
    obstacles = array_like(arrays, "obstacles", "b", (rows, cols)) if "obstacles" in arrays else None
    return Grid((rows, cols), about["connectivity"], float(about["cell_m"]), obstacles)


def _model(about: dict[str, Any], arrays: Arrays, grid: Grid) -> AnswerModel:
    kind = about["kind"]
    if kind not in _KINDS:
        raise InvalidProblemError(f"a belief of kind {kind!r} came; expected one of {', '.join(_KINDS)}")
    rows = array_like(arrays, "known", "f", (2 if kind == "rates" else 1, grid.n_cells), 0.0).reshape(-1, *grid.shape)
    if kind == "rates":
        known: Known = BetaGrid(rows[0], rows[1])
    else:
        known = Belief(rows[0], float(about["outside"])) if kind == "person" else EvidenceGrid(rows[0])
    detect = array_like(arrays, "detect", "f", (None,), 0.0, 1.0)
    if len(detect) == 1:
        detect = np.full(grid.n_cells, detect[0])
    return AnswerModel(known, detect, float(about["false_alarm"]), float(about["correlation"]))


def _actions(arrays: Arrays) -> tuple[Any, ...]:
    actions = array_like(arrays, "actions", "i", (None,), 0)
    counts = array_like(arrays, "action_counts", "i", (None,), 1)
    if not len(counts) or counts.sum() != len(actions):
        raise InvalidProblemError(f"{len(actions)} actions came; expected {counts.sum()}, of one drone or more")
    return tuple(np.split(actions, np.cumsum(counts)[:-1]))


def _answers(arrays: Arrays, n_cells: int, team: int) -> Answers:
    times = array_like(arrays, "looks_times", "f", (None,), 0.0)
    if (np.diff(times) < 0).any():
        raise InvalidProblemError("looks that do not follow one another came")
    return Answers(
        array_like(arrays, "looks_cells", "i", times.shape, 0, n_cells - 1),
        times,
        array_like(arrays, "looks_searchers", "i", times.shape, 0, team - 1),
        array_like(arrays, "looks_yes", "b", times.shape),
    )


def _plans(arrays: Arrays, team: int) -> tuple[Intent, ...]:
    made = array_like(arrays, "plan_times", "f", (None,), 0.0)
    lengths = array_like(arrays, "course_lengths", "i", (len(made) * team,), 0)
    times = array_like(arrays, "course_times", "f", (int(lengths.sum()),), 0.0)
    places = array_like(arrays, "course_places_m", "f", (len(times), 2))
    bounds = np.concatenate([[0], np.cumsum(lengths)])
    courses = [Course(times[first:last], places[first:last]) for first, last in pairwise(bounds)]
    if any((np.diff(course.times) < 0).any() for course in courses):
        raise InvalidProblemError("a course whose times do not rise came")
    return tuple(Intent(float(time), tuple(courses[n * team : (n + 1) * team])) for n, time in enumerate(made.tolist()))


def _check_flown(flown: Flown) -> None:
    sound = (
        all(isinstance(name, str) for name in (flown.mission, flown.planner, flown.unit))
        and flown.unit in ("probability", "targets", "bits")
        and _whole(flown.seed) >= 0
        and _whole(flown.ticks) >= 1
        and all(
            number is None or (isinstance(number, int | float) and 0 < number < np.inf)
            for number in (flown.every, flown.unit_s)
        )
    )
    if not sound:
        raise InvalidProblemError("a mission, seed, planner or unit that cannot be came")


def _whole(number: Any) -> int:
    if not isinstance(number, int) or isinstance(number, bool):
        raise InvalidProblemError(f"{number!r} came; expected a whole number")
    return number
