"""What the figures of all papers share: type, panels, maps, and small PNG files."""

from __future__ import annotations

import io
from collections.abc import Callable, Iterator, Mapping
from typing import TYPE_CHECKING, Any, TypeVar

from numpy.typing import NDArray

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

__all__ = ["bare", "draw_all", "draw_map", "panels"]

STYLE: Any = {
    "font.size": 8,
    "axes.titlesize": 8.5,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "figure.dpi": 140,
    "savefig.dpi": 140,
    "image.cmap": "YlGnBu",
}
Source = TypeVar("Source")  # what the figures of a paper are drawn from


def draw_all(figures: Mapping[int, Callable[[Source], Figure]], source: Source) -> Iterator[tuple[str, bytes]]:
    """Draw the figures of a paper, each by its number: the name of a small PNG file, and what it holds."""
    import matplotlib as mpl

    mpl.use("agg")
    for number, draw in figures.items():
        with mpl.rc_context(STYLE):
            yield f"figure-{number:02d}.png", _png(draw(source))


def _png(figure: Figure) -> bytes:
    import matplotlib.pyplot as plt

    drawn = io.BytesIO()
    options = {"optimize": True, "compress_level": 9}
    figure.savefig(drawn, format="png", bbox_inches="tight", metadata={"Software": None}, pil_kwargs=options)
    plt.close(figure)
    return drawn.getvalue()


def panels(rows: int, cols: int, width: float, height: float) -> tuple[Figure, list[Axes]]:
    """A figure of so many panels, each so many inches wide and high; the panels row by row."""
    import matplotlib.pyplot as plt

    size = (width * cols, height * rows)
    figure, axes = plt.subplots(rows, cols, figsize=size, layout="constrained", squeeze=False)
    return figure, list(axes.flat)


def draw_map(axes: Axes, values: NDArray[Any], title: str, **settings: Any) -> Any:
    """(H, W) numbers as a map, each cell one colour; answers what a colour bar is made from."""
    shown = axes.imshow(values, interpolation="nearest", **settings)
    bare(axes, title)
    return shown


def bare(axes: Axes, title: str) -> None:
    """A frame and a title, and no ticks."""
    axes.set(title=title, xticks=[], yticks=[])
    for spine in axes.spines.values():
        spine.set_visible(True)
        spine.set_linewidth(0.6)
