"""Shares of nodes and of targets detected with time, from the answers of the trials."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from sooner.campaigns.run import Ran
from sooner.experiments.wolek2020.flight import SAMPLES
from sooner.experiments.wolek2020.scenes import SIMULATED_S

__all__ = ["Curves"]


@dataclass(frozen=True)
class Curves:
    """What trials of 240 s had detected at each of `times`, all maps in one.

    Methods raise KeyError where a planner was not flown on one of the places.
    """

    ran: Ran

    @property
    def times(self) -> NDArray[np.float64]:
        """(K,) float: shares of the mission, 0 to 1."""
        return np.linspace(0.0, 1.0, SAMPLES + 1)

    def nodes(self, planner: str, places: Sequence[str]) -> NDArray[np.float64]:
        """(trials, K) float: the share of nodes detected."""
        return np.array([answer["nodes"] for answer in self._answers(planner, places)])

    def targets(self, planner: str, places: Sequence[str]) -> NDArray[np.float64]:
        """(K,) float: the share of trials in which the target is detected."""
        answers = self._answers(planner, places)
        found = np.array([np.inf if answer["found_s"] is None else answer["found_s"] for answer in answers])
        shares: NDArray[np.float64] = (found[:, None] <= self.times * SIMULATED_S).mean(axis=0)
        return shares

    def _answers(self, planner: str, places: Sequence[str]) -> list[dict[str, object]]:
        cases = {case.instance: case for case, _ in self.ran.asked.cases if case.planner == planner and not case.budget}
        answers = [answer for place in places for answer in self.ran.answers(cases[place])]
        if not answers:
            raise KeyError(planner)
        return answers
