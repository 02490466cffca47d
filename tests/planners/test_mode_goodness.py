"""Mode Goodness, eq. (12) to (20), against the author's stored Gaussians and by hand."""

import json

import numpy as np
import pytest

from sooner.belief.mixture import Mixture
from sooner.decomposition import modes
from sooner.grid import Grid
from sooner.planners.hill_climb import directions
from sooner.planners.mode_goodness import ModeGoodness, match_modes, mode_goodness
from sooner.problem import Gains, Searcher, SearchProblem
from tests.planners.climbing import two_hills


def test_the_authors_gaussians_rank_as_his_ratios_do(real_problem, wisar):
    stored = json.loads((wisar / "hikerpaul_T900_author_gmm_k5.json").read_text())["gaussians"]
    mixture = Mixture(*(np.array([g[key] for g in stored]) for key in ("weight", "mean", "cov")))
    field = directions(real_problem("hikerpaul", 900))[0]
    cells = match_modes(field, mixture, modes(field.grid, field.surface.ravel()))
    goodness = mode_goodness(mixture, field.steps_from_start[cells], 900)
    assert goodness / goodness[0] == pytest.approx([g["mgr"] for g in stored], rel=1e-6)
    assert (goodness / goodness[0]).round(2).tolist() == [1.0, 0.87, 1.39, 0.46, 1.01]


def gaussian(weight=1.0, mean=(0.0, 0.0), rows=4.0, cols=9.0):
    return Mixture(np.array([weight]), np.array([mean]), np.array([np.diag([rows, cols])]))


def test_goodness_is_distance_ratio_times_volume_over_area():
    # T = 100, alpha = 9: D = log10 10 = 1; A = 9 x 2 x 3
    assert mode_goodness(gaussian(0.5), np.array([9]), 100) == pytest.approx([0.9946 * 0.5 / 54.0])


def test_the_exponent_weighs_distance_only():
    near = mode_goodness(gaussian(), np.array([0]), 100, exponent=2.0)
    assert near == pytest.approx(2.0 * mode_goodness(gaussian(), np.array([0]), 100))
    assert mode_goodness(gaussian(), np.array([60]), 100, exponent=0.0) == pytest.approx([0.9946 / 54.0])


def test_a_hill_beyond_the_time_is_worth_nothing():
    assert mode_goodness(gaussian(), np.array([100]), 100)[0] == -np.inf


def test_the_way_to_the_end_counts_as_distance():
    grid, gains = two_hills()
    free = SearchProblem(grid, gains, (Searcher((10, 14), 100),))
    ending = SearchProblem(grid, gains, (Searcher((10, 14), 100, end=(10, 30)),))
    rng = np.random.default_rng
    first = [grid.cell(int(ModeGoodness().ranked(directions(p)[0], 2, rng(0))[0])) for p in (free, ending)]
    assert first == [(10, 5), (10, 25)]


def test_no_mode_is_matched_twice():
    grid, gains = two_hills()
    field = directions(SearchProblem(grid, gains, (Searcher((10, 14), 100),)))[0]
    twice = Mixture(np.array([0.5, 0.5]), np.array([[10.0, 6.0], [10.0, 5.0]]), np.array([np.eye(2)] * 2))
    matched = match_modes(field, twice, modes(grid, field.surface.ravel()))
    assert [grid.cell(int(c)) for c in matched] == [(10, 5), (10, 25)]


def test_k_is_reduced_where_there_are_fewer_modes():
    grid, gains = two_hills()
    field = directions(SearchProblem(grid, gains, (Searcher((10, 14), 100),)))[0]
    assert len(ModeGoodness().ranked(field, 5, np.random.default_rng(0))) == 2


@pytest.mark.parametrize("height", [np.zeros(9), np.ones(9) / 9, np.eye(9)[4]])
def test_degenerate_surfaces_are_ranked(height):
    problem = SearchProblem(Grid((3, 3)), Gains.independent(height, np.ones(9)), (Searcher((0, 0), 5),))
    ranked = ModeGoodness().ranked(directions(problem)[0], 5, np.random.default_rng(0))
    assert ranked.tolist() == ([4] if height.any() else [])
