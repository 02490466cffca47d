"""Pictures of beliefs, plans and curves; nothing imports this room at start-up."""

from sooner.plotting.plan_picture import Caption, draw_plan

__all__ = ["Caption", "draw_plan"]
