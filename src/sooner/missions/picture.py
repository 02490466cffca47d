"""The picture of a planned mission."""

from __future__ import annotations

from math import nan
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from sooner.missions.planning import Planned

__all__ = ["plan_picture"]


def plan_picture(planned: Planned) -> bytes:
    """PNG: the flight over the map, and how what it collects grows."""
    from sooner.plotting import BITS, PROBABILITY, TARGETS, Caption, Ground, draw_leg_plan, draw_plan, draw_region_plan

    score, best = planned.score, planned.solution.best
    mission = score.mission
    caption = Caption(
        name=mission.name,
        planner=planned.planner,
        bound=best.bound,
        bound_proof=best.bound_proof,
        step_s=mission.step_s,
        cell_m=mission.cell_m,
        measure={"probability": PROBABILITY, "bits": BITS, "targets": TARGETS}[mission.sight.unit],
        reference=score.reference[0] if score.reference else nan,
        reference_name=score.reference[1] if score.reference else "",
    )
    there = np.where(mission.problem.grid.passable, np.ravel(mission.sight.there), 0.0)
    if mission.over_regions:
        return draw_region_plan(score.evaluation, score.plan, Ground(there, score.looks, score.left), caption)
    if mission.over_legs:
        return draw_leg_plan(score.evaluation, score.plan, Ground(there, score.looks, score.left), caption)
    shown = there.reshape(mission.problem.grid.shape) if mission.belief is None else mission.sight.there
    return draw_plan(score.evaluation, score.plan, shown, mission.glimpse, caption)
