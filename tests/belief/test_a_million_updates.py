"""Beliefs after a million random updates: probabilities that total one, finite logarithms, nothing settled for ever."""

import numpy as np
import pytest

from sooner.belief import CellStates, EvidenceGrid, TrackBeforeDetect
from sooner.belief._cell_state_kernels import see
from sooner.sensors import GradedSensor
from sooner.simulation._sensing_kernels import told
from sooner.streets import TargetStates, TargetWalk

from ..streets.graphs import random_graph

MILLION = 1_000_000


def ratios(rng: np.random.Generator, n: int) -> tuple[np.ndarray, np.ndarray]:
    """What random levels of random sensors say, from blind to the sharpest, through canopy or not."""
    of_map, of_target = (
        np.concatenate([GradedSensor(m).likelihood_ratios.clip(1e-100, 1e100) for m in (0.0, 1.0, 4.0, 30.0)])
        for _ in range(2)
    )
    pairs = zip(rng.choice(of_map, n), rng.choice(of_target, n), rng.choice([0.0, 0.2, 1.0], n), strict=True)
    told_of = np.array([told(g, z, share) for g, z, share in pairs])
    return told_of[:, 0].copy(), told_of[:, 1].copy()


@pytest.mark.parametrize("void", [0.0, 0.5, 1.0])
def test_cells_stay_probabilities_from_any_prior_and_come_back_from_certainty(void: float) -> None:
    """Void of 0 or 1 is no deadlock: looks that say otherwise long enough are believed."""
    rng, n = np.random.default_rng(1), 1_000
    rest = (1.0 - void) / 2.0
    states = CellStates(np.full(n, void), np.full(n, rest), np.full(n, rest), np.zeros(n, bool), np.zeros(n, bool))
    three = states.void, states.unoccupied, states.occupied
    cells = np.arange(n, dtype=np.int32)

    def look(g: np.ndarray, z: np.ndarray) -> None:
        see(*three, states.explored, states.nodes, cells, g, z, 0, n)

    g, z = ratios(rng, 50_000)
    for start in rng.integers(len(g) - n, size=MILLION // n):
        look(g[start : start + n], z[start : start + n])
        assert np.isfinite(np.log(three)).all()
    assert np.abs(sum(three) - 1.0).max() < 1e-12
    likeliest = GradedSensor().likelihood_ratios
    for level, sure in ((0, states.void), (-1, states.occupied), (0, states.void)):
        for _ in range(80):
            look(np.full(n, likeliest[level]), np.full(n, likeliest[level]))
        assert (sure > 0.999).all()


def test_a_track_stays_a_probability_and_its_log_ratios_finite() -> None:
    rng = np.random.default_rng(2)
    states = TargetStates(random_graph(rng))
    track = TrackBeforeDetect().begun(states, TargetWalk().weights(states))
    node_ratios = np.zeros(states.n_nodes)
    _, z = ratios(rng, 50_000)
    said = np.concatenate([z, 1.0 / z, [0.0, 1e-300, 1e300, np.inf]])
    a_second = 200
    nothing = np.empty(0, np.int64)
    for second in range(MILLION // a_second):
        new = rng.integers(states.n_nodes, size=1) if second % 500 == 0 else nothing
        cells = states.graph.cells[rng.integers(states.n_nodes, size=a_second)].astype(np.int32)
        total, _ = track.second(new, cells, rng.choice(said, a_second), node_ratios)
        assert np.isfinite(total)
        assert abs(track.probability.sum() - 1.0) < 1e-9
    assert ((track.probability >= 0) & (track.probability <= 1)).all()
    assert np.isfinite(track.log_ratios[states.explored(track.detected)]).all()


def test_evidence_stays_a_probability_and_can_be_undone() -> None:
    rng = np.random.default_rng(3)
    grid = EvidenceGrid(rng.random((50, 50)))
    cells = np.arange(2_500)
    for _ in range(MILLION // 2_500):
        grid = grid.update(cells, rng.random(2_500) < 0.5, 0.85, 0.15)
    assert ((grid.theta >= 0) & (grid.theta <= 1)).all()
    assert np.isfinite(grid.log_odds).all()
