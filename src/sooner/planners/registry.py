"""Every planner by name, with when to choose it; nothing heavy is imported until one is made."""

from __future__ import annotations

from dataclasses import dataclass, field
from importlib import import_module
from typing import Any

from sooner.errors import UnsupportedProblemError
from sooner.planners.planner import Planner

__all__ = ["DEFAULT", "PLANNERS", "Entry", "make_planner"]


@dataclass(frozen=True)
class Entry:
    """One planner: where its class lives, when to choose it, what to cite, and settings that make the variant.

    Parameters
    ----------
    path : str                "module:Class"
    when : str                one sentence for someone who has to choose
    cites : tuple of str      keys of the bibliography
    settings : dict           arguments of the class
    """

    path: str
    when: str
    cites: tuple[str, ...] = ()
    settings: dict[str, Any] = field(default_factory=dict)

    def make(self, **settings: Any) -> Planner:
        """The planner, with its own settings and then yours."""
        module, name = self.path.split(":")
        planner: Planner = getattr(import_module(module), name)(**{**self.settings, **settings})
        return planner


DEFAULT = "anneal"

PLANNERS: dict[str, Entry] = {
    "anneal": Entry(
        "sooner.planners.anneal:Anneal",
        "The default: best plans at any planning time from a second upwards.",
        ("Lin2014",),
    ),
    "topn": Entry(
        "sooner.planners.topn:TopN",
        "The paper's best: a third of a second, flies over the N best of k Gaussians, through all layers.",
        ("Lin2014",),
    ),
    "topn-one-layer": Entry(
        "sooner.planners.topn:TopN",
        "TopN in one layer, k = 5 and N = 3, for comparison with the paper's tables.",
        ("Lin2014",),
        {"layers": ((5, 3),)},
    ),
    "top2": Entry(
        "sooner.planners.top2:Top2",
        "Two hills, and the best split of the time between them, through all layers.",
        ("Lin2014",),
    ),
    "top2-one-layer": Entry(
        "sooner.planners.top2:Top2",
        "Top2 in one layer, k = 5, for comparison with the paper's tables.",
        ("Lin2014",),
        {"layers": (5,)},
    ),
    "lhc-gw-conv": Entry(
        "sooner.planners.global_warming:GlobalWarming",
        "Hill climbing with a rising ocean: good on maps with a few clear hills, a tenth of a second.",
        ("Lin2009", "Lin2014"),
    ),
    "bourgault": Entry(
        "sooner.planners.bourgault:Bourgault",
        "BA by the rule that fits the paper's tables; for comparison, on open square grids.",
        ("Bourgault2006", "Lin2014"),
    ),
    "greedy": Entry(
        "sooner.planners.greedy:Greedy",
        "A baseline: instant, one step ahead, stays on the hill where it starts.",
        ("Bourgault2006",),
    ),
}


def make_planner(name: str, **settings: Any) -> Planner:
    """The planner of that name.

    Raises
    ------
    UnsupportedProblemError    if there is none

    Examples
    --------
    >>> make_planner("greedy")
    Greedy()
    """
    if name not in PLANNERS:
        raise UnsupportedProblemError(f"planner {name!r} came; expected one of {', '.join(PLANNERS)}")
    return PLANNERS[name].make(**settings)
