"""Three maps of a debrief, whatever their shape."""

import numpy as np
import pytest

from sooner.grid import Grid
from sooner.plotting.debrief_picture import Maps, draw_debrief


@pytest.mark.parametrize(("shape", "gaps"), [((6, 9), True), ((40, 3), True), ((1, 1), False), ((1, 2000), True)])
def test_maps_of_any_shape_are_drawn(shape, gaps):
    rng, count = np.random.default_rng(2), shape[0] * shape[1]
    poc = rng.random(count) / count
    maps = Maps(poc, rng.random(count), poc, rng.random(count) < 0.2 if gaps else None)
    lines = [np.array([[0.0, 0.0], [9.0, 5.0]]), np.array([[3.0, 3.0]])]
    drawn = draw_debrief(Grid(shape, cell_m=5.0), maps, lines, lines[:1] if gaps else [], "A $name$" * 40, "one flight")
    assert drawn.startswith(b"\x89PNG")
