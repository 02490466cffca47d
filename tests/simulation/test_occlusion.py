"""Ground where looks may be in vain: the readings' joint law, what beliefs are told of them, and plans that know."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.stats import chisquare

from sooner.belief import CellStates
from sooner.errors import InvalidProblemError
from sooner.grid import Grid
from sooner.sensors import GradedSensor
from sooner.simulation import (
    Agent,
    Estimator,
    Keep,
    Scene,
    Sensing,
    World,
    load_episode,
    replayed,
    save_episode,
    simulate,
)
from sooner.simulation.sensing import MOST_RATIO, LookLog
from sooner.simulation.strategies import make_strategy

from .streets import blocks

GRID = Grid((20, 30), "square8", 5.0)
NODES = np.arange(GRID.n_cells) % 3 == 0
MAP, TARGET = GradedSensor(2.0, 5), GradedSensor(3.0, 4)
AGENTS = (Agent(radius_m=300.0, map_sensor=MAP, target_sensor=TARGET),)


def looks(glimpse, second=0, targets=(), agents=AGENTS):
    log = LookLog(0)
    place = np.full((len(agents), 2), 50.0)
    sensing = Sensing(GRID, agents, glimpse=glimpse)
    sensing.look(second, place, NODES, np.array(targets, np.int64), 5, log)
    return log


def read(log):
    """Levels of the map and of the target sensor, by cell."""
    order = np.argsort(log.cells[: log.end])
    return log.map_levels[: log.end][order], log.target_levels[: log.end][order]


def joint_law(state: str, g: float) -> np.ndarray:
    """P(map level, target level) of a void, unoccupied or occupied cell, by the law of total probability."""
    seen = np.outer(MAP.p_signal if state in "UO" else MAP.p_noise, TARGET.p_signal if state == "O" else TARGET.p_noise)
    return g * seen + (1.0 - g) * np.outer(MAP.p_noise, TARGET.p_noise)


@pytest.mark.parametrize("strategy", ["swept_information", "joint", "lawnmower"])
def test_a_glimpse_of_one_is_open_ground_to_the_last_digit(strategy):
    flown = [
        simulate(
            Scene(World(blocks()), estimator=Estimator(prior="kriged"), seconds=40, glimpse=glimpse),
            make_strategy(strategy),
            3,
            Keep(looks=True, beliefs_s=20),
        )
        for glimpse in (None, np.ones(400))
    ]
    for name in ("places_m", "sums", "node_seconds"):
        assert (getattr(flown[0], name) == getattr(flown[1], name)).all()
    assert (flown[0].looks.target_levels == flown[1].looks.target_levels).all()
    assert (flown[0].beliefs.occupied == flown[1].beliefs.occupied).all()


def test_readings_of_both_sensors_come_from_one_gap():
    """The joint law of the two, as counted; independent gaps would give other counts."""
    occupied, counts = np.arange(GRID.n_cells) % 6 == 0, {state: np.zeros((5, 4)) for state in "VUO"}
    state = np.where(occupied, "O", np.where(NODES, "U", "V"))
    for second in range(40):
        levels = read(looks(np.full(GRID.n_cells, 0.4), second, np.flatnonzero(occupied)))
        for each, table in counts.items():
            np.add.at(table, tuple(row[state == each] for row in levels), 1)
    cumulative = np.minimum(Sensing(GRID, AGENTS).cumulative[0], 1.0)
    map_0, map_1, target_0, target_1 = np.diff(cumulative, axis=1, prepend=0.0)  # how often draws become levels
    for each, table in counts.items():
        seen = np.outer(map_0 if each == "V" else map_1, target_1 if each == "O" else target_0)[:, :4]
        expected = 0.4 * seen + 0.6 * np.outer(map_0, target_0)[:, :4]
        often = expected * table.sum() > 5
        scaled = expected[often] / expected[often].sum() * table[often].sum()
        assert chisquare(table[often], scaled).pvalue > 0.001
    apart = np.outer(0.4 * map_1 + 0.6 * map_0, 0.4 * target_1 + 0.6 * target_0)[:, :4]
    assert chisquare(counts["O"].ravel(), apart.ravel() / apart.sum() * counts["O"].sum()).pvalue < 1e-9


def test_canopy_changes_no_reading_but_its_own():
    canopy = np.where(np.arange(GRID.n_cells) % 5 == 0, 0.3, 1.0)
    targets = np.flatnonzero(NODES)[:50]
    open_ground, covered, blind = (read(looks(g, targets=targets)) for g in (None, canopy, np.zeros(GRID.n_cells)))
    for clear, seen, noise in zip(open_ground, covered, blind, strict=True):
        assert (seen[canopy == 1] == clear[canopy == 1]).all()
        assert ((seen == clear) | (seen == noise)).all()
    in_vain = (covered[0] == blind[0]) & (open_ground[0] != blind[0])
    found = (covered[0] != blind[0]) & (canopy < 1)
    assert in_vain.any()
    assert found.any()
    assert (covered[1][in_vain] == blind[1][in_vain]).all()
    assert (covered[1][found] == open_ground[1][found]).all()


def test_beliefs_are_told_bayes_law_on_the_joint_table():
    prior = np.array([0.7, 0.2, 0.1])
    glimpse = np.random.default_rng(1).random(GRID.n_cells)
    log = looks(glimpse, targets=np.flatnonzero(NODES)[::2])
    n = GRID.n_cells
    states = CellStates(*(np.full(n, p) for p in prior), np.zeros(n, bool), np.zeros(n, bool))
    after = states.see(log.cells[: log.end], log.map_ratios[: log.end], log.target_ratios[: log.end])
    for look in range(0, log.end, 7):
        cell, levels = log.cells[look], (log.map_levels[look], log.target_levels[look])
        joint = prior * [joint_law(state, glimpse[cell])[levels] for state in "VUO"]
        found = after.void[cell], after.unoccupied[cell], after.occupied[cell]
        assert found == pytest.approx(joint / joint.sum(), rel=1e-12)


@given(st.floats(0.0, 1.0))
def test_what_noise_says_is_one_on_average(g):
    """E[P(l, f | C) / P(l, f | V)] = 1 in void cells: no look persuades by itself."""
    from sooner.simulation._sensing_kernels import told

    noise = np.outer(MAP.p_noise, TARGET.p_noise)
    of_node, of_target = np.vectorize(lambda k, z: told(k, z, g))(
        *np.meshgrid(MAP.likelihood_ratios, TARGET.likelihood_ratios, indexing="ij")
    )
    assert (noise * of_node).sum() == pytest.approx(1.0)
    assert (noise * of_node * of_target).sum() == pytest.approx(1.0)
    without = joint_law("U", g)
    assert (without * of_target).sum() == pytest.approx(1.0)


def test_a_look_at_a_cell_that_cannot_be_seen_teaches_nothing():
    log = looks(np.zeros(GRID.n_cells), targets=np.flatnonzero(NODES))
    assert (log.map_ratios[: log.end] == 1).all()
    assert (log.target_ratios[: log.end] == 1).all()


@pytest.mark.parametrize("g", [None, 1e-300, 0.5, 1.0 - 1e-16])
def test_the_sharpest_sensors_tell_finite_ratios_and_leave_probabilities(g):
    sharp = (Agent(radius_m=300.0, map_sensor=GradedSensor(30.0), target_sensor=GradedSensor(30.0)),)
    glimpse = None if g is None else np.full(GRID.n_cells, g)
    states = CellStates.unknown(GRID.n_cells)
    for second in range(20):
        log = looks(glimpse, second, np.flatnonzero(NODES)[::2], sharp)
        ratios = log.map_ratios[: log.end], log.target_ratios[: log.end]
        assert all(np.isfinite(np.log(ratio)).all() for ratio in ratios)
        states = states.see(log.cells[: log.end], *ratios)
        total = states.void + states.unoccupied + states.occupied
        assert total == pytest.approx(1.0)
    assert Sensing(GRID, sharp).ratios.max() == MOST_RATIO


@pytest.mark.parametrize("strategy", ["swept_information", "joint", "rollouts"])
def test_plans_that_know_where_nothing_can_be_seen_find_more_elsewhere(strategy):
    """Half of the ground cannot be seen; nobody need fly there."""
    glimpse = np.where(np.arange(400) % 20 < 10, 0.0, 1.0)
    scene = Scene(World(blocks()), seconds=80, replan_s=10, glimpse=glimpse, agents=(Agent(),) * 2)
    told, untold = (
        [simulate(scene, each, seed).e_nodes for seed in range(16)]
        for each in (make_strategy(strategy), _Untold(make_strategy(strategy)))
    )
    apart = np.subtract(told, untold)
    assert apart.mean() > 4 * apart.std(ddof=1) / np.sqrt(len(apart))


class _Untold:
    """A strategy that takes all ground for open."""

    def __init__(self, strategy):
        self.strategy, self.capture, self.starts = strategy, strategy.capture, strategy.starts

    def session(self, situation, rng):
        session = self.strategy.session(replace(situation, glimpse=None), rng)
        routes = session.routes
        session.routes = lambda situation: routes(replace(situation, glimpse=None))
        return session


def test_an_episode_under_canopy_is_kept_and_flown_again(tmp_path):
    glimpse = np.linspace(0.0, 1.0, 400)
    flown = simulate(
        Scene(World(blocks()), seconds=20, glimpse=glimpse), make_strategy("swept_information"), 2, Keep(looks=True)
    )
    save_episode(flown, tmp_path / "episode.npz")
    loaded = load_episode(tmp_path / "episode.npz")
    assert (loaded.scene.glimpse == glimpse).all()
    again = replayed(loaded)
    assert (again.looks.map_levels == flown.looks.map_levels).all()
    assert (again.sums == flown.sums).all()


@pytest.mark.parametrize(
    "bad", [np.full(400, 1.5), np.full(400, -0.1), np.full(400, np.nan), np.ones(399), np.ones((4, 100))]
)
def test_a_glimpse_that_makes_no_sense_is_refused(bad):
    with pytest.raises(InvalidProblemError, match="a glimpse of"):
        Scene(World(blocks()), glimpse=bad)
