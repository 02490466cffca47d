"""Progress on stderr: a live line on a terminal, a few plain lines elsewhere."""

from __future__ import annotations

import math
import sys
from functools import cached_property
from types import TracebackType
from typing import Any

from sooner.cli.exits import say
from sooner.cli.words import amount
from sooner.missions import Mission
from sooner.missions.reference_plan import iterative_greedy
from sooner.planners import Progress
from sooner.planners.registry import DEFAULT
from sooner.problem.incumbent import gap

__all__ = ["Watch"]


class Watch:
    """Tells how the planning goes."""

    def __init__(self, mission: Mission, planner: str | None, seconds: float, quiet: bool) -> None:
        self.mission, self.planner, self.seconds, self.quiet = mission, planner or DEFAULT, seconds, quiet
        self._live: Any = None
        self._told = -math.inf

    def __enter__(self) -> Watch:
        if self.quiet:
            return self
        for note in self.mission.notes:
            say(f"note: {note}")
        say(f"planning with {self.planner} for up to {self.seconds:g} s (Ctrl-C keeps the best so far)")
        if sys.stderr.isatty():
            from rich.console import Console
            from rich.live import Live

            self._live = Live(console=Console(stderr=True), refresh_per_second=8, transient=True)
            self._live.start()
        return self

    def tick(self, progress: Progress) -> None:
        """Show the progress, not more often than anyone can read."""
        if self.quiet:
            return
        wait = 0.1 if self._live is not None else max(2.0, self.seconds / 5)
        if progress.seconds - self._told < wait:
            return
        self._told = progress.seconds
        if self._live is not None:
            from rich.text import Text

            self._live.update(Text(self._line(progress)))
        else:
            say(self._line(progress))

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        if self._live is not None:
            self._live.stop()

    def _line(self, progress: Progress) -> str:
        target = self.mission.problem.objective.target
        parts = [f"{progress.seconds:6.1f} s"]
        if target is not None:
            reached = math.isfinite(progress.value)
            parts.append(
                f"{target:.0%} after {-progress.value:.0f} steps" if reached else f"{target:.0%} not reached yet"
            )
            if -math.inf < progress.bound < 0:
                parts.append(f"never before {-progress.bound:.0f}")
            return "   ".join(parts)
        parts.append(f"{self._verb} {self._told_value(progress.value)}")
        reference = self._reference
        if reference is not None:
            parts.append(f"{progress.value / max(reference[0], 1e-300):.2%} of {reference[1]}")
        if math.isfinite(progress.bound):
            parts.append(f"bound {self._told_value(progress.bound)}")
            parts.append(f"gap {gap(progress.value, progress.bound):.2%}")
        return "   ".join(parts)

    @property
    def _verb(self) -> str:
        return "learnt" if self.mission.sight.unit == "bits" else "found"

    def _told_value(self, value: float) -> str:
        """Finer than in the end, so that progress shows."""
        return f"{value:.4%}" if self.mission.sight.unit == "probability" else amount(self.mission, value)

    @cached_property
    def _reference(self) -> tuple[float, str] | None:
        problem = self.mission.problem
        if self.mission.over_regions:
            return iterative_greedy(problem), "iterative greedy"
        return None if problem.drift is not None or self.mission.over_legs else (problem.teleport.value, "teleport")
