import itertools

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from sooner.errors import InvalidProblemError, UnsupportedProblemError
from sooner.grid import Grid
from sooner.motion import Dynamics, rounded
from sooner.sensors import swept_cells
from sooner.sensors.footprint import cell_passes


def legs(way: np.ndarray) -> list:
    return list(itertools.pairwise(way)) if len(way) > 1 else [(way[0], way[0])]


def within(grid: Grid, way: np.ndarray, radius: float) -> tuple[np.ndarray, np.ndarray]:
    """Distance of every centre to the polyline, and where along it the centre first comes within the radius."""
    nearest, first, flown = np.full(grid.n_cells, np.inf), np.full(grid.n_cells, np.inf), 0.0
    for a, b in legs(way):
        long = np.hypot(*(b - a))
        unit = (b - a) / long if long > 0 else np.zeros(2)
        along = (grid.centres_m - a) @ unit
        foot = np.clip(along, 0, long)
        apart = np.hypot(*(grid.centres_m - a - foot[:, None] * unit).T)
        nearest = np.minimum(nearest, apart)
        aside = np.hypot(*(grid.centres_m - a - along[:, None] * unit).T)
        at = np.clip(along - np.sqrt(np.maximum(radius**2 - aside**2, 0)), 0, long)
        first = np.where(apart <= radius + 1e-9 * grid.cell_m, np.minimum(first, flown + at), first)
        flown += long
    return nearest, first


@st.composite
def sweeps(draw) -> tuple[Grid, np.ndarray]:
    shape = draw(st.integers(1, 12)), draw(st.integers(1, 12))
    cell_m = draw(st.sampled_from([1.0, 2.2]))
    whole = st.tuples(st.integers(-2, 13), st.integers(-2, 13))
    any_ = st.tuples(st.floats(-3, 13), st.floats(-3, 13))
    way = np.array(draw(st.lists(whole | any_, min_size=1, max_size=5)), float) * cell_m
    rng = np.random.default_rng(draw(st.integers(0, 99)))
    return Grid(shape, cell_m=cell_m, obstacles=rng.random(shape) < 0.2), way


@settings(max_examples=150)
@given(sweep=sweeps(), radius=st.sampled_from([0.75, 1.0, 1.5, 2.0, 5.0**0.5, 4.0]) | st.floats(0.75, 6.0))
def test_cells_are_those_within_the_radius_of_the_polyline(sweep, radius: float) -> None:
    grid, way = sweep
    radius *= grid.cell_m
    nearest, first = within(grid, way, radius)
    cells, first_m = swept_cells(grid, way, radius, obstacles=True)
    assert cells.tolist() == np.flatnonzero(nearest <= radius + 1e-9 * grid.cell_m).tolist()
    assert first_m == pytest.approx(first[cells], abs=1e-6)
    free, free_m = swept_cells(grid, way, radius)
    assert free.tolist() == cells[grid.passable[cells]].tolist()
    assert free_m.tolist() == first_m[grid.passable[cells]].tolist()


@settings(max_examples=100)
@given(sweep=sweeps(), radius=st.sampled_from([0.75, 1.0, 2.0, 4.0]) | st.floats(0.75, 6.0))
def test_passes_are_the_stretches_of_the_polyline_in_view(sweep, radius: float) -> None:
    grid, way = sweep
    radius *= grid.cell_m
    cells, comes, goes = cell_passes(grid, way, radius)
    seen, first_m = swept_cells(grid, way, radius)
    assert np.unique(cells).tolist() == seen.tolist()
    assert comes[np.searchsorted(cells, seen)] == pytest.approx(first_m, abs=1e-6)
    lengths = np.array([np.hypot(*(b - a)) for a, b in legs(way)])
    assert (comes >= 0).all()
    assert (comes <= goes + 1e-9).all()
    assert (goes <= lengths.sum() + 1e-6).all()
    again = np.flatnonzero(cells[1:] == cells[:-1])
    assert (comes[again + 1] > goes[again]).all()
    bounds = np.concatenate([[0.0], np.cumsum(lengths)])
    for metres in np.random.default_rng(0).uniform(0, lengths.sum(), 20):
        leg = min(int(np.searchsorted(bounds, metres, "right")) - 1, len(lengths) - 1)
        a, b = legs(way)[leg]
        here = a + (b - a) * ((metres - bounds[leg]) / lengths[leg] if lengths[leg] else 0.0)
        apart = np.hypot(*(grid.centres_m - here).T)
        inside = np.unique(cells[(comes <= metres) & (metres <= goes)])
        free = grid.passable
        assert set(np.flatnonzero(free & (apart < radius - 1e-4))) <= set(inside.tolist())
        assert set(inside.tolist()) <= set(np.flatnonzero(free & (apart < radius + 1e-4)))


@settings(max_examples=60)
@given(sweep=sweeps(), radius=st.sampled_from([0.0, 0.3, 0.5, 0.7]))
def test_a_small_radius_sees_the_cells_below_as_well(sweep, radius: float) -> None:
    grid, way = sweep
    nearest, _ = within(grid, way, radius * grid.cell_m)
    cells, first_m = swept_cells(grid, way, radius * grid.cell_m, obstacles=True)
    expected = set(np.flatnonzero(nearest <= (radius + 1e-9) * grid.cell_m).tolist())
    allowed, flown, ends = set(expected), 0.0, []
    for a, b in legs(way):
        long = np.hypot(*(b - a))
        for share in np.linspace(0, 1, 500):
            east, north = (a + share * (b - a)) / grid.cell_m
            row, col = grid.shape[0] - 1 - north + 0.5, east + 0.5
            for r, c in itertools.product((row - 1e-6, row + 1e-6), (col - 1e-6, col + 1e-6)):
                if 0 <= r < grid.shape[0] and 0 <= c < grid.shape[1]:
                    cell = int(r) * grid.shape[1] + int(c)
                    allowed.add(cell)
                    inside = abs(row - int(r) - 0.5) < 0.499 and abs(col - int(c) - 0.5) < 0.499
                    if inside and share < 1:
                        expected.add(cell)
                        ends.append((cell, flown + share * long))
        flown += long
    assert expected <= set(cells.tolist())
    assert len(set(cells.tolist()) - allowed) <= 2 * len(way)  # slivers that samples of a leg step over
    when = dict(zip(cells.tolist(), first_m, strict=True))
    assert all(when[cell] <= at + 1e-6 for cell, at in ends)


def test_a_diagonal_step_sees_its_two_cells_and_a_line_along_an_edge_one_side() -> None:
    grid = Grid((3, 3))
    assert swept_cells(grid, [[0, 2], [2, 0]], 0.0)[0].tolist() == [0, 4, 8]
    assert swept_cells(grid, [[0, 0], [2, 2]], 0.0)[0].tolist() == [2, 4, 6]
    assert len(swept_cells(grid, [[0, 0.5], [2, 0.5]], 0.0)[0]) == 3
    assert swept_cells(grid, [[0.5, 0.5]], 0.0)[0].tolist() == [7]


def test_the_radius_itself_is_within() -> None:
    grid = Grid((9, 9), cell_m=2.2)
    cells, _ = swept_cells(grid, [[8.8, 8.8]], 8.8)
    assert {4, 36, 44, 76} <= set(cells.tolist())
    assert len(cells) == 49


@settings(max_examples=30)
@given(sweep=sweeps(), radius=st.floats(0.0, 4.0))
def test_a_longer_flight_or_a_wider_view_sees_no_less_and_no_later(sweep, radius: float) -> None:
    grid, way = sweep
    cells, first = swept_cells(grid, way, radius)
    for more in (swept_cells(grid, np.vstack([way, way[:1] + 3]), radius), swept_cells(grid, way, radius + 0.5)):
        later = dict(zip(*(x.tolist() for x in more), strict=True))
        assert all(later.get(cell, np.inf) <= at + 1e-6 for cell, at in zip(cells.tolist(), first, strict=True))


def test_rounded_turns_are_seen_when_they_are_flown() -> None:
    grid = Grid((40, 40))
    flight = rounded([[5, 5], [5, 30], [14, 30], [14, 5]], Dynamics(2.0, 1.0))
    points, flown = flight.polyline(sagitta_m=1e-4)
    cells, first = swept_cells(grid, points, 4.0)
    chords = np.concatenate([[0], np.cumsum(np.hypot(*np.diff(points, axis=0).T))])
    position, _ = flight.at(flight.times_at(np.interp(first, chords, flown)))
    apart = np.hypot(*(position - grid.centres_m[cells]).T)
    assert (apart <= 4.0 + 2e-3).all()


def test_a_large_map_costs_no_more_than_what_is_seen() -> None:
    cells, _ = swept_cells(Grid((6400, 3200)), [[100, 100], [3000, 6300]], 4.0)
    assert len(cells) == pytest.approx(8 * np.hypot(2900, 6200), rel=0.01)


@pytest.mark.parametrize("way", [[], [1.0, 2.0], [[np.inf, 0.0]]])
def test_a_polyline_that_makes_no_sense_is_refused(way: list) -> None:
    with pytest.raises(InvalidProblemError, match="a polyline of shape"):
        swept_cells(Grid((2, 2)), way, 1.0)


def test_a_radius_or_a_grid_that_makes_no_sense_is_refused() -> None:
    with pytest.raises(InvalidProblemError, match="radius of -1"):
        swept_cells(Grid((2, 2)), [[0, 0]], -1.0)
    with pytest.raises(UnsupportedProblemError, match="hexagonal"):
        swept_cells(Grid((2, 2), "hex"), [[0, 0]], 1.0)
