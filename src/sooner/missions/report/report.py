"""Everything that a report says of a judged plan, before it is put on a page."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import sooner
from sooner.bounds.bound import Bound
from sooner.errors import DataFormatError
from sooner.missions.flight_plans import Flights, flights
from sooner.missions.report.compared import Pattern, patterns
from sooner.missions.report.places import RichPlace, richest
from sooner.missions.report.proof import tightest
from sooner.missions.report.sheet import Sheet, sheets
from sooner.missions.score import Score, finite
from sooner.problem.incumbent import gap

__all__ = ["Report", "make_report"]


@dataclass(frozen=True, eq=False)
class Report:
    """A judged plan with all that is told of it.

    Parameters
    ----------
    score : Score
    bound : Bound or None           the tightest that was proved in time
    places : of RichPlace           the richest that the plan leaves
    patterns : of Pattern           the classic patterns on this mission, the best first
    sheets : of Sheet               one for each flight
    notes : of str                  what whoever reads it should know
    """

    score: Score
    bound: Bound | None
    places: tuple[RichPlace, ...]
    patterns: tuple[Pattern, ...]
    sheets: tuple[Sheet, ...]
    notes: tuple[str, ...]

    @property
    def gap(self) -> float | None:
        """Share of the bound that a better plan could win at most; None where nothing is proved."""
        return None if self.bound is None else finite(gap(self.score.evaluation.value, self.bound.value))

    @property
    def later_s(self) -> float:
        """How much longer than the judge counts the last flight takes, as take-offs wait for others."""
        flown = [sheet for sheet in self.sheets if sheet.flies]
        planned = max((sheet.legs_end_s - sheet.waits_s for sheet in flown), default=0.0)
        return max((sheet.legs_end_s for sheet in flown), default=0.0) - planned

    def result(self) -> dict[str, Any]:
        """One JSON object: the score's, and what the report adds."""
        bound = self.bound
        return self.score.result() | {
            "bound": None if bound is None else finite(bound.value),
            "bound_proof": None if bound is None else bound.proof,
            "bound_assumes": None if bound is None else bound.assumes,
            "gap": self.gap,
            "places": [place.result() for place in self.places],
            "patterns": [pattern.result() for pattern in self.patterns],
            "sheets": [_told(sheet) for sheet in self.sheets],
            "notes": list(self.notes),
            "version": sooner.__version__,
        }

    def html(self) -> bytes:
        """The page: nothing on it is fetched from anywhere, and nothing on it runs."""
        from sooner.missions.report.page import page

        return page(self).encode()


def _told(sheet: Sheet) -> dict[str, Any]:
    return {
        "name": sheet.name,
        "flies": sheet.flies,
        "waypoints": len(sheet.stops),
        "length_m": sheet.length_m,
        "departs_s": sheet.departs_s,
        "waits_s": sheet.waits_s,
        "duration_s": sheet.flying_s,
        "airborne_s": sheet.airborne_s,
    }


def make_report(score: Score, seconds: float = 10.0) -> Report:
    """Report of a judged plan.

    Parameters
    ----------
    seconds : float         for the bound and, along legs, for the patterns: half of it each
    """
    told, why = _flights(score)
    return Report(
        score,
        tightest(score, seconds / 2),
        richest(score),
        patterns(score.mission, seconds / 2),
        sheets(score, told),
        (*score.mission.notes, *why),
    )


def _flights(score: Score) -> tuple[Flights | None, tuple[str, ...]]:
    """The plan as aircraft fly it, or why it cannot be told so: a report is made of any plan."""
    try:
        return flights(score), ()
    except DataFormatError as error:
        fault = error.faults[0]
        return None, (f"sheets have no latitudes and longitudes: {fault.came} ({fault.key})",)
