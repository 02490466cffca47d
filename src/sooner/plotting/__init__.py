"""Pictures of beliefs, plans, curves and studies; nothing imports this room at start-up."""

from sooner.plotting.plan_picture import Caption, draw_plan
from sooner.plotting.summary_picture import Sample, plot_summary

__all__ = ["Caption", "Sample", "draw_plan", "plot_summary"]
