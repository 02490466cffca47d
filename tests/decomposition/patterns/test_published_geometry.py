"""The patterns' legs on open ground, as the search manuals print them (IAMSAR vol. II ch. 5, vol. III sec. 12)."""

from itertools import pairwise

import numpy as np
import pytest
import shapely
from hypothesis import given, settings
from hypothesis import strategies as st

from sooner.decomposition.patterns import (
    clipped,
    contour_lines,
    contour_search,
    creeping_line,
    expanding_square,
    narrowest,
    parallel_track,
    sector_search,
)
from sooner.errors import InvalidProblemError
from tests.decomposition.patterns.areas import area, check_inside, length

OPEN = shapely.box(-1e4, -1e4, 1e4, 1e4)


def legs(track):
    return np.hypot(*np.diff(track, axis=0).T)


def right_turns(track):
    """(n,) degrees by which the track turns to the right, in [0, 360)."""
    steps = np.diff(track, axis=0)
    headings = np.degrees(np.arctan2(steps[:, 1], steps[:, 0]))
    return np.mod(-np.diff(headings), 360)


@pytest.mark.parametrize("angle", [0.0, 0.3, 2.0])
def test_a_parallel_track_begins_half_a_spacing_inside_a_corner_and_flies_the_long_way(angle):
    ground = shapely.affinity.rotate(shapely.box(0, 0, 3000, 1000), angle, (0, 0), use_radians=True)
    turn = np.array([(np.cos(angle), np.sin(angle)), (-np.sin(angle), np.cos(angle))])
    (track,) = parallel_track(ground, 200.0, commence=np.array([0.0, 0.0]))
    heights = 100.0 + 200 * np.arange(5)
    printed = [(x, y) for k, y in enumerate(heights) for x in ((100, 2900) if k % 2 == 0 else (2900, 100))]
    assert np.allclose(track, np.array(printed) @ turn, atol=1e-6)
    assert np.allclose(legs(track), [2800, 200] * 4 + [2800])


def test_a_creeping_line_has_short_legs_and_creeps_along_the_long_side():
    (track,) = creeping_line(shapely.box(0, 0, 3000, 1000), 200.0, commence=(3000.0, 1000.0))
    assert np.allclose(track[:4], [(2900, 900), (2900, 100), (2700, 100), (2700, 900)])
    assert np.allclose(legs(track), [800, 200] * 14 + [800])


@pytest.mark.parametrize("corner", [(0, 0), (3000, 0), (0, 1000), (3000, 1000)])
def test_a_search_commences_at_the_corner_that_is_asked_for(corner):
    for pattern in (parallel_track, creeping_line):
        (track,) = pattern(shapely.box(0, 0, 3000, 1000), 200.0, commence=corner)
        assert np.allclose(np.abs(track[0] - corner), 100)


def test_an_expanding_square_has_legs_of_one_one_two_two_three_three_spacings_and_turns_right():
    (track,) = expanding_square(OPEN, (50, 70), 100.0, heading=0.4)
    whole = legs(track)[:150]
    assert np.allclose(whole, 100 * (np.arange(150) // 2 + 1))
    assert np.allclose(right_turns(track)[:149], 90)
    assert np.allclose(track[1] - track[0], 100 * np.array([np.cos(0.4), np.sin(0.4)]))


def test_an_expanding_square_sees_all_of_a_square_about_its_datum():
    ground = shapely.box(-500, -500, 500, 500)
    tracks = expanding_square(ground, (0, 0), 100.0)
    # turns of 90 degrees: a corner of the strip lies half a diagonal from the track
    swept = shapely.union_all([shapely.linestrings(track).buffer(50 * np.sqrt(2) + 0.1, 64) for track in tracks])
    assert ground.difference(swept).area == 0


def test_a_sector_search_is_three_equilateral_triangles_and_the_second_pass_falls_between():
    (track,) = sector_search(OPEN, (50, 70), 300.0, heading=1.0, passes=2)
    assert np.allclose(legs(track)[:7], [300, 300, 600, 300, 600, 300, 300])
    assert np.isclose(legs(track).sum(), 2 * 9 * 300)
    assert np.allclose(right_turns(track)[:6], 120)
    middle = np.array([50, 70])
    assert np.allclose(track[[0, 7, 14]], middle)
    rim = np.concatenate([track[1:7], track[8:14]]) - middle
    assert np.allclose(np.hypot(*rim.T), 300)
    bearings = np.sort(np.mod(np.degrees(np.arctan2(rim[:, 1], rim[:, 0])) - np.degrees(1.0), 360).round(6) % 360)
    assert np.allclose(bearings, np.arange(12) * 30)
    for first, second in ((track[1], track[8]), (track[2], track[9])):
        turn = np.degrees(np.subtract(*(np.arctan2(*(place - middle)[::-1]) for place in (first, second))))
        assert np.isclose(turn, 30)


def test_a_contour_search_circles_a_cone_from_the_top_at_equal_heights():
    side, cell_m = 201, 10.0
    x, y = np.meshgrid(np.arange(side) * cell_m - 1000, 1000 - np.arange(side) * cell_m)
    cone = 1000 - np.hypot(x, y)
    free = shapely.Point(1000, 1000).buffer(900, 64)
    tracks = contour_search(free, cone, cell_m, rise=200.0)
    points = np.concatenate(tracks) - 1000
    ring = np.rint(np.hypot(*points.T) / 100)
    assert set(ring) == {1, 3, 5, 7, 9} - ({9} - set(ring))
    assert (np.diff(ring) >= 0).all()
    assert np.abs(np.hypot(*points.T) - 100 * ring).max() < 10


def test_contour_lines_over_the_ground_lie_as_far_apart_in_the_mean_as_is_asked_for():
    plane = np.repeat((0.3 * 10.0 * np.arange(101))[:, None], 201, axis=1)
    free = shapely.box(0, 0, 2000, 1000)
    tracks = contour_search(free, plane, 10.0, spacing=100.0)
    assert np.isclose(length(tracks), 10 * 2000 + 9 * 100)
    norths = np.unique(np.concatenate(tracks)[:, 1].round(6))
    assert np.allclose(norths, 50 + 100 * np.arange(10))


def test_the_narrowest_way_of_a_triangle_lies_along_its_longest_side():
    assert np.isclose(narrowest(shapely.Polygon([(0, 0), (100, 100), (40, 60)])), np.pi / 4)


@settings(max_examples=25, deadline=None)
@given(st.integers(0, 2**32 - 1), st.floats(30, 200), st.floats(-3, 3))
def test_every_pattern_stays_in_ground_with_holes(seed, spacing, angle):
    free = area(seed)
    rng = np.random.default_rng(seed)
    datum = rng.uniform(-600, 600, 2)
    heights = 30 * rng.standard_normal((12, 12))
    for tracks in (
        parallel_track(free, spacing, angle),
        creeping_line(free, spacing, commence=datum),
        expanding_square(free, datum, spacing, angle),
        sector_search(free, datum, 3 * spacing, angle, passes=2),
        contour_search(free, heights, 100.0, spacing=spacing, origin=(-550.0, -550.0)),
    ):
        check_inside(tracks, free)


@settings(max_examples=25, deadline=None)
@given(st.integers(0, 2**32 - 1))
def test_what_is_clipped_is_all_that_lies_inside_in_the_order_of_the_track(seed):
    free, rng = area(seed), np.random.default_rng(seed)
    track = rng.uniform(-700, 700, (7, 2))
    pieces = clipped(track, free)
    whole = sum(shapely.linestrings(pair).intersection(free).length for pair in pairwise(track))
    assert np.isclose(length(pieces), whole)
    steps = np.diff(track, axis=0)
    places = []
    for point in np.concatenate([piece[[0, -1]] for piece in pieces]) if pieces else []:
        share = np.clip(((point - track[:-1]) * steps).sum(axis=1) / (steps**2).sum(axis=1), 0, 1)
        off = np.hypot(*(track[:-1] + share[:, None] * steps - point).T)
        places.append([k + share[k] for k in np.flatnonzero(off < 1e-6)])
    reached = 0.0
    for here in places:
        ahead = [place for place in here if place >= reached - 1e-9]
        assert ahead
        reached = min(ahead)


@settings(max_examples=20, deadline=None)
@given(st.integers(0, 2**32 - 1))
def test_contour_lines_have_the_height_that_is_asked_for_where_the_raster_is_plane(seed):
    rng = np.random.default_rng(seed)
    slope, level = rng.uniform(-1, 1, 2), rng.uniform(-30, 30)
    cols, rows = np.meshgrid(np.arange(9.0), np.arange(8.0))
    heights = slope[0] * cols * 10 + slope[1] * (7 - rows) * 10
    for line in contour_lines(heights, 10.0, level):
        assert np.allclose(line @ slope, level, atol=1e-6)


def test_no_contour_line_passes_where_no_height_is_known():
    heights = np.repeat(np.arange(6.0)[:, None], 9, axis=1)
    heights[:, 4] = np.nan
    lines = contour_lines(heights, 10.0, 2.5)
    spans = sorted((line[:, 0].min(), line[:, 0].max()) for line in lines)
    assert spans == [(0.0, 30.0), (50.0, 80.0)]


BOX = shapely.box(0, 0, 100, 100)
BOW_TIE = shapely.Polygon([(0, 0), (10, 10), (10, 0), (0, 10)])


@pytest.mark.parametrize("free", [BOW_TIE, shapely.Polygon(), shapely.Point(0, 0), None, shapely.MultiPolygon()])
def test_ground_that_is_none_is_refused(free):
    for call in (
        lambda: parallel_track(free, 10.0),
        lambda: creeping_line(free, 10.0),
        lambda: expanding_square(free, (0, 0), 10.0),
        lambda: sector_search(free, (0, 0), 10.0),
        lambda: contour_search(free, np.eye(3), 10.0, rise=1.0),
    ):
        with pytest.raises(InvalidProblemError, match="free: "):
            call()


@pytest.mark.parametrize(
    ("call", "said"),
    [
        (lambda: parallel_track(BOX, 0.0), "track spacing of 0.0 m"),
        (lambda: parallel_track(BOX, np.nan), "track spacing of nan m"),
        (lambda: parallel_track(BOX, 1e-6), "lanes would come"),
        (lambda: parallel_track(BOX, 10.0, np.inf), "an angle of inf"),
        (lambda: creeping_line(BOX, 10.0, commence=(np.nan, 0)), "commence: .* came"),
        (lambda: expanding_square(BOX, (0, 0, 0), 10.0), "datum: .* came"),
        (lambda: expanding_square(BOX, (0, 0), 1e-9), "legs would come"),
        (lambda: expanding_square(BOX, (1e300, 0), 10.0), "legs would come"),
        (lambda: sector_search(BOX, (0, 0), -1.0), "radius of -1.0 m"),
        (lambda: sector_search(BOX, (0, 0), 10.0, passes=0), "0 passes came"),
        (lambda: contour_search(BOX, np.eye(3), 50.0), "expected one of them"),
        (lambda: contour_search(BOX, np.eye(3), 50.0, rise=1.0, spacing=1.0), "expected one of them"),
        (lambda: contour_search(BOX, np.ones((3, 3)), 50.0, rise=1.0), "level ground"),
        (lambda: contour_search(BOX, np.full((3, 3), np.nan), 50.0, rise=1.0), "no elevation"),
        (lambda: contour_search(BOX, np.full((3, 3), np.inf), 50.0, rise=1.0), "infinite elevation"),
        (lambda: contour_search(BOX, np.ones(3), 50.0, rise=1.0), r"shape \(3,\)"),
        (lambda: contour_search(BOX, np.eye(3), 50.0, rise=1e-9), "heights would come"),
    ],
)
def test_numbers_that_make_no_sense_are_refused(call, said):
    with pytest.raises(InvalidProblemError, match=said):
        call()
