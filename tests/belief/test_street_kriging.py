"""Kriging along streets: the fast solution against the full system, and the full system against its laws."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from sooner.belief import StreetKriging, street_directions
from sooner.errors import InvalidProblemError
from sooner.grid import Grid

GRID = Grid((40, 40), "square8", 5.0)
SMALL = Grid((6, 7), "square8", 5.0)
METHOD = StreetKriging()


def streets(angle: float, every: int = 7) -> np.ndarray:
    """(M,) void probabilities of parallel streets under an angle."""
    east, north = GRID.centres_m.T / 5.0
    return np.where((np.cos(angle) * north - np.sin(angle) * east) % every < 1.0, 0.0, 0.999)


def seen_by_flights(rng: np.random.Generator, flights: int) -> np.ndarray:
    """(M,) bool: within 12.5 m of some straight lines."""
    a, b = rng.uniform(0, 195, (2, flights, 2))
    along = a[:, None] + np.linspace(0, 1, 60)[:, None] * (b - a)[:, None]
    return (np.hypot(*(GRID.centres_m[:, None] - along.reshape(-1, 2)).T) <= 12.5).any(axis=0)


@pytest.mark.parametrize("seed", range(6))
def test_the_fast_solution_differs_from_the_full_system_by_less_than_a_two_hundredth(seed: int) -> None:
    """As a search goes on, with warm starts, changing streets and void probabilities that change under it."""
    rng = np.random.default_rng(seed)
    session = METHOD.session(GRID)
    explored = np.zeros(GRID.n_cells, bool)
    truth = streets(rng.uniform(0, np.pi))
    for _ in range(4):
        explored |= seen_by_flights(rng, 3)
        void = np.where(explored, np.clip(truth + 0.1 * rng.standard_normal(truth.size), 0.0, 1.0), 0.9)
        edges = rng.choice([0.1, 1.7, 2.3, 2.9], 40) + 0.02 * rng.standard_normal(40)
        found = session.expected_void(void, explored, edges)
        expected = METHOD.dense(GRID, void, explored, *street_directions(edges))
        assert np.abs(found - expected).max() < 0.005
        assert (found[explored] == void[explored]).all()


def test_a_session_does_not_remember_cells_that_are_taken_back() -> None:
    rng, session = np.random.default_rng(8), METHOD.session(GRID)
    void, edges = streets(0.4), np.array([0.4, 1.97])
    session.expected_void(void, np.ones(GRID.n_cells, bool), edges)
    few = seen_by_flights(rng, 1)
    again = session.expected_void(void, few, edges)
    assert np.abs(again - METHOD.session(GRID).expected_void(void, few, edges)).max() < 0.005


@given(st.integers(0, 2**32 - 1), st.floats(0.02, 0.98))
def test_a_flat_map_is_kriged_flat(seed: int, level: float) -> None:
    """Ordinary weights total one."""
    explored = np.random.default_rng(seed).random(SMALL.n_cells) < 0.4
    explored[0] = True
    directions = street_directions([])
    assert METHOD.dense(SMALL, np.full(42, level), explored, *directions) == pytest.approx(level, abs=1e-9)
    assert METHOD.session(SMALL).expected_void(np.full(42, level), explored, []) == pytest.approx(level, abs=2e-3)


@given(st.integers(0, 2**32 - 1))
def test_the_full_system_is_generalised_least_squares(seed: int) -> None:
    """m = 1'K^-1 v / 1'K^-1 1, v_krig = m + k'K^-1 (v - m), written out cell by cell."""
    rng = np.random.default_rng(seed)
    explored, void = rng.random(SMALL.n_cells) < 0.5, rng.random(SMALL.n_cells)
    explored[:2] = True, False
    angles, weights = street_directions(rng.uniform(0, np.pi, 5))
    known = np.flatnonzero(explored)

    def alike(a: int, b: int) -> float:
        east, north = SMALL.centres_m[a] - SMALL.centres_m[b]
        total = 0.0
        for t, w in zip(angles, weights, strict=True):
            along, across = np.cos(t) * east + np.sin(t) * north, -np.sin(t) * east + np.cos(t) * north
            total += w * np.exp(-np.sqrt((along / 5.0) ** 2 + (across / 0.5) ** 2))
        return total

    inverse = np.linalg.inv([[alike(a, b) for b in known] for a in known])
    mean = inverse.sum(axis=0) @ void[known] / inverse.sum()
    found = METHOD.dense(SMALL, void, explored, angles, weights)
    for cell in np.flatnonzero(~explored):
        told = mean + np.array([alike(cell, a) for a in known]) @ inverse @ (void[known] - mean)
        assert found[cell] == pytest.approx(np.clip(told, 0.01, 0.99), abs=1e-9)


def test_a_street_goes_on_where_nobody_has_looked() -> None:
    void, explored = np.full((9, 9), 0.999), np.zeros((9, 9), bool)
    void[4], explored[:, :4] = 0.0, True
    grid = Grid((9, 9), "square8", 5.0)
    found = METHOD.session(grid).expected_void(void.ravel(), explored.ravel(), [0.0]).reshape(9, 9)
    assert found[4, 4] < 0.6 < found[4, 4] + 0.3 < found[3, 4]
    assert found[4, 4] < found[4, 5] < found[4, 6]


def test_predictions_are_clipped_so_that_no_cell_is_settled_unseen() -> None:
    explored = seen_by_flights(np.random.default_rng(1), 2)
    for level in (0.0, 1.0):
        found = METHOD.session(GRID).expected_void(np.full(GRID.n_cells, level), explored, [])
        assert found[~explored] == pytest.approx(0.01 if level == 0.0 else 0.99)


def test_before_anything_is_explored_all_stays_as_it_is() -> None:
    void = np.full(GRID.n_cells, 0.9)
    assert (METHOD.session(GRID).expected_void(void, np.zeros(GRID.n_cells, bool), []) == 0.9).all()
    with pytest.raises(InvalidProblemError, match="expected some to krige from"):
        METHOD.dense(GRID, void, np.zeros(GRID.n_cells, bool), *street_directions([]))


def histogram_peaks(edges: np.ndarray, most: int) -> list[tuple[float, float]]:
    """Peaks by plain counting, (degrees, share)."""
    counts = [int(np.sum(np.floor(np.degrees(edges) % 180 / 2) % 90 == b)) for b in range(90)]
    found = []
    while any(counts) and len(found) < most:
        held = [(counts[b - 1] + counts[b] + counts[(b + 1) % 90], counts[b], -b) for b in range(90)]
        heaviest = max(held)
        b = -heaviest[2]
        found.append((2.0 * b + 1.0, heaviest[0]))
        counts[b - 1] = counts[b] = counts[(b + 1) % 90] = 0
    total = sum(weight for _, weight in found)
    return [(angle, weight / total) for angle, weight in found]


@given(st.lists(st.integers(-1800, 1799), min_size=1, max_size=60), st.integers(1, 6))
def test_directions_are_the_peaks_of_the_histogram(tenths: list[int], most: int) -> None:
    edges = np.radians(np.array(tenths) / 10.0 + 0.05)  # none on the edge of a bin
    angles, weights = street_directions(edges, most)
    assert list(zip(np.degrees(angles), weights, strict=True)) == [
        (pytest.approx(angle), pytest.approx(weight)) for angle, weight in histogram_peaks(edges, most)
    ]


def test_without_edges_directions_are_spread_evenly() -> None:
    angles, weights = street_directions([])
    assert np.degrees(angles) == pytest.approx([0, 45, 90, 135])
    assert weights == pytest.approx(0.25)


def test_north_and_south_are_one_direction() -> None:
    for edges in ([0.001, np.pi - 0.001, -0.001], [0.0, np.pi, -np.pi]):
        angles, weights = street_directions(edges)
        assert weights.tolist() == [1.0]
        assert min(angles[0], np.pi - angles[0]) < np.radians(2)


@pytest.mark.parametrize("bad", [{"along_m": 0.0}, {"across_m": float("nan")}, {"directions": 0}, {"floor": 0.5}])
def test_impossible_settings_are_refused(bad: dict[str, float]) -> None:
    with pytest.raises(InvalidProblemError, match="came; expected"):
        StreetKriging(**bad)


def test_impossible_directions_and_grids_are_refused() -> None:
    with pytest.raises(InvalidProblemError, match="divisor of 180"):
        street_directions([0.0], bin_degrees=7)
    with pytest.raises(InvalidProblemError, match="not finite"):
        street_directions([float("nan")])
    with pytest.raises(InvalidProblemError, match="expected square ones"):
        METHOD.session(Grid((4, 4), "hex"))
