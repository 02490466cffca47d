"""The record of one flown plan over cells or regions."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import cached_property
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from sooner.belief import BetaGrid
from sooner.errors import InvalidProblemError
from sooner.grid import Grid
from sooner.simulation.answers import AnswerModel, Known, theta_of

__all__ = ["Answers", "Course", "Flown", "Intent", "PlanEpisode"]

Ints = NDArray[np.int64]
Floats = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Course:
    """Where a drone is, or will be, when.

    Parameters
    ----------
    times : (n,) float         rising; empty for a drone that is not planned for
    places_m : (n, 2) float    metres east and north; between two times on the straight line from one to the other
    """

    times: Floats
    places_m: Floats

    def at(self, time: float) -> Floats:
        """(2,) float: where it is then; before and after at its ends."""
        return np.array([np.interp(time, self.times, axis) for axis in self.places_m.T])

    def between(self, first: float, last: float) -> Floats:
        """(k, 2) float: its way from one time to another."""
        inner = (self.times > first) & (self.times < last)
        return np.vstack([self.at(first), self.places_m[inner], self.at(last)])


@dataclass(frozen=True, eq=False)
class Intent:
    """A plan as it was made on the way: a course for each drone of the mission, empty for one that keeps its own.

    Parameters
    ----------
    time : float               when it was made; over regions a course begins where and when its drone is free
    courses : tuple of Course
    """

    time: float
    courses: tuple[Course, ...]


@dataclass(frozen=True, eq=False)
class Answers:
    """Looks in order of time, and what they answered.

    Parameters
    ----------
    cells : (L,) int64
    times : (L,) float
    searchers : (L,) int64     who looked
    yes : (L,) bool
    """

    cells: Ints
    times: Floats
    searchers: Ints
    yes: NDArray[np.bool_]


@dataclass(frozen=True, eq=False)
class Flown:
    """What was asked of whom: enough, with the mission and the seed, to fly it again.

    Parameters
    ----------
    mission : str              its name
    seed : int
    planner : str
    every : float or None      time between plans; None: the first was flown to its end
    ticks : int                of the planner at each replan
    actions : of (n,) int64    the first plan
    unit : str                 of values: "probability", "targets" or "bits"
    unit_s : float or None     seconds that a unit of time takes: of a step, or 1 over regions; None where nobody says
    """

    mission: str
    seed: int
    planner: str
    every: float | None
    ticks: int
    actions: tuple[Ints, ...]
    unit: str
    unit_s: float | None


@dataclass(frozen=True, eq=False)
class PlanEpisode:
    """One flown plan: what was true, where drones went, what they looked at, were answered, believed and planned.

    What was believed at any time follows from what was known before and from the answers until then, by Bayes' law
    (`AnswerModel.after`); so it is not kept beside them.

    Parameters
    ----------
    grid : Grid                the ground, N cells
    model : AnswerModel        what was known before, and how looks answer
    flown : Flown
    truth : (N,) float         1 where somebody was, 0 where nobody; where targets come and go, P(one is in view)
    answers : Answers
    plans : tuple of Intent    the first at time 0

    Raises
    ------
    InvalidProblemError        if parts do not belong together: answers that cannot be, plans out of order
    """

    grid: Grid
    model: AnswerModel
    flown: Flown
    truth: Floats
    answers: Answers
    plans: tuple[Intent, ...] = field(repr=False)

    def __post_init__(self) -> None:
        if self.model.n_cells != self.grid.n_cells or self.truth.shape != (self.grid.n_cells,):
            raise InvalidProblemError(f"a belief or a truth of other than the grid's {self.grid.n_cells} cells came")
        if not self.plans or self.plans[0].time != 0 or any(b.time <= a.time for a, b in pairwise(self.plans)):
            raise InvalidProblemError("plans came out of order; expected the first at 0, and each after the one before")
        if not all(len(course.times) for course in self.plans[0].courses):
            raise InvalidProblemError("a first plan came that leaves out a drone")
        chance, yes = self.model.chance(self.answers.cells, self.truth[self.answers.cells]), self.answers.yes
        if (yes & (chance <= 0)).any() or (~yes & (chance >= 1)).any():
            raise InvalidProblemError("answers came that cannot be: a yes that is impossible, or a no")

    @property
    def there(self) -> Ints:
        """Cells that hold somebody who stays."""
        return np.zeros(0, np.int64) if isinstance(self.model.known, BetaGrid) else np.flatnonzero(self.truth)

    @cached_property
    def found(self) -> Floats:
        """When each of those `there` was found, by the first yes at their cell; inf never."""
        first = np.full(self.grid.n_cells, np.inf)
        np.minimum.at(first, self.answers.cells[self.answers.yes], self.answers.times[self.answers.yes])
        return first[self.there]

    @cached_property
    def false(self) -> NDArray[np.bool_]:
        """(L,) bool: looks that said yes where nobody is."""
        return self.answers.yes & (self.truth[self.answers.cells] <= 0)

    @cached_property
    def courses(self) -> tuple[Course, ...]:
        """The flights as they were flown: each plan's courses until the next has others."""
        return tuple(_flown([plan.courses[n] for plan in self.plans]) for n in range(len(self.plans[0].courses)))

    @property
    def duration(self) -> float:
        """When the last drone landed."""
        return max(float(course.times[-1]) for course in self.courses)

    def known_at(self, time: float) -> Known:
        """What was believed after the looks until then."""
        return self.model.after(*self._counts(time))

    def theta_at(self, time: float) -> Floats:
        """(N,) float: P(somebody is in each cell), as believed after the looks until then."""
        return theta_of(self.known_at(time))

    def learnt_at(self, times: Sequence[float]) -> Floats:
        """(n,) float: bits by which what was believed at each time is less uncertain than before; it may be negative.

        Of one person, of his place; else summed over cells. What happens in cells that nobody looks at is worked out
        once: one person's entropy there is that of where there he is, times how likely he is there.
        """
        cells = np.unique(self.answers.cells)
        if not len(cells):
            return np.zeros(len(times))
        few, before = self.model.narrowed(cells), self.model.bits(self.model.known)
        lump = before - few.bits(few.known)  # of cells each by itself: what never changes
        outside = getattr(few.known, "outside", None)
        left = []
        for time in times:
            looks, hits = self._counts(time)
            known = few.after(looks[cells], hits[cells])
            share = 1.0 if outside is None else getattr(known, "outside", 0.0) / outside if outside > 0 else 0.0
            left.append(few.bits(known) + share * lump)
        return np.asarray(before - np.array(left))

    def _counts(self, time: float) -> tuple[Ints, Ints]:
        """Looks at each cell until then, and those that said yes."""
        last = int(np.searchsorted(self.answers.times, time, side="right"))
        cells, yes = self.answers.cells[:last], self.answers.yes[:last]
        return np.bincount(cells, minlength=self.grid.n_cells), np.bincount(cells[yes], minlength=self.grid.n_cells)


def _flown(courses: Sequence[Course]) -> Course:
    """One course of several: each until the next begins."""
    made = [course for course in courses if len(course.times)]
    ends = [float(course.times[0]) for course in made[1:]] + [np.inf]
    kept = [course.times <= end for course, end in zip(made, ends, strict=True)]
    times = np.concatenate([course.times[own] for course, own in zip(made, kept, strict=True)])
    places = np.concatenate([course.places_m[own] for course, own in zip(made, kept, strict=True)])
    return Course(times, places)
