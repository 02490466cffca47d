"""Swath: against integration in small steps, and against Koopman's laws of parallel tracks."""

import math
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.special import erf

from sooner.errors import InvalidProblemError, UnsupportedProblemError
from sooner.grid import Grid
from sooner.sensors._swath_kernels import NEAREST, SURE, TOUCH_M
from sooner.sensors.swath import CUBE_REACH, Swath, pod

coordinates = st.integers(-60, 160).map(float)
lines = st.lists(st.tuples(coordinates, coordinates), min_size=1, max_size=5).map(np.array)
ground = Grid((6, 8), cell_m=15.0)


def dense(swath, line, step_m=0.02):
    """(N,) float: the laws as they are written down, summed over small steps of each leg."""
    total = np.zeros(ground.n_cells)
    for start, end in pairwise(line):
        length = math.dist(start, end)
        steps = max(int(length / step_m), 1)
        at = start + (np.arange(steps) + 0.5)[:, None] / steps * (end - start)
        r = np.hypot(*(ground.centres_m[:, None] - at[None]).transpose(2, 0, 1))
        if swath.law == "seen":
            r = np.column_stack([r, np.hypot(*(ground.centres_m[:, None] - line[None]).transpose(2, 0, 1))])
            total += SURE * (r.min(axis=1) <= swath.radius_m)
            continue
        rate = np.ones_like(r) if swath.law == "even" else 1 / (8 * np.pi * r**3)
        here = (rate * (r <= swath.radius_m)).sum(axis=1) * length / steps
        total += here * (swath.strength if swath.law == "even" else swath.strength**2)
    return total


def laid(swath, line, grid=ground):
    cells, effort, _ = swath.effort(grid, line)
    return np.bincount(cells, effort, minlength=grid.n_cells)


@settings(max_examples=40)
@given(line=lines, radius=st.floats(2.0, 45.0), seed=st.integers(0, 2**32 - 1))
def test_effort_of_an_even_rate_is_metres_in_view(line, radius, seed):
    swath = Swath(radius, "even", np.random.default_rng(seed).uniform(0, 0.02, ground.n_cells))
    assert laid(swath, line) == pytest.approx(dense(swath, line), abs=0.02 * 0.1 * max(len(line), 1))


@settings(max_examples=40)
@given(line=lines, radius=st.floats(2.0, 45.0), seed=st.integers(0, 2**32 - 1))
def test_effort_of_the_inverse_cube_is_its_integral(line, radius, seed):
    swath = Swath(radius, "cube", np.random.default_rng(seed).uniform(0, 10.0, ground.n_cells))
    near = min(np.hypot(*(_nearest(line) - ground.centres_m).T))
    if near < 0.5:  # too steep for small steps
        return
    edge = 100.0 / (8 * np.pi * radius**3) * 0.1 * len(line)  # a step in or out of view
    assert laid(swath, line) == pytest.approx(dense(swath, line), rel=2e-3, abs=edge)


def _nearest(line):
    """The place on a polyline nearest to each cell."""
    best, found = np.full(ground.n_cells, np.inf), np.zeros((ground.n_cells, 2))
    for start, end in pairwise(line):
        along = end - start
        share = np.clip((ground.centres_m - start) @ along / max(along @ along, 1e-9), 0, 1)
        place = start + share[:, None] * along
        far = np.hypot(*(ground.centres_m - place).T)
        found[far < best], best = place[far < best], np.minimum(far, best)
    return found


@settings(max_examples=60)
@given(line=lines, radius=st.floats(2.0, 45.0))
def test_whoever_comes_within_the_radius_is_seen(line, radius):
    if len(line) == 1:
        far = np.hypot(*(ground.centres_m - line[0]).T)
    else:
        far = np.hypot(*(ground.centres_m - _nearest(line)).T)
    sure = np.abs(far - radius) > 2 * TOUCH_M
    assert ((laid(Swath.seen(ground, radius), line) > 0) == (far <= radius))[sure].all()


@settings(max_examples=40)
@given(line=lines, law=st.sampled_from(["seen", "even", "cube"]), radius=st.floats(2.0, 45.0))
def test_effort_adds_up_over_legs_and_does_not_care_for_direction(line, law, radius):
    swath = Swath(radius, law, np.full(ground.n_cells, 0.01 if law == "even" else 4.0))
    whole, back = laid(swath, line), laid(swath, line[::-1])
    assert back == pytest.approx(whole, rel=1e-9, abs=1e-9)
    if len(line) > 1:
        parts = sum(laid(swath, line[k : k + 2]) for k in range(len(line) - 1))
        assert whole == pytest.approx(parts)
        if law != "seen":  # a leg cut in two is the same leg
            cut = np.insert(line, 1, (line[0] + 2 * line[1]) / 3, axis=0)
            assert laid(swath, cut) == pytest.approx(whole, rel=1e-6, abs=1e-9)


@settings(max_examples=40)
@given(line=lines, law=st.sampled_from(["seen", "even", "cube"]))
def test_a_look_comes_when_the_leg_is_nearest(line, law):
    swath = Swath(30.0, law, np.full(ground.n_cells, 0.01 if law == "even" else 4.0))
    flown, cells, at_m = 0.0, [], []
    for leg in pairwise(line):
        cells_of_leg, _, at_of_leg = swath.effort(ground, np.array(leg))
        along = (leg[1] - leg[0]) / max(math.dist(*leg), 1e-9)
        far = np.hypot(*(leg[0] + at_of_leg[:, None] * along - ground.centres_m[cells_of_leg]).T)
        assert far == pytest.approx(np.hypot(*(_nearest(np.array(leg)) - ground.centres_m)[cells_of_leg].T), abs=1e-6)
        cells.extend(cells_of_leg)
        at_m.extend(flown + at_of_leg)
        flown += math.dist(*leg)
    if len(line) > 1:
        whole = swath.effort(ground, line)
        assert whole[0].tolist() == cells
        assert whole[2] == pytest.approx(at_m)


@settings(max_examples=60)
@given(line=lines, cuts=st.integers(1, 9), radius=st.floats(2.0, 45.0))
def test_at_the_edge_of_what_is_in_view_no_cut_of_a_leg_gains(line, cuts, radius):
    swath = Swath.edged(ground, radius)
    for start, end in pairwise(line):
        whole = laid(swath, np.array([start, end]))
        cut = laid(swath, np.linspace(start, end, cuts + 2))
        assert np.isfinite(whole).all()
        assert (np.minimum(cut, SURE) <= whole + 1e-6).all()
        assert (whole <= laid(Swath.seen(ground, swath.radius_m), np.array([start, end])) + 1e-9).all()


@given(aside=st.floats(0.0, 40.0), radius=st.floats(5.0, 30.0), cuts=st.integers(0, 40))
@settings(max_examples=80)
def test_a_long_leg_sees_the_share_of_a_cell_that_its_swath_covers(aside, radius, cuts):
    one = Grid((1, 1), cell_m=10.0)
    swath = Swath.edged(one, radius)
    share = min(max((radius + 5.0 - aside) / 10.0, 0.0), 1.0)
    line = np.column_stack([np.linspace(-100, 100, cuts + 2), np.full(cuts + 2, aside)])
    found = pod(np.bincount(*swath.effort(one, line)[:2], minlength=1))[0] if share > 0 else 0.0
    assert found == pytest.approx(share, abs=1e-9 if cuts == 0 else 0.03)
    assert found <= share + 1e-9


# ---------------------------------------------------------------- Koopman 1956


def lanes(spacing, count, length):
    """Long parallel lanes round the middle of a grid, each flown alone."""
    offsets = (np.arange(count) - (count - 1) / 2) * spacing
    return [np.array([[-length, y], [length, y]]) for y in offsets]


def test_an_even_rate_gives_coverage_of_width_times_length_over_area():
    wide = Grid((200, 300), cell_m=5.0)
    swath = Swath.of_width(wide, 20.0, 35.0)
    rng = np.random.default_rng(1)
    metres, effort = 0.0, np.zeros(wide.n_cells)
    for _ in range(30):
        line = rng.uniform([100.0, 100.0], [1395.0, 895.0], (2, 2))
        metres += math.dist(*line)
        effort += laid(swath, line, wide)
    area = wide.n_cells * wide.cell_m**2
    assert effort.mean() == pytest.approx(20.0 * metres / area, rel=2e-3)  # C = W L / A


@pytest.mark.parametrize("coverage", [0.5, 1.0, 1.5])
def test_parallel_tracks_under_the_inverse_cube_detect_as_koopman_says(coverage):
    spacing = 40.0
    width = coverage * spacing
    aside = Grid((80, 1), cell_m=spacing / 80)  # one spacing across the lanes, whose middle is the grid's
    swath = Swath(40 * spacing, "cube", np.full(aside.n_cells, width))
    middle = (aside.shape[0] - 1) / 2 * aside.cell_m
    effort = sum(laid(swath, lane + np.array([0, middle]), aside) for lane in lanes(spacing, 80, 1e5))
    # e(x) = W^2 / 4 S^2 / sin^2(pi x / S) averages to erf(sqrt(pi) / 2 C)
    assert pod(effort).mean() == pytest.approx(erf(np.sqrt(np.pi) / 2 * coverage), abs=2e-3)


def test_the_inverse_cube_has_its_sweep_width():
    grid = Grid((1, 1), cell_m=1.0)
    whole = Swath.of_width(grid, 10.0, 10_000.0, law="cube")
    assert whole.width_m == pytest.approx(10.0, rel=2e-3)
    assert Swath.of_width(grid, 10.0, law="cube").radius_m == CUBE_REACH * 10.0
    assert Swath.seen(grid, 7.0).width_m == 14.0


def test_a_glimpse_is_what_a_cell_crossed_at_random_gets():
    grid = Grid((400, 1), cell_m=0.05)
    swath = Swath.of_glimpse(grid, 0.6, 9.0)
    far = np.abs(np.arange(400) * 0.05 - 10.0)
    effort = laid(swath, np.array([[-100.0, 10.0], [100.0, 10.0]]), grid)
    assert effort[far < 8.9].mean() == pytest.approx(-math.log(0.4), rel=2e-2)  # over a mean chord of pi R / 2


def test_the_inverse_cube_does_not_grow_without_end():
    swath = Swath.of_width(ground, 40.0, 45.0, law="cube")
    assert laid(swath, np.array([[0.0, 0.0], [90.0, 0.0]])).max() == SURE
    assert NEAREST * 45.0 < 0.05


# ---------------------------------------------------------------- bad input


@pytest.mark.parametrize(
    ("make", "told"),
    [
        (lambda: Swath(10.0, "cone", np.ones(4)), "law 'cone' came"),
        (lambda: Swath(0.0, "seen", np.ones(4)), "radius of 0.0 m"),
        (lambda: Swath(math.inf, "seen", np.ones(4)), "radius of inf m"),
        (lambda: Swath(1.0, "even", np.array([np.nan])), "strengths came negative or not finite"),
        (lambda: Swath(1.0, "even", np.array([-1.0])), "strengths came negative or not finite"),
        (lambda: Swath.of_width(ground, 30.0, 10.0), "at least half the width, 15 m"),
        (lambda: Swath.seen(ground, 5.0).effort(ground, [[0.0, np.nan]]), "expected finite metres"),
        (lambda: Swath.seen(ground, 5.0).effort(ground, np.zeros((0, 2))), r"shape \(0, 2\) came"),
    ],
)
def test_what_makes_no_sense_is_refused(make, told):
    with pytest.raises(InvalidProblemError, match=told):
        make()


def test_hexagons_are_refused():
    hexagons = Grid((3, 3), "hex")
    with pytest.raises(UnsupportedProblemError, match="square cells only"):
        Swath.seen(hexagons, 1.0).effort(hexagons, [[0.0, 0.0]])
