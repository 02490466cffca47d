"""Every planner by name, with when to choose it; nothing heavy is imported until one is made."""

from __future__ import annotations

from dataclasses import dataclass, field, fields
from importlib import import_module
from typing import Any

from sooner.errors import UnsupportedProblemError
from sooner.planners.by_moves import ByMoves
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
    moves : tuple of str      of "cells", "regions" and "legs": what it plans
    regions, legs : str       "module:Class" that plans moves over regions or along legs, where `path` plans those over
                              cells only
    """

    path: str
    when: str
    cites: tuple[str, ...] = ()
    settings: dict[str, Any] = field(default_factory=dict)
    moves: tuple[str, ...] = ("cells",)
    regions: str = ""
    legs: str = ""

    def make(self, **settings: Any) -> Planner:
        """The planner, with its own settings and then yours; of several classes each takes the settings that it has."""
        chosen, first = {**self.settings, **settings}, _loaded(self.path)
        others = {name: _loaded(path) for name, path in (("regions", self.regions), ("legs", self.legs)) if path}
        if not others:
            planner: Planner = first(**chosen)
            return planner
        known = {name: {each.name for each in fields(kind)} for name, kind in others.items()}
        elsewhere = set().union(*known.values()) - {each.name for each in fields(first)}
        over_cells = first(**{key: value for key, value in chosen.items() if key not in elsewhere})
        made = {
            name: kind(**{key: value for key, value in chosen.items() if key in known[name]})
            for name, kind in others.items()
        }
        return ByMoves(over_cells, **made)


def _loaded(path: str) -> Any:
    module, name = path.split(":")
    return getattr(import_module(module), name)


DEFAULT = "anneal"

PLANNERS: dict[str, Entry] = {
    "anneal": Entry(
        "sooner.planners.anneal:Anneal",
        "The default, over cells and regions and along legs: best plans at any planning time from a second upwards.",
        ("Lin2014", "Kuhlman2017"),
        moves=("cells", "regions", "legs"),
        regions="sooner.planners.region_anneal:RegionAnneal",
        legs="sooner.planners.leg_anneal:LegAnneal",
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
        "A baseline, over cells and regions: instant, one step ahead, stays on the hill where it starts.",
        ("Bourgault2006", "Kuhlman2017"),
        moves=("cells", "regions"),
        regions="sooner.planners.region_greedy:RegionGreedy",
    ),
    "exact": Entry(
        "sooner.planners.exact:Exact",
        "Over regions: you want proof. The optimum of up to some 25 regions in a minute, else as near as time allows.",
        ("Kuhlman2017", "Huangfu2018"),
        moves=("regions",),
    ),
    "eps-branch-and-bound": Entry(
        "sooner.planners.branch_and_bound:BranchAndBound",
        "Over regions: the paper's best, best-first and impatient; 6000 iterations, in a second or less.",
        ("Kuhlman2017",),
        moves=("regions",),
    ),
    "df-branch-and-bound": Entry(
        "sooner.planners.branch_and_bound:DepthFirstBranchAndBound",
        "Over regions: branch and bound last in, first out; for comparison with the paper's tables.",
        ("Kuhlman2017",),
        moves=("regions",),
    ),
    "beam-stack": Entry(
        "sooner.planners.beam_stack:BeamStack",
        "Over regions: branch and bound in little memory, for very long flights over many regions.",
        ("Kuhlman2017", "Zhou2005"),
        moves=("regions",),
    ),
    "depth-first": Entry(
        "sooner.planners.depth_first:DepthFirst",
        "Over regions: a baseline, instant; covers all ground in turn, several times over.",
        ("Kuhlman2017",),
        moves=("regions",),
    ),
    "parallel-track": Entry(
        "sooner.planners.patterns:ParallelTrack",
        "Along legs: the search manuals' baseline; even coverage of ground where the person may be anywhere.",
        ("IAMSAR2019",),
        moves=("legs",),
    ),
    "creeping-line": Entry(
        "sooner.planners.patterns:CreepingLine",
        "Along legs: a baseline; as parallel-track, but one end of the ground is searched first.",
        ("IAMSAR2019",),
        moves=("legs",),
    ),
    "expanding-square": Entry(
        "sooner.planners.patterns:ExpandingSquare",
        "Along legs: a baseline; outwards from the likeliest place, where that is known closely.",
        ("IAMSAR2019",),
        moves=("legs",),
    ),
    "sector": Entry(
        "sooner.planners.patterns:Sector",
        "Along legs: a baseline; over and over the likeliest place, where that is known very closely.",
        ("IAMSAR2019",),
        moves=("legs",),
    ),
    "contour": Entry(
        "sooner.planners.patterns:Contour",
        "Along legs: a baseline for steep ground whose elevation is given; from the top down along contour lines.",
        ("IAMSAR2019",),
        moves=("legs",),
    ),
    "no-gap": Entry(
        "sooner.planners.patterns:NoGap",
        "Along legs: you must say that the ground was searched; nothing is left unseen while the batteries last.",
        moves=("legs",),
    ),
}


def make_planner(name: str, **settings: Any) -> Planner:
    """The planner of that name.

    Raises
    ------
    UnsupportedProblemError    if there is none

    Examples
    --------
    >>> make_planner("greedy"), make_planner("depth-first")
    (ByMoves(cells=Greedy(), regions=RegionGreedy(), legs=None), DepthFirst())
    """
    if name not in PLANNERS:
        raise UnsupportedProblemError(f"planner {name!r} came; expected one of {', '.join(PLANNERS)}")
    return PLANNERS[name].make(**settings)
