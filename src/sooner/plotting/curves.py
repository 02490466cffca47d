"""The curve of what a plan collects beside what teleporting would find, and the bound that no flight passes."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from sooner.errors import UnsupportedProblemError
from sooner.plotting.measure import PROBABILITY, Measure
from sooner.plotting.style import BOUND, GREY, INK, VALUE
from sooner.problem import Evaluation

if TYPE_CHECKING:
    from matplotlib.axes import Axes

__all__ = ["draw_curve"]


def draw_curve(
    axes: Axes,
    evaluation: Evaluation,
    bound: float = np.inf,
    step_s: float | None = None,
    measure: Measure = PROBABILITY,
    reference: tuple[float, str] | None = None,
) -> None:
    """Draw how the probability of having found the person grows, or whatever else the plan collects."""
    from matplotlib.ticker import MaxNLocator

    unit = step_s / 60.0 if step_s else 1.0
    times, cdp = evaluation.times * unit, evaluation.cdp * measure.factor
    top, end = float(cdp[-1]), float(times[-1])
    try:
        teleport = evaluation.problem.teleport
        looks_a_step = len(evaluation.problem.searchers)
        when = (teleport.delay + np.arange(len(teleport.curve)) // looks_a_step) * unit
        axes.plot(
            when,
            teleport.curve * measure.factor,
            color=GREY,
            lw=1.2,
            ls=(0, (1, 1.5)),
            label="if it could teleport",
            zorder=2,
        )
        top = max(top, measure.factor * teleport.value)
        end = max(end, float(when[-1]) if len(when) else 0.0)
    except UnsupportedProblemError:
        pass
    axes.fill_between(times, cdp, color=VALUE, alpha=0.12, lw=0, zorder=1)
    axes.plot(times, cdp, color=VALUE, lw=2.4, label="this flight", zorder=3)
    target = evaluation.problem.objective.target
    if target is not None:
        axes.axhline(measure.factor * target, color=GREY, lw=1.0, label="the target")
        if np.isfinite(bound):
            axes.axvline(-bound * unit, color=BOUND, lw=1.4, ls="--", label="no flight is earlier")
    elif np.isfinite(bound):
        top = max(top, measure.factor * bound)
        axes.axhline(measure.factor * bound, color=BOUND, lw=1.4, ls="--", label="proven bound", zorder=2)
    if reference is not None:
        axes.axhline(measure.factor * reference[0], color=GREY, lw=1.2, ls=(0, (1, 1.5)), label=reference[1], zorder=2)
        top = max(top, measure.factor * reference[0])
    axes.set_xlim(0, max(end, 1e-9))
    axes.set_ylim(0, top * 1.08 if top > 0 else 1.0)
    axes.set_title(measure.curve, fontsize=10.5, loc="left", color=INK, pad=8)
    axes.set_xlabel("minutes into the flight" if step_s else "steps into the flight", fontsize=9)
    axes.xaxis.set_major_locator(MaxNLocator(steps=[1, 2, 5, 10], integer=True))
    axes.tick_params(labelsize=8.5, length=0)
    axes.grid(color="#e5e7eb", lw=0.7)
    axes.set_axisbelow(True)
    for side in ("top", "right", "left"):
        axes.spines[side].set_visible(False)
    axes.legend(loc="lower right", fontsize=8.5, frameon=False)
