"""Pictures of beliefs, plans, curves and studies; nothing imports this room at start-up."""

from sooner.plotting.leg_picture import draw_leg_plan
from sooner.plotting.measure import BITS, PROBABILITY, TARGETS, Measure
from sooner.plotting.plan_picture import Caption, draw_plan
from sooner.plotting.region_picture import Ground, draw_region_plan
from sooner.plotting.summary_picture import Sample, plot_summary

__all__ = [
    "BITS",
    "PROBABILITY",
    "TARGETS",
    "Caption",
    "Ground",
    "Measure",
    "Sample",
    "draw_leg_plan",
    "draw_plan",
    "draw_region_plan",
    "plot_summary",
]
