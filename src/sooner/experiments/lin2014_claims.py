"""What Lin and Goodrich say of their tables rather than in them, counted in ours.

Words are counted: "always" over nine cells is 9, "in most cases" is what their own tables give.
"""

from __future__ import annotations

import json
from collections.abc import Iterable, Iterator, Mapping
from math import erf, sqrt
from pathlib import Path
from typing import Any

__all__ = ["TABLES", "author_gaussians", "claims", "ratios_of_author"]

Values = Mapping[tuple[str, str, str], float]
Claim = tuple[str, str, str, float]

STEPS = ("300", "600", "900")
TABLES = {"Table I": "HikerPaul", "Table II": "NewYork53", "Table III": "NewYork108"}
GREEDY = ("BA", "LHC-GW-CONV")
BOTH = ("Top2", "TopN")
LAYER = ("Top2 (1 layer)", "TopN (1 layer)")
HIERARCHY = ("Top2 (Hierarchy)", "TopN (Hierarchy)")


def claims(value: Values, spread: Mapping[str, float], data: Path) -> Iterator[Claim]:
    """Table, row, column and value of every claim.

    Parameters
    ----------
    value : mapping            what the tables hold, by table, row and column
    spread : mapping           largest standard deviation of each real scenario
    data : Path                folder of the authors' maps
    """
    for table, instance in TABLES.items():
        yield table, "all rows", "standard deviation below", spread[instance]
    ratios = sorted(ratios_of_author(data), reverse=True)
    for rank, ratio in enumerate(ratios, 1):
        yield "Fig. 12", f"rank {rank}", "Mode Goodness Ratio", ratio
    yield from _ranks(value)
    yield from _synthetic(value)
    yield from _real(value)
    yield from _times(value)
    yield "Text", "volume within three standard deviations", "%", 100.0 * erf(3.0 / sqrt(2.0)) ** 2


def author_gaussians(data: Path) -> list[dict[str, Any]]:
    """The five Gaussians that the author fitted to HikerPaul at T = 900 [Lin2014, Fig. 12], as he stored them."""
    path = data / "hikerpaul_T900_author_gmm_k5.json"
    found: list[dict[str, Any]] = json.loads(path.read_text(encoding="utf-8"))["gaussians"]
    return found


def ratios_of_author(data: Path) -> list[float]:
    """Mode Goodness Ratio of each of the author's Gaussians with respect to his first [Lin2014, eq. (20)]."""
    raise NotImplementedError


def _ranks(value: Values) -> Iterator[Claim]:
    """Fig. 17: who has collected most by T = 900 on NewYork53."""
    order = sorted((*GREEDY, *HIERARCHY), key=lambda name: -value["Table II", name, "900"])
    yield "Fig. 17", "TopN", "rank at T = 900", order.index("TopN (Hierarchy)") + 1
    yield "Fig. 17", "Top2", "rank at T = 900", order.index("Top2 (Hierarchy)") + 1


def _synthetic(value: Values) -> Iterator[Claim]:
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


def _real(value: Values) -> Iterator[Claim]:
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


def _times(value: Values) -> Iterator[Claim]:
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
