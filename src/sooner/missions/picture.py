"""The picture of a planned mission."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from sooner.missions.planning import Planned

__all__ = ["plan_picture"]


def plan_picture(planned: Planned) -> bytes:
    """PNG: the flight over the map, and how the probability of having found the person grows."""
    from sooner.plotting import Caption, draw_plan

    score, best = planned.score, planned.solution.best
    mission = score.mission
    caption = Caption(
        name=mission.name,
        planner=planned.planner,
        bound=best.bound,
        bound_proof=best.bound_proof,
        step_s=mission.step_s,
        cell_m=mission.cell_m,
    )
    return draw_plan(score.evaluation, score.plan, mission.belief.poc, mission.glimpse, caption)
