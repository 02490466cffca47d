"""The classic search patterns as planners along legs: baselines, and what search manuals ask for."""

from sooner.planners.patterns.about_datum import ExpandingSquare, Sector
from sooner.planners.patterns.contour import Contour
from sooner.planners.patterns.lanes import CreepingLine, ParallelTrack
from sooner.planners.patterns.no_gap import NoGap

__all__ = ["Contour", "CreepingLine", "ExpandingSquare", "NoGap", "ParallelTrack", "Sector"]
