"""The information strategy: each kernel against a plain one, and the whole against a reading of the paper in Python."""

import itertools

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.optimize import linear_sum_assignment

from sooner.belief import CellStates, state_entropy, state_information
from sooner.errors import InvalidProblemError
from sooner.grid import Grid
from sooner.sensors import GradedSensor
from sooner.simulation import Agent, Estimator, Scene, World, simulate
from sooner.simulation._flight_kernels import fly_to
from sooner.simulation.strategies._task_kernels import (
    assign,
    highest_in_view,
    lloyd,
    most_valuable,
    nearest_sites,
    taught_in_view,
)
from sooner.simulation.strategies.information import ROLLOUT_STEP_S, SWEPT_INFORMATION, UTILITIES, Information
from sooner.simulation.strategies.strategy import Situation

from .streets import blocks

GRID = Grid((13, 17), "square8", 5.0)
HEIGHT, WIDTH = GRID.shape
seeds = st.integers(0, 2**32 - 1)


def spread(rng: np.random.Generator, n: int, grid: Grid = GRID) -> np.ndarray:
    return rng.uniform(-2.5, 5.0 * np.array(grid.shape[::-1]) - 2.5, (n, 2))


def brute_owner(sites: np.ndarray) -> np.ndarray:
    return np.hypot(*(GRID.centres_m[:, None] - sites).T).argmin(axis=0)


def plain_lloyd(density: np.ndarray, sites: np.ndarray, gain: float, rounds: int) -> tuple[np.ndarray, np.ndarray]:
    for _ in range(rounds):
        owner = brute_owner(sites)
        middles = sites.copy()
        for site in np.unique(owner):
            own = owner == site
            middles[site] = density[own] @ GRID.centres_m[own] / density[own].sum()
        sites = sites + gain * (middles - sites)
    return sites, middles


@given(seeds, st.integers(1, 40))
def test_every_cell_belongs_to_the_nearest_site(seed: int, n: int) -> None:
    sites = spread(np.random.default_rng(seed), n)
    owner, reach = np.empty(GRID.n_cells, np.int32), np.full(HEIGHT, np.inf)
    nearest_sites(sites, HEIGHT, WIDTH, 5.0, reach, owner)
    apart = np.hypot(*(GRID.centres_m - sites[owner]).T)
    assert apart == pytest.approx(np.hypot(*(GRID.centres_m[:, None] - sites).T).min(axis=0), abs=1e-3)
    assert reach == pytest.approx(apart.reshape(GRID.shape).max(axis=1), abs=1e-3)


@given(seeds, st.integers(1, 40), st.integers(1, 12))
def test_lloyd_moves_sites_as_the_plain_algorithm_does(seed: int, n: int, rounds: int) -> None:
    rng = np.random.default_rng(seed)
    density, sites = rng.random(GRID.n_cells) ** 4 + 0.001, spread(rng, n)
    expected_sites, expected_middles = plain_lloyd(density, sites, 0.2, rounds)
    owner, middles = np.empty(GRID.n_cells, np.int32), np.empty((n, 2))
    assert lloyd(density, HEIGHT, WIDTH, 5.0, 0.2, rounds, 0.0, sites, owner, middles) <= rounds
    assert sites == pytest.approx(expected_sites, abs=1e-6)
    assert middles == pytest.approx(expected_middles, abs=1e-6)


def test_sites_gather_where_the_information_is_and_stay_once_they_are_there() -> None:
    density = np.exp(-GRID.centres_m[:, 0] / 15.0)
    sites, owner, middles = spread(np.random.default_rng(1), 20), np.empty(GRID.n_cells, np.int32), np.empty((20, 2))
    before = sites[:, 0].mean()
    settings = HEIGHT, WIDTH, 5.0, 0.2, 200, 0.1, sites, owner, middles
    assert lloyd(density, *settings) < 200
    assert middles[:, 0].mean() < 0.9 * before
    assert lloyd(density, *settings) == 1


@given(seeds, st.integers(1, 6), st.integers(0, 8))
def test_assignments_are_worth_as_much_as_the_best(seed: int, n: int, more: int) -> None:
    rng = np.random.default_rng(seed)
    utilities = rng.random((n, n + more)) * rng.choice([0.0, 1.0], (n, n + more))
    chosen = np.empty(n, np.int64)
    most_valuable(utilities, chosen)
    assert len(set(chosen.tolist())) == n
    rows, cols = linear_sum_assignment(utilities, maximize=True)
    assert utilities[np.arange(n), chosen].sum() == pytest.approx(utilities[rows, cols].sum(), abs=1e-12)


def test_assignments_are_the_best_of_all_permutations() -> None:
    rng = np.random.default_rng(4)
    for _ in range(20):
        utilities, chosen = rng.random((3, 5)), np.empty(3, np.int64)
        most_valuable(utilities, chosen)
        best = max(itertools.permutations(range(5), 3), key=lambda columns: utilities[range(3), columns].sum())
        assert tuple(chosen) == best


@given(seeds, st.floats(0.5, 20.0), st.booleans())
def test_looks_teach_of_cells_whose_centres_are_within_the_radius(seed: int, radius_m: float, sharp: bool) -> None:
    rng = np.random.default_rng(seed)
    left, (east, north) = rng.random(GRID.n_cells), spread(rng, 1)[0]
    share = np.ones(GRID.n_cells) if sharp else rng.random(GRID.n_cells)
    seen = np.hypot(*(GRID.centres_m - [east, north]).T) <= radius_m
    place = east / 5.0, north / 5.0, radius_m / 5.0
    assert highest_in_view(*place, left, share, HEIGHT, WIDTH) == max((left * share)[seen], default=0.0)
    marks, now = np.full(GRID.n_cells, -1), np.empty(GRID.n_cells)
    for look in range(3):
        taught = taught_in_view(*place, left, share, HEIGHT, WIDTH, 3, marks, now)
        assert taught == pytest.approx((left * share * (1 - share) ** look)[seen].sum(), abs=1e-12)
        assert not sharp or look == 0 or taught == 0.0
    assert ((marks == 3) == seen).all()


def looks_in_view(places: np.ndarray, radius_m: float) -> np.ndarray:
    return (np.hypot(*(GRID.centres_m[:, None] - places).T) <= radius_m).sum(axis=0)


def plain_assignment(
    team: list[Agent],
    places: np.ndarray,
    tasks: np.ndarray,
    left: np.ndarray,
    shares: np.ndarray,
    own: np.ndarray,
    utility: str,
) -> np.ndarray:
    """Section III.E read aloud; agent i's look takes `shares[i]` of what is left in each cell."""
    left, free = left.copy(), set(range(len(tasks)))
    states, routes = [(*place, 0.0, 0.0) for place in places], np.empty((len(team), 3, 2))
    trace = np.empty((512, 2))

    def flown(agent: Agent, state: tuple[float, ...], task: int) -> tuple[float, np.ndarray, tuple[float, ...]]:
        limits = agent.v_max, agent.a_max, 0.1 * agent.radius_m, 512.0, ROLLOUT_STEP_S, 1.0
        seconds, n, *after = fly_to(*state, *tasks[task], *limits, trace)
        return seconds, trace[:n].copy(), tuple(after)

    def taught(agent: Agent, way: np.ndarray, share: np.ndarray) -> float:
        if utility == "swept":
            return float((left * (1.0 - (1.0 - share) ** looks_in_view(way, agent.radius_m))).sum())
        highest = [(left * share)[looks_in_view(place[None], agent.radius_m) > 0].max(initial=0.0) for place in way]
        return float(max(highest, default=0.0) if utility == "maximum" else sum(highest))

    for step in range(3):
        R = np.zeros((len(team), len(tasks)))
        for i, agent in enumerate(team):
            candidates = free - {own[i]} if step == 0 else free
            for j in sorted(candidates, key=lambda j: np.hypot(*(tasks[j] - states[i][:2])))[:6]:
                seconds, way, _ = flown(agent, states[i], j)
                R[i, j] = (taught(agent, way, shares[i]) + 1e-9) / max(seconds, 1.0)
        columns = sorted(free)
        _, chosen = linear_sum_assignment(R[:, columns], maximize=True)
        for i, j in enumerate(np.array(columns)[chosen]):
            free.remove(j)
            _, way, states[i] = flown(team[i], states[i], j)
            left *= (1.0 - shares[i]) ** looks_in_view(way, team[i].radius_m)
            routes[i, step] = tasks[j]
    return routes


@pytest.mark.parametrize("utility", UTILITIES)
@pytest.mark.parametrize("alike", [True, False])
@pytest.mark.parametrize("seed", range(4))
def test_waypoints_are_those_of_the_paper_read_aloud(seed: int, alike: bool, utility: str) -> None:
    rng = np.random.default_rng(seed)
    team = [Agent(), Agent(v_max=5.0, a_max=3.0), Agent(radius_m=8.0)]
    tasks, places, left = spread(rng, 30), spread(rng, 3), rng.random(GRID.n_cells) ** 3
    shares = np.ones((3, GRID.n_cells)) if alike else rng.random((3, GRID.n_cells))
    own = np.hypot(*(places[:, None] - tasks).T).argmin(axis=0)
    expected = plain_assignment(team, places, tasks, left, shares, own, utility)
    routes, columns = np.empty((3, 3, 2)), [[getattr(a, name) for a in team] for name in ("v_max", "a_max", "radius_m")]
    v_max, a_max, radius = np.array(columns)
    assign(
        places, np.zeros((3, 2)), v_max, a_max, radius, 0.1 * radius, tasks, own, left.copy(), shares,
        np.arange(3), HEIGHT, WIDTH, 5.0, 6, UTILITIES.index(utility), ROLLOUT_STEP_S, routes,
    )  # fmt: skip
    assert routes == pytest.approx(expected)


def situation(agents: tuple[Agent, ...], seed: int = 0, states: CellStates | None = None) -> Situation:
    graph = blocks()
    rng = np.random.default_rng(seed)
    return Situation(
        grid=graph.grid,
        agents=agents,
        now_s=0.0,
        end_s=240.0,
        replan_s=5.0,
        places_m=spread(rng, len(agents), graph.grid),
        velocities_mps=np.zeros((len(agents), 2)),
        routes=tuple(np.empty((0, 2)) for _ in agents),
        states=CellStates.unknown(graph.grid.n_cells) if states is None else states,
        sought=True,
        found=False,
        graph=graph,
    )


def test_each_agent_gets_three_waypoints_and_no_waypoint_comes_twice() -> None:
    now = situation((Agent(),) * 4)
    before = [a.copy() for a in (now.states.void, now.states.occupied, now.places_m, now.velocities_mps)]
    routes = Information().session(now, np.random.default_rng(1)).routes(now)
    assert [route.shape for route in routes] == [(3, 2)] * 4
    assert len(np.unique(np.concatenate(routes), axis=0)) == 12
    after = now.states.void, now.states.occupied, now.places_m, now.velocities_mps
    assert all((a == b).all() for a, b in zip(before, after, strict=True))


def test_the_same_random_numbers_give_the_same_waypoints() -> None:
    now = situation((Agent(),) * 4)
    one, two = (Information().session(now, np.random.default_rng(1)).routes(now) for _ in range(2))
    assert (np.array(one) == np.array(two)).all()


def test_each_pair_of_sensors_has_its_own_information() -> None:
    weak = GradedSensor(1.0)
    team = Agent(), Agent(map_sensor=weak), Agent(), Agent(target_sensor=weak)
    now = situation(team)
    surfaces = Information().session(now, np.random.default_rng(1)).information(now)
    states, strong = now.states, GradedSensor()
    assert surfaces.shape == (3, 400)
    for surface, (g, z) in zip(surfaces, ((strong, strong), (weak, strong), (strong, weak)), strict=True):
        exact = state_information(states.void, states.unoccupied, states.occupied, g.p_levels, z.p_levels)
        assert surface == pytest.approx(exact, abs=4e-4)


def test_agents_fly_to_what_is_not_known() -> None:
    """All is known but for the eastern half."""
    states, open_ground = CellStates.unknown(400), blocks().grid.centres_m[:, 0] > 47.5
    known = CellStates(
        np.where(open_ground, states.void, 1.0), np.where(open_ground, states.unoccupied, 0.0),
        np.where(open_ground, states.occupied, 0.0), ~open_ground, np.zeros(400, bool),
    )  # fmt: skip
    assert (state_entropy(known.void, known.unoccupied, known.occupied) > 0).tolist() == open_ground.tolist()
    now = situation((Agent(),) * 2, states=known)
    now.places_m[:] = [[25.0, 30.0], [30.0, 70.0]]  # nobody sees it yet, but someone who flies 15 m east
    routes = Information().session(now, np.random.default_rng(1)).routes(now)
    assert (np.array(routes)[:, 0, 0] > 36.0).all()


@pytest.mark.parametrize("prior", ["uniform", "kriged", "known"])
@pytest.mark.parametrize("strategy", [Information(), SWEPT_INFORMATION])
def test_it_flies_with_every_prior(prior: str, strategy: Information) -> None:
    scene = Scene(World(blocks()), estimator=Estimator(prior=prior), seconds=60)
    flown = simulate(scene, strategy, seed=2)
    assert flown.e == simulate(scene, strategy, seed=2).e
    assert flown.nodes_curve[-1] > 0.7


def test_more_agents_than_tasks_can_serve_are_refused() -> None:
    now = situation((Agent(),) * 4)
    with pytest.raises(InvalidProblemError, match="expected at least 16"):
        Information(tasks=15).session(now, np.random.default_rng(1))
    assert len(Information(tasks=16).session(now, np.random.default_rng(1)).routes(now)) == 4


@pytest.mark.parametrize(
    "bad",
    [
        {"tasks": 0},
        {"waypoints": 1},
        {"neighbours": 0},
        {"rounds": 0},
        {"utility": "minimum"},
        {"capture": 0.0},
        {"arrive": -1.0},
        {"floor": 0.0},
        {"gain": 1.5},
        {"near_m": float("nan")},
    ],
)
def test_impossible_settings_are_refused(bad: dict[str, float]) -> None:
    with pytest.raises(InvalidProblemError, match="came; expected"):
        Information(**bad)
