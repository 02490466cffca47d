"""The search area on the ground: polygons, no-fly zones, points and elevation in metres of one frame."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from sooner.io.georeference import Georeference
from sooner.io.local_frame import LocalFrame

__all__ = ["RealArea"]


@dataclass(frozen=True, eq=False)
class RealArea:
    """Where a search is, in metres east and north of the south-west cell's centre.

    Parameters
    ----------
    polygon : Polygon or MultiPolygon       the search area, with its holes
    no_fly : Polygon or MultiPolygon        zones that nothing flies over, buildings too; may be empty
    points : mapping                        title -> (east, north) of what the files mark, where one has that title
    elevation : (H, W) float or None        metres above the sea
    ground : Georeference                   of the grid's cells
    shape : (int, int)                      of the grid
    twice : frozenset of str                titles of several points, which name none
    flight_area : geometry or None          where drones may be; None where that is the search area
    """

    polygon: Any
    no_fly: Any
    points: Mapping[str, tuple[float, float]]
    elevation: NDArray[np.float64] | None
    ground: Georeference
    shape: tuple[int, int]
    twice: frozenset[str] = frozenset()
    flight_area: Any | None = None

    @property
    def border(self) -> Any:
        """Polygon or MultiPolygon: where drones may be, but for no-fly zones and margins."""
        return self.polygon if self.flight_area is None else self.flight_area

    @property
    def frame(self) -> LocalFrame:
        """From degrees to its metres, and back."""
        return LocalFrame(self.ground, self.shape)

    def flyable(self, margin_m: float = 0.0, obstacles: NDArray[np.bool_] | None = None) -> Any:
        """Polygon or MultiPolygon: where a drone may be, so far from the border and from zones; may be empty.

        Parameters
        ----------
        margin_m : float                    to keep from `border` and from no-fly zones
        obstacles : (H, W) bool or None     cells that cannot be entered either
        """
        import shapely

        free, zones = self.border, self.no_fly
        if margin_m > 0:
            free, zones = free.buffer(-margin_m), zones.buffer(margin_m)
        free = free.difference(zones)
        if obstacles is not None and obstacles.any():
            rows, cols = np.nonzero(obstacles)
            side = self.ground.cell_m
            x, y = cols * side, (self.shape[0] - 1 - rows) * side
            squares = shapely.box(x - side / 2, y - side / 2, x + side / 2, y + side / 2)
            free = free.difference(
                shapely.union_all(squares).buffer(margin_m) if margin_m > 0 else shapely.union_all(squares)
            )
        return free
