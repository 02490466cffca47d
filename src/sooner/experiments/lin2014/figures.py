"""The figures of Lin and Goodrich 2014, drawn again from what the study ran.

Figures 6 and 8 are pseudo-code; figure 9 is satellite imagery that is not at hand, so its vegetation classes, the
task difficulty map, are drawn instead.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from pathlib import Path
from typing import TYPE_CHECKING

from sooner.campaigns.run import Ran
from sooner.campaigns.study import Study
from sooner.experiments.figures import draw_all, panels
from sooner.experiments.lin2014.figure_parts import Flown, draw_difficulty, draw_paths, draw_three_maps, mark, surfaces
from sooner.experiments.lin2014.figures_of_methods import figure_1, figure_5, figure_7, figure_12

if TYPE_CHECKING:
    from matplotlib.figure import Figure

__all__ = ["draw_figures"]

NAMES = {"BA": "BA", "LHC-GW-CONV": "LHC-GW-CONV", "Top2": "Top2 (Hierarchy)", "TopN": "TopN (Hierarchy)"}
CURVES = {"TopN": ("black", "-"), "Top2": ("#2166ac", "--"), "LHC-GW-CONV": ("#b35806", "--"), "BA": ("#7f7f7f", "-.")}


def draw_figures(ran: Ran, study: Study, data: Path) -> Iterator[tuple[str, bytes]]:
    """Draw every figure that the data allow: the name of a small PNG file, and what it holds."""
    yield from draw_all(FIGURES, Flown(study, data, ran))


def figure_2(flown: Flown) -> Figure:
    """The synthetic scenario."""
    return draw_three_maps(flown.problem("upper left"))


def figure_3(flown: Flown) -> Figure:
    """BA and LHC-GW-CONV from the upper left."""
    return draw_paths(flown, [(name, "upper left", name) for name in ("BA", "LHC-GW-CONV")])


def figure_4(flown: Flown) -> Figure:
    """BA and LHC-GW-CONV from the lower right."""
    return draw_paths(flown, [(name, "lower right", name) for name in ("BA", "LHC-GW-CONV")])


def figure_9(flown: Flown) -> Figure:
    """Vegetation at Grayson Highlands, from the difficulty map: the satellite image is not at hand."""
    figure, (axes,) = panels(1, 1, 3.4, 2.9)
    problem = flown.problem("HikerPaul")
    draw_difficulty(figure, axes, surfaces(problem)[1], "HikerPaul: vegetation, LKP at the centre")
    mark(axes, problem.searcher.start, "start")
    return figure


def _scenario(name: str) -> Callable[[Flown], Figure]:
    return lambda flown: draw_three_maps(flown.problem(name))


def _four(name: str) -> Callable[[Flown], Figure]:
    return lambda flown: draw_paths(
        flown, [(f"{letter}) {short}", name, full) for letter, (short, full) in zip("abcd", NAMES.items(), strict=True)]
    )


def figure_17(flown: Flown) -> Figure:
    """CDP over time on NewYork53."""
    figure, (axes,) = panels(1, 1, 4.4, 3.0)
    teleport = flown.problem("NewYork53").teleport.curve
    axes.plot(teleport, color="#d73027", ls=":", label="teleport")
    for name, (colour, line) in CURVES.items():
        judged = flown.judged("NewYork53", NAMES[name])
        label = f"{name} ({100 * (judged.efficiency or 0):.1f} %)"
        axes.plot(judged.times, judged.cdp, color=colour, ls=line, label=label)
    axes.set(xlabel="time step", ylabel="cumulative detection probability", xlim=(0, 900), ylim=(0, None))
    axes.legend(frameon=False)
    return figure


def figure_18(flown: Flown) -> Figure:
    """LHC-GW-CONV from the lower right, without and with an end."""
    return draw_paths(
        flown,
        [("no end", "lower right", "LHC-GW-CONV"), ("end at the upper left", "end at upper left", "LHC-GW-CONV")],
    )


FIGURES: dict[int, Callable[[Flown], Figure]] = {
    1: figure_1,
    2: figure_2,
    3: figure_3,
    4: figure_4,
    5: figure_5,
    7: figure_7,
    9: figure_9,
    10: _scenario("HikerPaul"),
    11: _four("HikerPaul"),
    12: figure_12,
    13: _scenario("NewYork53"),
    14: _four("NewYork53"),
    15: _scenario("NewYork108"),
    16: _four("NewYork108"),
    17: figure_17,
    18: figure_18,
}
