"""A figure of our style, as PNG."""

from __future__ import annotations

import io
import warnings
from collections.abc import Callable
from typing import TYPE_CHECKING, Any

from sooner.plotting.style import PAPER, STYLE

if TYPE_CHECKING:
    from matplotlib.figure import Figure

__all__ = ["png"]


def png(compose: Callable[[Figure], None], size: tuple[float, float] | None = None, dpi: int = 120) -> bytes:
    """What `compose` puts on an empty figure, of so many inches, or of a size that it gives itself."""
    import matplotlib as mpl
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    plain: dict[Any, Any] = dict(mpl.rcParamsDefault)
    with mpl.rc_context(plain | STYLE), warnings.catch_warnings():
        warnings.filterwarnings("ignore", "Glyph .* missing from font")  # a name in a script that the font lacks
        figure = Figure(figsize=size, facecolor=PAPER)
        FigureCanvasAgg(figure)
        compose(figure)
        drawn = io.BytesIO()
        figure.savefig(drawn, format="png", dpi=dpi, facecolor=PAPER, metadata={"Software": "sooner"})
    return drawn.getvalue()
