"""What Lin and Goodrich say of their tables rather than in them, counted in ours.

Words are counted: "always" over nine cells is 9, "in most cases" is what their own tables give.
"""

from __future__ import annotations

import json
from collections.abc import Iterable, Iterator, Mapping
from contextlib import suppress
from dataclasses import dataclass
from math import erf, sqrt
from pathlib import Path
from typing import Any

import numpy as np
from numpy.random import Generator
from numpy.typing import NDArray

from sooner.belief.mixture import Mixture
from sooner.campaigns.run import Ran
from sooner.campaigns.study import Study
from sooner.decomposition import modes
from sooner.experiments.lin2014.maps import posed
from sooner.planners import Planner, solve
from sooner.planners.hill_climb import Field, directions
from sooner.planners.mode_goodness import match_modes, mode_goodness
from sooner.planners.top2 import Top2
from sooner.planners.topn import TopN

__all__ = ["WITHOUT_CHANCE", "author_gaussians", "claims", "ratios_of_author"]

Values = Mapping[tuple[str, str, str], float]
Counted = tuple[str, str, str, float]
Claim = tuple[str, str, str, float, int]

STEPS = ("300", "600", "900")
TABLES = {"Table I": "HikerPaul", "Table II": "NewYork53", "Table III": "NewYork108"}
WITHOUT_CHANCE = ("Fig. 12", "Study author's Gaussians, HikerPaul")
GREEDY = ("BA", "LHC-GW-CONV")
BOTH = ("Top2", "TopN")
LAYER = ("Top2 (1 layer)", "TopN (1 layer)")
HIERARCHY = ("Top2 (Hierarchy)", "TopN (Hierarchy)")


def claims(ran: Ran, study: Study, value: Values, data: Path) -> Iterator[Claim]:
    """Table, row, column, value and number of trials of every claim whose tables were run.

    Parameters
    ----------
    value : mapping            what the tables hold, by table, row and column
    data : Path                folder of the authors' maps
    """
    trials = max((len(seeds) for case, seeds in ran.asked.cases if not case.alone), default=0)
    timed = max((len(seeds) for case, seeds in ran.asked.cases if case.alone), default=0)
    for table, row, column, claimed in _claims(_spread(ran, study), value, data):
        n = 1 if table in WITHOUT_CHANCE else timed if "Speed" in table else trials
        yield table, row, column, claimed, n


def _spread(ran: Ran, study: Study) -> dict[str, float]:
    """Largest standard deviation of Efficiency_LB over the cells that the paper prints of a map, as a fraction."""
    widest: dict[str, float] = {}
    for case, found in ran.results().items():
        if case.planner in study.file.paper["printed"] and len(found) and not case.alone:
            deviation = float(np.std(found.measures["efficiency"] / 100.0))
            widest[case.instance] = max(widest.get(case.instance, 0.0), deviation)
    return widest


def _claims(spread: Mapping[str, float], value: Values, data: Path) -> Iterator[Counted]:
    for table, instance in TABLES.items():
        if instance in spread:
            yield table, "all rows", "standard deviation below", spread[instance]
    ratios = sorted(ratios_of_author(data), reverse=True)
    for rank, ratio in enumerate(ratios, 1):
        yield "Fig. 12", f"rank {rank}", "Mode Goodness Ratio", ratio
    yield "Text", "volume within three standard deviations", "%", 100.0 * erf(3.0 / sqrt(2.0)) ** 2
    yield from _with_author_gaussians(data)
    for part in (_ranks, _synthetic, _real, _times):
        with suppress(KeyError):  # a table that was not run
            yield from part(value)


def author_gaussians(data: Path) -> list[dict[str, Any]]:
    """The five Gaussians that the author fitted to HikerPaul at T = 900 [Lin2014, Fig. 12], as he stored them."""
    path = data / "hikerpaul_T900_author_gmm_k5.json"
    found: list[dict[str, Any]] = json.loads(path.read_text(encoding="utf-8"))["gaussians"]
    return found


def ratios_of_author(data: Path) -> list[float]:
    """Mode Goodness Ratio of each of the author's Gaussians with respect to his first [Lin2014, eq. (20)]."""
    (field,) = directions(posed(data, "hikerpaul", (50, 50), 900))
    _, goodness = _Stored(_author_mixture(data)).judged(field)
    return [float(ratio) for ratio in goodness / goodness[0]]


def _author_mixture(data: Path) -> Mixture:
    stored = author_gaussians(data)
    weights, means, covariances = (np.array([each[key] for each in stored]) for key in ("weight", "mean", "cov"))
    return Mixture(weights, means, covariances)


@dataclass(frozen=True)
class _Stored:
    """Ranks hills as `ModeGoodness` does, by a mixture that is given instead of fitted."""

    mixture: Mixture

    def judged(self, field: Field) -> tuple[NDArray[np.int64], NDArray[np.float64]]:
        """The mode of each Gaussian, and its goodness."""
        matched = match_modes(field, self.mixture, modes(field.grid, field.surface.ravel()))
        return matched, mode_goodness(self.mixture, field.steps_from_start[matched], field.budget)

    def ranked(self, field: Field, k: int, rng: Generator) -> NDArray[np.int64]:
        """Cells of the modes, best first."""
        cells, goodness = self.judged(field)
        return cells[np.argsort(-goodness, kind="stable")]


def _with_author_gaussians(data: Path) -> Iterator[Counted]:
    """What one layer gives where nothing is left to chance in the mixture: HikerPaul with the author's own."""
    goodness: Any = _Stored(_author_mixture(data))
    top2, topn = Top2(layers=(5,), goodness=goodness), TopN(layers=((5, 3),), goodness=goodness)
    planners: dict[str, Planner] = dict(zip(LAYER, (top2, topn), strict=True))
    for steps in STEPS:
        problem = posed(data, "hikerpaul", (50, 50), int(steps))
        for name, planner in planners.items():
            value = solve(problem, planner).best.value
            yield WITHOUT_CHANCE[1], name, steps, 100.0 * value / problem.teleport.value


def _ranks(value: Values) -> Iterator[Counted]:
    """Fig. 17: who has collected most by T = 900 on NewYork53."""
    order = sorted((*GREEDY, *HIERARCHY), key=lambda name: -value["Table II", name, "900"])
    yield "Fig. 17", "TopN", "rank at T = 900", order.index("TopN (Hierarchy)") + 1
    yield "Fig. 17", "Top2", "rank at T = 900", order.index("Top2 (Hierarchy)") + 1


def _synthetic(value: Values) -> Iterator[Counted]:
    left, right = (
        {name: value["Table IV", f"Start from {corner}", name] for name in (*GREEDY, *BOTH)}
        for corner in ("upper left", "lower right")
    )
    ended = value["Fig. 18", "LHC-GW-CONV, end at upper left", "900"]
    greedy_above = sum(left["LHC-GW-CONV"] > left[name] for name in BOTH)
    yield "Text", "upper left: LHC-GW-CONV above Top2 and TopN", "comparisons of 2", greedy_above
    new_above = sum(right[name] > right[greedy] for name in BOTH for greedy in GREEDY)
    yield "Text", "lower right: Top2 and TopN above BA and LHC-GW-CONV", "comparisons of 4", new_above
    yield "Text", "lower right: LHC-GW-CONV with end above Top2", "comparisons of 1", int(ended > right["Top2"])
    yield "Text", "lower right: TopN above LHC-GW-CONV with end", "comparisons of 1", int(right["TopN"] > ended)


def _real(value: Values) -> Iterator[Counted]:
    def above(better: Iterable[str], worse: Iterable[str]) -> int:
        """Cells of nine in which each of the first is above each of the second."""
        return sum(
            min(value[table, name, steps] for name in better) > max(value[table, name, steps] for name in worse)
            for table in TABLES
            for steps in STEPS
        )

    for layers, names in (("1 layer", LAYER), ("Hierarchy", HIERARCHY)):
        yield "Text", f"Top2 and TopN ({layers}) above BA and LHC-GW-CONV", "cells of 9", above(names, GREEDY)
    for name, one, many in zip(BOTH, LAYER, HIERARCHY, strict=True):
        yield "Text", f"{name} (Hierarchy) above 1 layer", "cells of 9", above([many], [one])
    top2, topn = HIERARCHY
    yield "Text", "TopN (Hierarchy) above Top2 (Hierarchy)", "cells of 9", above([topn], [top2])
    short = value["Table III", top2, "300"] > value["Table III", topn, "300"]
    row = "NewYork108, T = 300: Top2 (Hierarchy) above TopN (Hierarchy)"
    yield "Text", row, "comparisons of 1", int(short)


def _times(value: Values) -> Iterator[Counted]:
    def longest(table: str, *names: str) -> float:
        return max(value[f"{table} Speed", name, steps] for name in names for steps in STEPS)

    def beaten(table: str, quick: str, slow: str) -> int:
        times = f"{table} Speed"
        return sum(value[times, quick, steps] < value[times, slow, steps] for steps in STEPS)

    text = "Text Speed"
    faster = sum(beaten("Table I", name, "LHC-GW-CONV") for name in LAYER)
    yield text, "HikerPaul: Top2 and TopN (1 layer) faster than LHC-GW-CONV", "comparisons of 6", faster
    yield text, "HikerPaul: Top2 and TopN (Hierarchy)", "seconds within", longest("Table I", *HIERARCHY)
    yield text, "NewYork53: Top2 and TopN (1 layer)", "seconds within", longest("Table II", *LAYER)
    yield text, "NewYork108: Top2 and TopN (1 layer)", "seconds about", longest("Table III", *LAYER)
    for table, instance in (("Table II", "NewYork53"), ("Table III", "NewYork108")):
        for name in HIERARCHY:
            yield text, f"{instance}: {name}", "seconds about", longest(table, name)
    fastest = sum(
        value[f"{table} Speed", "LHC-GW-CONV", steps]
        < min(value[f"{table} Speed", name, steps] for name in (*LAYER, *HIERARCHY))
        for table in ("Table II", "Table III")
        for steps in STEPS
    )
    yield text, "NewYork53 and NewYork108: LHC-GW-CONV fastest", "cells of 6", fastest
    row = "LHC-GW-CONV, end at upper left"
    yield "Fig. 18 Speed", row, "seconds below", value["Fig. 18 Speed", row, "900"]
