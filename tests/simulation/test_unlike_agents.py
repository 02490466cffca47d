"""Agents that are not alike: plans fly, look and value by each one's own body and sensors."""

from dataclasses import replace

import numpy as np
import pytest

from sooner.belief import CellStates
from sooner.sensors import GradedSensor
from sooner.simulation import Agent, Estimator, Scene, World, simulate
from sooner.simulation.strategies import make_strategy
from sooner.simulation.strategies._task_kernels import assign
from sooner.simulation.strategies.information import Information
from sooner.simulation.strategies.joint import lane_layouts
from sooner.simulation.strategies.strategy import Situation

from .streets import blocks

GRAPH = blocks()
GRID = GRAPH.grid
BLIND, POOR, SHARP = (GradedSensor(m) for m in (0.0, 1.0, 5.0))


def situation(agents, states=None):
    rng = np.random.default_rng(3)
    return Situation(
        grid=GRID,
        agents=agents,
        now_s=0.0,
        end_s=120.0,
        replan_s=5.0,
        places_m=rng.uniform(0.0, 95.0, (len(agents), 2)),
        velocities_mps=np.zeros((len(agents), 2)),
        routes=tuple(np.empty((0, 2)) for _ in agents),
        states=CellStates.unknown(GRID.n_cells) if states is None else states,
        sought=True,
        found=False,
        graph=GRAPH,
    )


def assigned(shares, left, n_agents=2):
    """Two agents side by side and tasks to the east of them: routes, and what they leave."""
    tasks = np.stack([np.tile(np.arange(25.0, 95.0, 10.0), 4), np.repeat(np.arange(20.0, 60.0, 10.0), 7)], axis=1)
    places = np.array([[15.0, 30.0], [15.0, 40.0]])[:n_agents]
    left, routes = left.copy(), np.empty((n_agents, 3, 2))
    assign(
        places, np.zeros((n_agents, 2)), np.full(n_agents, 3.0), np.full(n_agents, 2.0), np.full(n_agents, 12.5),
        np.full(n_agents, 1.25), tasks, np.full(n_agents, len(tasks) - 1), left, shares[:n_agents], np.arange(n_agents),
        *GRID.shape, 5.0, 15, True, 0.2, routes,
    )  # fmt: skip
    return routes, left


def test_a_blind_mate_takes_nothing_and_a_poor_one_some():
    left = np.random.default_rng(1).random(GRID.n_cells)
    sharp, poor, blind = np.ones(GRID.n_cells), np.full(GRID.n_cells, 0.2), np.zeros(GRID.n_cells)
    alone = assigned(np.stack([blind, blind]), left)[1]
    np.testing.assert_array_equal(alone, left)
    beside = [assigned(np.stack([blind, mate]), left)[1].sum() for mate in (blind, poor, sharp)]
    assert beside[0] > beside[1] > beside[2]
    assert (assigned(np.stack([sharp, sharp]), left)[1] == 0.0).sum() > 100


def test_the_sharpest_look_takes_all_and_others_their_share():
    team = tuple(Agent(map_sensor=sensor, target_sensor=sensor) for sensor in (BLIND, POOR, SHARP))
    now = situation(team)
    blind, poor, sharp = Information().session(now, np.random.default_rng(1)).information(now)
    assert np.abs(blind).max() < 1e-9
    assert (poor > 0.0).all()
    assert (poor < 0.5 * sharp).all()


@pytest.mark.parametrize("strategy", ["information", "swept_information", "rollouts", "joint"])
def test_a_team_with_a_blind_agent_flies_and_finds(strategy):
    blind = Agent(map_sensor=BLIND, target_sensor=BLIND)
    scene = Scene(World(GRAPH), (Agent(), blind), Estimator(prior="kriged"), seconds=60)
    flown = simulate(scene, make_strategy(strategy), seed=2)
    assert flown.nodes_curve[-1] > 0.25


def test_lanes_are_as_wide_as_each_agent_sees():
    """A drone that sees 20 m off needs fewer lanes than one that sees 5 m; of equals there is one width."""
    near, far = Agent(radius_m=5.0), Agent(radius_m=20.0)
    ways = [{len(way) for _, ways in layout for way in ways} for layout in lane_layouts(GRID, (near, far))]
    assert all(max(lengths) > 2 * min(lengths) for lengths in ways)
    for both, one in zip(lane_layouts(GRID, (near, far)), lane_layouts(GRID, (near, near)), strict=True):
        for (_, of_both), (_, of_one) in zip(both, one, strict=True):
            assert len(of_both) == 2 * len(of_one)
            for way, same in zip(of_both, of_one, strict=False):
                np.testing.assert_array_equal(way, same)


class _AsIfEqual:
    """A strategy that takes all agents for the mean one."""

    def __init__(self, strategy, mean):
        self.strategy, self.mean, self.capture, self.starts = strategy, mean, strategy.capture, strategy.starts

    def session(self, situation, rng):
        session = self.strategy.session(replace(situation, agents=(self.mean,) * len(situation.agents)), rng)
        routes = session.routes
        session.routes = lambda now: routes(replace(now, agents=(self.mean,) * len(now.agents)))
        return session


@pytest.mark.parametrize(("strategy", "flights"), [("swept_information", 35), ("joint", 10)])
def test_planned_as_they_are_unlike_agents_find_more_streets(strategy, flights):
    """One sees 6 m off, the other 24 m; both fly what a plan for two that see 15 m off says, or what is theirs."""
    team = Agent(radius_m=6.0), Agent(radius_m=24.0)
    scene = Scene(World(blocks(24)), team, seconds=90)
    told, equal = (
        np.array([simulate(scene, each, seed).e_nodes for seed in range(flights)])
        for each in (make_strategy(strategy), _AsIfEqual(make_strategy(strategy), Agent(radius_m=15.0)))
    )
    apart = told - equal
    assert apart.mean() > 4 * apart.std(ddof=1) / np.sqrt(len(apart))
