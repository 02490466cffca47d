"""Airspace: against shapely and a visibility graph by brute force, on random areas with holes and concave borders."""

import itertools
import math

import numpy as np
import pytest
import shapely
from hypothesis import given, settings
from hypothesis import strategies as st

from sooner.errors import InvalidProblemError
from sooner.grid._airspace_kernels import clear, inside
from sooner.grid.airspace import KEPT_M, MOST_WALLS, Airspace
from tests.grounds import ground, places_in

seeds = st.integers(0, 2**32 - 1)


def space_of(rng):
    """A random airspace, or None where nothing of the area is left."""
    free = ground(rng).free
    if free.is_empty:
        return None
    space = Airspace(free)
    return None if space.inner.is_empty or space.inner.area < 100.0 else space


@settings(max_examples=60)
@given(seed=seeds)
def test_walls_inside_and_clear_are_shapelys(seed):
    rng = np.random.default_rng(seed)
    space = space_of(rng)
    if space is None:
        return
    points = rng.uniform(-50, 1050, (60, 2))
    border = space.inner.boundary
    assert np.hypot(*(space.walls[:, 2:] - space.walls[:, :2]).T).sum() == pytest.approx(border.length)
    for (x0, y0), (x1, y1) in itertools.pairwise(points):
        leg = shapely.LineString([(x0, y0), (x1, y1)])
        assert clear(x0, y0, x1, y1, space.walls) == (not shapely.intersects(leg, border))
        assert inside(x0, y0, space.walls) == shapely.contains_xy(space.inner, x0, y0)
        if space.sees([(x0, y0)])[0] and space.clear((x0, y0), (x1, y1)):
            assert space.holds([(x0, y0), (x1, y1)])


@settings(max_examples=60)
@given(seed=seeds)
def test_planners_ground_lies_in_the_airspace_farther_off_than_rounding(seed):
    space = space_of(np.random.default_rng(seed))
    if space is None:
        return
    assert shapely.covers(space.free, space.inner)
    assert shapely.distance(space.inner, space.free.boundary) > 2 * KEPT_M


@settings(max_examples=40)
@given(seed=seeds)
def test_ways_are_legal_after_rounding_and_no_shorter_way_turns_at_corners(seed):
    rng = np.random.default_rng(seed)
    space = space_of(rng)
    if space is None or len(space.free.exterior.coords if space.free.geom_type == "Polygon" else range(99)) > 60:
        return
    a, b = places_in(rng, space, 2)
    shortest = visibility_graph_metres(space.free, a, b)
    if not np.isfinite(shortest):
        with pytest.raises(InvalidProblemError, match="no way from"):
            space.way(a, b)
        assert np.isinf(space.metres_from(a, b[None]))
        return
    if np.isinf(space.metres_from(a, b[None])):  # a gap of centimetres, which planners do not fly through
        assert not _one_part(space, a, b)
        return
    way = space.way(a, b)
    metres = np.hypot(*np.diff(way, axis=0).T).sum()
    assert (way[0] == a).all()
    assert (way[-1] == b).all()
    assert space.holds(way)
    assert space.holds(np.rint(way / KEPT_M) * KEPT_M)
    assert space.metres_from(a, b[None])[0] == pytest.approx(metres)
    if shapely.get_num_coordinates(space.inner) <= MOST_WALLS[0] and not _tight(space.free):
        assert shortest - 1e-6 <= metres <= shortest + 2.0


def _one_part(space, a, b):
    return any(
        shapely.contains_xy(part, *a) and shapely.contains_xy(part, *b) for part in shapely.get_parts(space.inner)
    )


def _tight(free):
    """Whether the ground has gaps or spikes that vanish a few centimetres inside."""
    here, there = free.buffer(-0.1), free.buffer(-0.01)
    return (
        len(shapely.get_parts(here)) != len(shapely.get_parts(there))
        or shapely.get_num_interior_rings(shapely.get_parts(here)).sum()
        != shapely.get_num_interior_rings(shapely.get_parts(there)).sum()
    )


def visibility_graph_metres(free, a, b):
    """Length of the shortest way through any corners of the border: all legs tried, Floyd's algorithm."""
    nodes = np.concatenate([[a, b], np.unique(shapely.get_coordinates(free), axis=0)])
    grown = free.buffer(1e-6)
    shapely.prepare(grown)
    i, j = np.triu_indices(len(nodes), 1)
    legs = shapely.linestrings(np.stack([nodes[i], nodes[j]], axis=1))
    far = np.full((len(nodes), len(nodes)), math.inf)
    free_legs = shapely.covers(grown, legs)
    far[i[free_legs], j[free_legs]] = shapely.length(legs[free_legs])
    far = np.minimum(far, far.T)
    for k in range(len(nodes)):
        far = np.minimum(far, far[:, [k]] + far[k])
    return far[0, 1]


def test_ground_in_two_parts_has_no_way_between_them():
    space = Airspace(shapely.union_all([shapely.box(0, 0, 100, 100), shapely.box(200, 0, 300, 100)]))
    with pytest.raises(InvalidProblemError, match=r"no way from \[50.0, 50.0\] to \[250.0, 50.0\] stays within"):
        space.way((50, 50), (250, 50))
    assert space.metres_from((50, 50), [[60, 50], [250, 50]]).tolist() == [10.0, math.inf]
    assert not space.holds([[50, 50], [250, 50]])


def test_the_border_belongs_to_the_airspace_but_planners_keep_off_it():
    space = Airspace(shapely.box(0, 0, 100, 100))
    assert space.holds([[0, 0], [100, 0], [100, 100]])
    assert space.holds([[0, 0]])
    assert not space.holds([[-0.01, 0]])
    assert space.sees([[0, 0], [50, 50], [101, 0]]).tolist() == [False, True, False]


def test_the_first_leg_that_leaves_is_named():
    space = Airspace(shapely.box(0, 0, 100, 100).difference(shapely.box(40, 40, 60, 60)))
    assert space.leaves([[10, 10], [90, 10], [90, 90]]) is None
    assert space.leaves([[10, 10], [90, 10], [10, 90], [10, 10]]) == 1
    assert space.leaves([[50, 50]]) == 0
    assert space.leaves([[10, 10], [90, 10], [120, 10]]) == 1


@pytest.mark.parametrize(
    ("free", "told"),
    [
        (shapely.Polygon(), "without ground"),
        (shapely.LineString([(0, 0), (1, 1)]), "LineString without ground"),
        (shapely.Polygon([(0, 0), (1, 1), (1, 0), (0, 1)]), "Self-intersection"),
    ],
)
def test_what_is_no_ground_is_refused(free, told):
    with pytest.raises(InvalidProblemError, match=told):
        Airspace(free)


def test_cells_make_ground():
    free = np.array([[True, True], [False, True]])
    space = Airspace.of_cells(free, 10.0)
    assert space.free.area == pytest.approx(300.0)
    assert space.holds([[0, 10], [10, 10], [10, 0]])  # row 0 is north
    assert not space.holds([[0, 0]])
    with pytest.raises(InvalidProblemError, match="without a free cell"):
        Airspace.of_cells(~np.ones((2, 2), bool), 10.0)


@pytest.mark.parametrize("kind", ["jagged", "round", "holes"])
def test_borders_of_many_corners_are_drawn_simpler_for_planners(kind):
    rng = np.random.default_rng(0)
    if kind == "jagged":
        angles = np.linspace(0, 2 * np.pi, 10_000, endpoint=False)
        far = 350.0 + sum(rng.normal(0, 40) / k * np.cos(k * angles + rng.uniform(0, 6)) for k in range(1, 1000))
        free = shapely.Polygon(np.column_stack([500 + far * np.cos(angles), 500 + far * np.sin(angles)]))
        free = max(shapely.get_parts(shapely.make_valid(free)), key=shapely.area)
    elif kind == "round":
        free = shapely.Point(500, 500).buffer(500.0, quad_segs=2500)
    else:
        holes = [shapely.Point(*rng.uniform(50, 950, 2)).buffer(4.0, quad_segs=8) for _ in range(300)]
        free = shapely.box(0, 0, 1000, 1000).difference(shapely.union_all(holes))
    assert shapely.get_num_coordinates(free) > 4000
    space = Airspace(free)
    assert len(space.walls) <= MOST_WALLS[1]
    assert shapely.covers(space.free, space.inner)
    assert space.inner.area > 0.8 * space.free.area
    a, b = places_in(rng, space, 2)
    try:
        assert space.holds(space.way(a, b))
    except InvalidProblemError:
        assert not _one_part(space, a, b)
