"""What Kuhlman et al. say in Table 1 and in the text, counted in ours."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from contextlib import suppress
from math import pi, sqrt
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from sooner.belief.information import information_table
from sooner.campaigns.results import Results
from sooner.campaigns.run import Ran
from sooner.campaigns.study import Study
from sooner.decomposition import boustrophedon
from sooner.experiments.kuhlman2017.ground import DETECT, FALSE_ALARM, STARTS, environment
from sooner.scenarios.natural import EXPERIMENT_2_CELLS
from sooner.sensors import Camera

__all__ = ["KINDS", "PRIORS", "claims", "lost", "region_counts", "sizes", "tenfold"]

Claim = tuple[str, str, str, float, int]
Values = Mapping[tuple[str, str, str], float]

KINDS = ("low", "med", "high", "vhf")
PRIORS = {"Table 2": "uniform", "Table 3": "nonuniform"}
COUNTED = 40  # environments of each kind [Kuhlman2017, sec. 6.2]
TENFOLD = "Beyond: quality against the number of cells"


def claims(ran: Ran, study: Study, value: Values, data: Path) -> Iterator[Claim]:
    """Table, row, column, value and number of trials of every claim; those of tables that were not run are left out.

    Parameters
    ----------
    value : mapping            what the tables hold, by table, row and column
    """
    yield from _table_1()
    yield from _regions()
    yield from _blur()
    results = {(case.instance, case.planner): found for case, found in ran.results().items()}
    for part in (_experiment_1, _experiment_2, _quality):
        with suppress(KeyError):  # a table that was not run
            yield from part(results)
    if ("Table 2 Speed", "vhf uniform", "eps-B&B final time") in value:  # other tables fly a part of these trials
        yield from _times(results)
    with suppress(KeyError):
        yield from _against_dfs(value, max((len(found.seeds) for found in results.values()), default=0))


def _table_1() -> Iterator[Claim]:
    table = information_table(0.5, 2, 2, 3, DETECT, FALSE_ALARM)
    for q in (1, 2, 3):
        for hits in range(3):
            for misses in range(3):
                bits = float(table[misses, hits, q])
                yield "Table 1", f"info (q = {q})", f"nz0 = {misses}, nz1 = {hits}", bits, 1


def region_counts(kind: str) -> NDArray[np.int64]:
    """Regions in each of the first 40 environments of a kind."""
    return np.array([boustrophedon(environment(kind, number + 1).grid).n_regions for number in range(COUNTED)])


def _regions() -> Iterator[Claim]:
    for kind in KINDS:
        counts = region_counts(kind)
        yield "Regions", kind, "mean", float(counts.mean()), COUNTED
        yield "Regions", kind, "standard deviation", float(counts.std(ddof=1)), COUNTED


def _blur() -> Iterator[Claim]:
    """The examples of section 6.3, on the short side of 1200 pixels; the second as printed, and as it must be meant."""
    camera = Camera(pi / 2, 1200, 2e-3)
    for speed, height in ((10, 10), (20, 5), (5, 20)):
        row = f"motion blur at {speed} m/s, {height} m, 2 ms"
        yield "Text", row, "pixels", float(camera.blur(speed, height)), 1


def lost(better: Results, worse: Results) -> float:
    """Percent of information that one collects less than the other, over the seeds where both have a plan."""
    _, ours, theirs = np.intersect1d(better.seeds, worse.seeds, return_indices=True)
    bits, less = better.measure("bits")[ours], worse.measure("bits")[theirs]
    both = ~np.isnan(bits) & ~np.isnan(less)
    return float(100.0 * np.mean(1.0 - less[both] / bits[both])) if both.any() else 0.0


def _experiment_1(results: Mapping[tuple[str, str], Results]) -> Iterator[Claim]:
    def found(alpha: str, eta: str) -> Results:
        return results["low uniform", f"alpha {alpha}, eta {eta} %"]

    full, impatient, kept = found("0.9", "0"), found("0.9", "1"), found("0.8", "0.5")
    n = len(full.seeds)
    share = 100.0 * impatient.measure("expanded").mean() / full.measure("expanded").mean()
    yield "Text", "alpha 0.9: nodes with eta 1 % of those with eta 0", "%", float(share), n
    yield "Text", "alpha 0.9, eta 1 %: information lost", "% within", lost(full, impatient), n
    yield "Text", "eta 0.5 %: information lost", "% within", lost(found("0.8", "0"), kept), n
    for name, exact in (("0.9, eta 1 %", impatient), ("0.8, eta 0.5 %", kept)):
        best = results["low uniform", "anneal 2 s"]
        yield "Beyond: lost against anneal in 2 s", f"alpha {name}", "%", lost(best, exact), len(best.seeds)


def sizes(prefix: str = "") -> list[str]:
    """Names of the instances of Experiment 2, from few cells to many."""
    return [f"{prefix}{cells:,} cells" for cells in EXPERIMENT_2_CELLS]


def _experiment_2(results: Mapping[tuple[str, str], Results]) -> Iterator[Claim]:
    found = [results[name, "DFS, 10 environments"] for name in sizes()]
    budgets = np.concatenate([each.measure("t_max") for each in found])
    regions = [float(each.measure("regions").mean()) for each in found]
    n = len(budgets)
    yield "Text", "Experiment 2: T_max, mean", "s", float(budgets.mean()), n
    yield "Text", "Experiment 2: T_max, standard deviation", "s", float(budgets.std(ddof=1)), n
    factor = EXPERIMENT_2_CELLS[-1] / EXPERIMENT_2_CELLS[0]
    yield "Text", "Experiment 2: cells vary by a factor of", "factor", factor, n
    yield "Text", "Experiment 2: regions vary by a factor of", "factor", max(regions) / min(regions), n


def _quality(results: Mapping[tuple[str, str], Results]) -> Iterator[Claim]:
    """What ten times the cells do to plans of Experiment 2: theirs fall, by how much the paper does not print."""
    for prefix, reading in (("", "centres in reach"), ("wide ", "any part in reach")):
        for planner in ("eps-B&B", "DFS"):
            found = [results[name, f"{planner}, 10 environments"] for name in sizes(prefix)]
            for measure, whole in (("info", "reference"), ("proved", "bound")):
                each = tenfold(found, measure)
                if len(each) < 2:
                    return
                row = f"{planner}, {reading}, % of the {whole}"
                error = float(each.std(ddof=1)) / sqrt(len(each))
                yield TENFOLD, row, "points for ten times the cells", float(each.mean()), len(each)
                yield TENFOLD, row, "standard error", error, len(each)


def tenfold(found: Sequence[Results], measure: str) -> NDArray[np.float64]:
    """(environments,) float: by how much a measure rises for ten times the cells, by least squares over all sizes.

    Parameters
    ----------
    found : (7,) of Results    of one planner, from few cells to many; seeds that some of them lack are left out
    """
    seeds = np.array(sorted(set.intersection(*(set(each.seeds) for each in found))), np.int64)
    values = np.array([each.measure(measure)[np.isin(each.seeds, seeds)] for each in found])
    seeds, values = seeds[known := ~np.isnan(values).any(axis=0)], values[:, known]
    decades = np.log10(EXPERIMENT_2_CELLS)
    decades -= decades.mean()
    slopes = decades @ values / (decades @ decades)
    return np.array([slopes[seeds // STARTS == number].mean() for number in np.unique(seeds // STARTS)])


def _against_dfs(value: Values, n: int) -> Iterator[Claim]:
    """Means of what Tables 2 and 3 print, over their rows, as the paper's own sums give its claims."""

    def mean(table: str, column: str) -> float:
        return float(np.mean([value[table, f"{kind} {PRIORS[table]}", column] for kind in KINDS]))

    info = [sum(mean(table, column) for table in PRIORS) for column in ("eps-B&B final info", "DFS info")]
    yield "Text", "eps-B&B above DFS, information", "%", 100.0 * (info[0] / info[1] - 1.0), n
    for table, prior in PRIORS.items():
        rates = [
            value[table, f"{kind} {prior}", "DFS effort"] / value[table, f"{kind} {prior}", "eps-B&B effort"]
            for kind in KINDS
        ]
        yield "Text", f"eps-B&B above DFS, search rate, {prior}", "%", 100.0 * (float(np.mean(rates)) - 1.0), n


def _times(results: Mapping[tuple[str, str], Results]) -> Iterator[Claim]:
    found = results["vhf uniform", "eps-B&B"]
    first, whole, n = found.measure("timing.first_s"), found.measure("timing.cpu_seconds"), len(found.seeds)
    row = "vhf uniform: first solutions within 4.5 min"
    yield "Text Speed", row, "% around", 100.0 * float(np.mean(first <= 270.0)), n
    row = "vhf uniform: trials that end around 24 min"
    yield "Text Speed", row, "% about", 100.0 * float(np.mean(whole <= 24 * 60.0)), n
