"""Fences of what is drawn hold all of it, keep clear of the flight, and have few corners."""

import numpy as np
import pytest
import shapely
from hypothesis import given, settings
from hypothesis import strategies as st

from sooner.missions.drawn_fences import LEAST_M2, MOST_INSIDE, MOST_OUTSIDE, rings_around
from sooner.missions.fences import CLEAR_M, MOST_CORNERS


def ragged(rng, middle, radius, corners):
    """A star-shaped polygon whose border turns often, concave as a rule."""
    turns = np.linspace(0.0, 2.0 * np.pi, corners, endpoint=False)
    reach = radius * rng.uniform(0.6, 1.0, corners)
    return shapely.Polygon(np.asarray(middle) + reach[:, None] * np.column_stack([np.cos(turns), np.sin(turns)]))


@settings(max_examples=60, deadline=None)
@given(st.integers(0, 2**32 - 1), st.integers(3, 120), st.integers(0, 12))
def test_fences_hold_what_is_drawn_and_keep_clear_of_the_flight(seed, corners, zones):
    rng = np.random.default_rng(seed)
    area = ragged(rng, (1000.0, 1000.0), 1000.0, corners)
    places, sizes = rng.uniform(300, 1700, (zones, 2)), rng.uniform(20, 150, zones)
    shut = shapely.union_all(
        [ragged(rng, at, size, int(rng.integers(3, 60))) for at, size in zip(places, sizes, strict=True)]
    )
    free = area.difference(shut) if zones else area
    part = max(shapely.get_parts(free.buffer(-1.0)), key=lambda each: each.area)
    line = shapely.get_coordinates(part.exterior)[: int(rng.integers(1, 30))]
    rings, notes = rings_around(area, shut if zones else shapely.MultiPolygon(), line)
    path = shapely.LineString(line) if len(line) > 1 else shapely.Point(line[0])
    assert sum(len(ring) for ring, _ in rings) <= MOST_CORNERS
    drawn = [part for part in shapely.get_parts(shut.intersection(area)) if part.geom_type == "Polygon"]
    for ring, inclusion in rings:
        fence = shapely.Polygon(ring)
        assert fence.is_valid
        assert fence.exterior.distance(path) >= CLEAR_M
        assert fence.contains(path) == inclusion
        assert len(ring) <= (MOST_INSIDE if inclusion else MOST_OUTSIDE)
        if inclusion:
            assert fence.buffer(1e-6).covers(shapely.Polygon(area.exterior))
        else:
            assert any(fence.buffer(1e-6).covers(zone) for zone in drawn)
    if len(rings) < 1 + sum(zone.area >= LEAST_M2 for zone in drawn):
        assert notes


def test_the_border_gives_way_to_a_flight_along_it_and_zones_do_not():
    area, zone = shapely.box(0, 0, 1000, 600), shapely.box(400, 200, 500, 300)
    (outer, stays), (inner, goes) = rings_around(area, zone, [[1, 1], [999, 1], [300, 100]])[0]
    assert (stays, goes) == (True, False)
    np.testing.assert_allclose(shapely.Polygon(outer).bounds, (-5, -5, 1005, 605))
    assert shapely.Polygon(inner).equals(zone)
    rings, notes = rings_around(area, zone, [[100, 100], [398, 150], [398, 400]])
    assert [inclusion for _, inclusion in rings] == [True]
    assert len(notes) == 1
    assert "within 5 m of them: area.margin_m keeps it farther off" in notes[0]


def test_the_edge_of_a_map_forbids_nothing_and_zones_beyond_the_area_need_no_fence():
    zone = shapely.union_all([shapely.box(400, 200, 500, 300), shapely.box(5000, 0, 5100, 100)])
    assert [inclusion for _, inclusion in rings_around(None, zone, [[0, 0], [100, 0]])[0]] == [False, False]
    rings, _ = rings_around(shapely.box(0, 0, 1000, 600), zone, [[10, 10], [100, 10]])
    assert [inclusion for _, inclusion in rings] == [True, False]


def test_holes_are_zones_and_of_many_the_largest_are_fenced():
    holes = [shapely.box(x, y, x + 10 + x / 100, y + 10) for x in range(50, 950, 90) for y in range(100, 500, 90)]
    area = shapely.box(0, 0, 1000, 600).difference(shapely.union_all(holes))
    rings, notes = rings_around(area, shapely.MultiPolygon(), [[20, 20], [980, 20]])
    assert sum(len(ring) for ring, _ in rings) <= MOST_CORNERS
    widths = [np.ptp(ring[:, 0]) for ring, inclusion in rings if not inclusion]
    assert widths == sorted(widths, reverse=True)
    assert any(f"more than {MOST_CORNERS} corners" in note for note in notes)


def test_a_round_zone_has_a_plain_fence_around_it():
    zone = shapely.Point(500, 300).buffer(80.0, 32)
    (ring, inclusion), *_ = rings_around(None, zone, [[0, 0], [100, 0]])[0]
    assert not inclusion
    assert len(ring) <= MOST_OUTSIDE
    fence = shapely.Polygon(ring)
    assert fence.covers(zone)
    assert fence.area == pytest.approx(zone.area, rel=0.15)
