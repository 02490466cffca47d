"""A fence never stands where the flight goes, and stands only around what is known to be forbidden."""

from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from sooner.grid import Grid
from sooner.io.georeference import Georeference
from sooner.missions import fences as module
from sooner.missions.fences import CLEAR_M, MOST_CORNERS, fences

GROUND = Georeference("EPSG:32632", (720_000.0, 5_150_000.0), 24.0, 24.0)


SHARES = np.linspace(0.0, 1.0, 101)


def fenced(stones, line, closed=False, cell_m=24.0):
    ground = Georeference(GROUND.crs, GROUND.corner, cell_m, cell_m)
    grid = Grid(stones.shape, "square4", cell_m, stones.astype(bool))
    found, notes = fences(grid, ground, np.asarray(line, np.float64), closed)
    return [(ground.cells(fence.corners), fence.inclusion) for fence in found], notes


def inside(place, ring):
    """Whether a ray to the east crosses a border an odd number of times."""
    crossed = False
    for (row, col), (below, right) in zip(ring, np.roll(ring, -1, axis=0), strict=True):
        if (row > place[0]) != (below > place[0]) and place[1] < col + (place[0] - row) / (below - row) * (right - col):
            crossed = not crossed
    return crossed


def test_ground_without_obstacles_has_no_fence():
    grid = Grid((5, 5), "square4", 24.0)
    assert fences(grid, GROUND, np.array([[1.0, 1.0], [1.0, 3.0]]), False) == ((), ())


def test_obstacles_are_kept_out_and_free_ground_is_kept_in():
    stones = np.zeros((12, 16))
    stones[5:7, 7:9] = 1
    stones[:, 15] = 1
    (outline, stone), notes = fenced(stones, [[2, 2], [2, 12]])
    assert (outline[1], stone[1]) == (True, False)
    np.testing.assert_allclose(
        sorted(map(tuple, outline[0].round(3))), [(-0.5, -0.5), (-0.5, 14.5), (11.5, -0.5), (11.5, 14.5)]
    )
    np.testing.assert_allclose(sorted(map(tuple, stone[0].round(3))), [(4.5, 6.5), (4.5, 8.5), (6.5, 6.5), (6.5, 8.5)])
    assert notes == ()


@settings(max_examples=60)
@given(st.integers(0, 2**25 - 1), st.data())
def test_what_a_fence_allows_is_free_and_holds_the_flight(bits, data):
    stones = np.array([bits >> k & 1 for k in range(25)]).reshape(5, 5)
    stones[2, 2] = 0
    stones = np.kron(stones, np.ones((2, 2)))  # so that the flight keeps its distance
    line = np.array([[4.5, 4.5], [4.5, 4.6]])
    found, _ = fenced(stones, line, closed=data.draw(st.booleans()))
    for place in line:
        assert all(inside(place, ring) == inclusion for ring, inclusion in found)
    if not found or not found[0][1]:
        return
    for row, col in np.ndindex(*stones.shape):
        allowed = all(inside((row + 0.01, col + 0.02), ring) == inclusion for ring, inclusion in found)
        assert not (allowed and stones[row, col])


@pytest.mark.parametrize(("row", "count"), [(2.0, 2), (4.4, 1)])
def test_a_fence_too_near_to_the_flight_is_left_out(row, count):
    stones = np.zeros((12, 16))
    stones[5:7, 7:9] = 1
    found, notes = fenced(stones, [[row, 2], [row, 12]])
    assert len(found) == count
    assert [f"within {CLEAR_M:g} m" in note for note in notes] == [True] * (2 - count)


def test_the_way_straight_home_counts():
    stones = np.zeros((12, 16))
    stones[5:7, 7:9] = 1
    near = [[6.6, 2.0], [2.0, 2.0], [2.0, 12.0], [6.6, 12.0]]
    assert len(fenced(stones, near)[0]) == 2
    assert len(fenced(stones, near, closed=True)[0]) == 1


def test_of_many_obstacles_the_largest_are_fenced():
    stones = np.zeros((60, 60))
    stones[10:50:4, 10:50:4] = 1
    stones[30:34, 52:56] = 1
    found, notes = fenced(stones, [[2, 2], [2, 20]])
    assert sum(len(ring) for ring, _ in found) <= MOST_CORNERS
    assert len(found[1][0]) == 4
    assert np.ptp(found[1][0], axis=0).tolist() == pytest.approx([4, 4], abs=1e-3)
    assert any(f"more than {MOST_CORNERS} corners" in note for note in notes)


def test_borders_that_turn_too_often_are_not_followed(monkeypatch):
    stones = np.zeros((60, 60))
    stones[10:50:4, 10:50:4] = 1
    monkeypatch.setattr(module, "MOST_TRACED", 403)
    found, notes = fenced(stones, [[2, 2], [2, 20]])
    assert found == []
    assert notes == ("no fences: the borders of the obstacles turn more than 403 times",)
    monkeypatch.setattr(module, "MOST_TRACED", 404)  # the map's four, and four for each of a hundred stones
    assert fenced(stones, [[2, 2], [2, 20]])[0]


@settings(max_examples=30)
@given(st.integers(0, 2**32 - 1))
def test_distances_are_those_between_all_points_and_legs(seed):
    rng = np.random.default_rng(seed)
    points, line = rng.random((rng.integers(1, 8), 2)), rng.random((rng.integers(1, 8), 2))
    line[-1] = line[0]
    near = min(np.hypot(*(p - a - s * (b - a))) for p in points for a, b in pairwise([*line, line[-1]]) for s in SHARES)
    assert module._nearest(points, line) == pytest.approx(near, abs=0.01)
    assert module._nearest(points, line) <= near + 1e-12


def ragged(rows=40, cols=40):
    """A round rock, whose border turns often."""
    r, c = np.indices((rows, cols))
    return ((r - 20) ** 2 + (c - 20) ** 2 < 60).astype(float)


def test_an_obstacle_that_turns_often_has_a_convex_fence_around_it():
    stones = ragged()
    (_, (ring, inclusion)), notes = fenced(stones, [[4, 4], [4, 36], [36, 36]])
    assert not inclusion
    assert len(ring) < len(module._outlines(stones == 0, np.zeros((1, 2)))[1][0])
    legs = np.roll(ring, -1, axis=0) - ring
    turns = legs[:, 0] * np.roll(legs, -1, axis=0)[:, 1] - legs[:, 1] * np.roll(legs, -1, axis=0)[:, 0]
    assert abs(np.sign(turns).sum()) == len(turns)
    assert all(inside((row, col), ring) for row, col in np.argwhere(stones))
    assert notes == ()


def test_a_flight_between_a_ragged_obstacle_and_its_convex_line_has_the_true_border_or_none():
    stones = np.zeros((40, 40))
    stones[10:30, 10:30] = 1
    stones[10:20, 14:26] = 0  # a bay, open to the north
    for step in range(9):
        stones[30 + step, 10 : 28 - 2 * step] = 1  # a ragged end, to the south
    bay = [[4, 4], [4, 20], [14, 20], [4, 20]]
    (_, (ring, _)), _ = fenced(stones, bay)
    assert not inside((14, 20), ring)
    assert inside((25, 20), ring)
    (_, (hull, _)), _ = fenced(stones, [[4, 4], [4, 20]])
    assert inside((14, 20), hull)


@settings(max_examples=60)
@given(st.integers(0, 2**32 - 1))
def test_a_line_that_crosses_a_border_is_not_apart_from_it(seed):
    rng = np.random.default_rng(seed)
    line, ring = rng.random((rng.integers(2, 6), 2)), rng.random((rng.integers(3, 6), 2))
    border = [*ring, ring[0]]
    shares = [
        np.linalg.solve(np.column_stack([b - a, c - d]), c - a) for a, b in pairwise(line) for c, d in pairwise(border)
    ]  # of both legs, where they meet
    crosses = any(((share > 0) & (share < 1)).all() for share in shares)
    assert module._crosses(line, np.array(border)) == crosses
    assert (module._apart(line, ring) == 0.0) == crosses
