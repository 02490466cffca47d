"""Looks: the cells in view, the readings' law, and the same world whatever was looked at before."""

import numpy as np
import pytest
from scipy.stats import chisquare

from sooner.errors import InvalidProblemError
from sooner.grid import Grid
from sooner.sensors.graded import GradedSensor
from sooner.simulation import HALF_CELL, Agent, Sensing
from sooner.simulation.sensing import LookLog

GRID = Grid((20, 30), "square8", 5.0)
NODES = np.arange(GRID.n_cells) % 3 == 0


def looks(sensing, places, second=0, targets=(), seed=5):
    log = LookLog(sensing.most_looks)
    sensing.look(second, np.array(places, float), NODES, np.array(targets, np.int64), seed, log)
    return log


@pytest.mark.parametrize("place", [(0.0, 0.0), (40.0, 37.5), (-2.5, 97.5), (146.1, 3.3), (-40.0, 50.0)])
def test_all_cells_whose_centres_are_within_the_radius_are_seen_once(place):
    log = looks(Sensing(GRID, (Agent(),)), [place])
    seen = log.cells[log.start : log.end]
    within = np.flatnonzero(np.hypot(*(GRID.centres_m - place).T) <= 12.5)
    np.testing.assert_array_equal(np.sort(seen), within)


def test_readings_follow_the_sensors_own_law():
    sensor = GradedSensor(2.0, 9)
    sensing = Sensing(GRID, (Agent(radius_m=200.0, map_sensor=sensor, target_sensor=sensor),))
    occupied = np.arange(GRID.n_cells) % 2 == 0
    counts = np.zeros((2, 2, sensor.levels))
    for second in range(60):
        log = looks(sensing, [(75.0, 50.0)], second, np.flatnonzero(occupied))
        cells = log.cells[: log.end]
        for kind, (signal, levels) in enumerate([(NODES, log.map_levels), (occupied, log.target_levels)]):
            for there in (0, 1):
                counts[kind, there] += np.bincount(levels[: log.end][signal[cells] == there], minlength=sensor.levels)
    rng = np.random.default_rng(1)
    for there in (0, 1):
        drawn = np.bincount(sensor.draw(np.full(400_000, bool(there)), rng), minlength=sensor.levels)
        often = drawn > 100
        for kind in (0, 1):
            expected = drawn[often] / drawn[often].sum() * counts[kind, there][often].sum()
            assert chisquare(counts[kind, there][often], expected).pvalue > 0.001


def test_the_two_sensors_and_all_seconds_agents_and_cells_are_independent():
    sensing = Sensing(GRID, (Agent(radius_m=300.0),) * 2)
    read = []
    for second in (0, 1):
        log = looks(sensing, [(75, 50), (75, 50)], second)
        order = np.lexsort((log.cells[: log.end], log.agents[: log.end]))
        read += [levels[: log.end][order].reshape(2, -1) for levels in (log.map_levels, log.target_levels)]
    noise = np.concatenate(read).astype(float)[:, ~NODES]
    off = np.corrcoef(noise)[~np.eye(len(noise), dtype=bool)]
    assert np.abs(off).max() < 4.5 / np.sqrt(noise.shape[1])


def test_a_reading_depends_on_seed_second_agent_and_cell_alone():
    sensing = Sensing(GRID, (Agent(),) * 2)
    one, other = looks(sensing, [(40, 40), (90, 40)]), looks(sensing, [(45, 42), (20, 80)])
    n = one.end
    first = dict(zip(one.cells[:n][one.agents[:n] == 0].tolist(), one.map_levels[:n].tolist(), strict=False))
    mine = other.agents[: other.end] == 0
    again = zip(other.cells[: other.end][mine].tolist(), other.map_levels[: other.end][mine].tolist(), strict=True)
    both = [(first[cell], level) for cell, level in again if cell in first]
    assert len(both) > 10
    assert all(x == y for x, y in both)
    assert looks(sensing, [(40, 40), (90, 40)], seed=6).map_levels[:n].tolist() != one.map_levels[:n].tolist()


def test_unlike_sensors_read_and_weigh_by_their_own_levels():
    blind, sharp = GradedSensor(0.0, 5), GradedSensor(6.0, 31)
    sensing = Sensing(GRID, (Agent(map_sensor=blind), Agent(map_sensor=sharp)))
    log = looks(sensing, [(40, 40), (90, 40)])
    mine = log.agents[: log.end] == 0
    assert log.map_levels[: log.end][mine].max() < 5
    np.testing.assert_allclose(log.map_ratios[: log.end][mine], 1.0)
    theirs = log.map_levels[: log.end][~mine]
    np.testing.assert_allclose(log.map_ratios[: log.end][~mine], sharp.likelihood_ratios[theirs])


def test_a_kept_log_grows_and_keeps_what_it_had():
    sensing = Sensing(GRID, (Agent(),))
    log = LookLog(1, keep=True)
    for second in range(9):
        sensing.look(second, np.array([[40.0, 40.0]]), NODES, np.array([], np.int64), 5, log)
    for second, first in enumerate(log.firsts):
        alone = looks(sensing, [(40, 40)], second)
        np.testing.assert_array_equal(log.map_levels[first : first + alone.end], alone.map_levels[: alone.end])


def test_targets_fall_into_their_cells_or_half_a_cell_away():
    places = np.array([[0.0, 0.0], [7.4, 12.0], [-2.6, 0.0]])
    exact, half = (Sensing(GRID, (Agent(),), offset).cells_of(places) for offset in ((0.0, 0.0), HALF_CELL))
    assert exact.tolist() == [GRID.index((19, 0)), GRID.index((17, 1)), -1]
    assert half.tolist() == [GRID.index((18, 1)), GRID.index((16, 2)), GRID.index((18, 0))]


def test_an_agent_that_does_not_see_the_cell_beneath_it_is_refused():
    assert Sensing(GRID, (Agent(radius_m=GRID.cell_m / 2),)).most_looks > 0
    with pytest.raises(InvalidProblemError, match="expected at least half a cell"):
        Sensing(GRID, (Agent(), Agent(radius_m=1e-9)))


def test_an_offset_of_more_than_a_cell_is_refused():
    with pytest.raises(InvalidProblemError, match="expected at most a cell"):
        Sensing(GRID, (Agent(),), (2.0, 0.0))
