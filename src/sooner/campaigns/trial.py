"""A trial, what came of it, and where it is flown."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from itertools import dropwhile
from typing import Any, Literal

__all__ = ["Case", "Ending", "Limits", "Outcome", "Place", "Trial", "in_short"]

LONGEST = 1000  # a reason in short

Ending = Literal["done", "error", "crash", "hang", "memory", "killed", "lost"]


@dataclass(frozen=True)
class Case:
    """One planner on one instance with one budget; a seed makes it a trial.

    Parameters
    ----------
    instance, planner : str       their names in the study
    budget : number or None
    settings : str                JSON object with "instance" and "planner": what the study says of them
    alone : bool                  flown while nothing else of the campaign runs, because its times count
    """

    instance: str
    planner: str
    budget: int | float | None
    settings: str
    alone: bool = False

    @cached_property
    def key(self) -> str:
        """What the ledger knows the case by: all of it, as one text."""
        return json.dumps([self.instance, self.planner, self.budget, self.settings, self.alone])

    @staticmethod
    def from_key(key: str) -> Case:
        """The case of a key."""
        return Case(*json.loads(key))


@dataclass(frozen=True)
class Trial:
    """A case under a seed: a row of the ledger.

    The function that flies it takes the trial and a `Place` and returns an object that JSON can hold: numbers, yes or
    no, null where a trial has no such number, text, lists. What depends on the machine stands under "timing".
    """

    case: Case
    seed: int

    @property
    def budget(self) -> int | float | None:
        """Of its case."""
        return self.case.budget

    @property
    def instance(self) -> dict[str, Any]:
        """What the study says of the instance."""
        return self._settings()["instance"]

    @property
    def planner(self) -> dict[str, Any]:
        """What the study says of the planner."""
        return self._settings()["planner"]

    def _settings(self) -> dict[str, dict[str, Any]]:
        settings: dict[str, dict[str, Any]] = json.loads(self.case.settings)
        return settings

    def __str__(self) -> str:
        budget = "" if self.case.budget is None else f", budget {self.case.budget}"
        alone = ", alone" if self.case.alone else ""
        return f"{self.case.planner} on {self.case.instance}{budget}, seed {self.seed}{alone}"


@dataclass(frozen=True)
class Place:
    """What a trial finds around it, wherever it is flown.

    Parameters
    ----------
    function : str            "module:function" that flies a trial
    folder : str              of the study; modules beside the study are found there
    data : str                folder of real maps, "" where the study needs none
    data_files : tuple        patterns of the files in `data` that decide what comes out
    modules : tuple           modules that planners are made from and that are not sooner's
    """

    function: str
    folder: str = ""
    data: str = ""
    data_files: tuple[str, ...] = ()
    modules: tuple[str, ...] = ()

    @staticmethod
    def of(said: Mapping[str, Any]) -> Place:
        """A place that came as JSON."""
        fields: dict[str, Any] = {key: tuple(it) if isinstance(it, list) else it for key, it in said.items()}
        return Place(**fields)


@dataclass(frozen=True)
class Limits:
    """What one trial may take before it is ended.

    Parameters
    ----------
    seconds : float           on the clock
    memory_mb : float         resident
    """

    seconds: float = 3600.0
    memory_mb: float = float("inf")


@dataclass(frozen=True)
class Outcome:
    """What came of one attempt at a trial.

    Parameters
    ----------
    ending : str
        done; or error (it raised), crash (its process died), hang (past its seconds), memory (past its memory),
        killed (somebody ended its process), lost (a machine or its connection went away)
    answer : str              JSON object, "" unless done
    reason : str              what went wrong, "" where done
    wall_s, cpu_s : float     of this trial, over all its threads
    memory_mb : float         the most that was resident while it ran
    provenance : str          JSON object: commit, source, packages, processor
    """

    trial: Trial
    ending: Ending
    answer: str = ""
    reason: str = ""
    wall_s: float = 0.0
    cpu_s: float = 0.0
    memory_mb: float = 0.0
    provenance: str = ""

    @property
    def measures(self) -> Mapping[str, Any]:
        """The answer as an object."""
        answer: dict[str, Any] = json.loads(self.answer or "{}")
        return answer


def in_short(reason: str) -> str:
    """One line of what went wrong: of a traceback what was raised last, all of its message; else the first.

    >>> in_short("Traceback (most recent call last):\\n  File ...\\nValueError: no such hill\\n")
    'ValueError: no such hill'
    >>> in_short("Traceback (most recent call last):\\n  File ...\\nValueError: no such hills:\\n  moon\\n  sun\\n")
    'ValueError: no such hills: moon sun'
    >>> in_short("its process ended with signal SIGSEGV\\nFatal Python error: ...")
    'its process ended with signal SIGSEGV'
    """
    lines = reason.strip().splitlines() or [""]
    if not lines[0].startswith("Traceback"):
        return lines[0]
    last = max(number for number, line in enumerate(lines) if line.startswith("Traceback"))
    said = list(dropwhile(lambda line: line.startswith(" "), lines[last + 1 :]))
    return " ".join(line.strip() for line in said if line.strip())[:LONGEST] or lines[-1]
