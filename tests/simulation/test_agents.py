"""Flight: near a fine integration, never faster or harder than the agent can."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.integrate import solve_ivp

from sooner.errors import InvalidProblemError
from sooner.simulation import Agent, Team, flight
from sooner.simulation._flight_kernels import STEP_S, fly, fly_to
from sooner.simulation.agents import STEP_S as AGENT_STEP_S

metres = st.floats(-150.0, 150.0)


def test_the_steps_of_flight_are_the_kernels_own():
    assert AGENT_STEP_S == STEP_S


@pytest.mark.parametrize("waypoint", [(3.0, 0.0), (40.0, 25.0), (-120.0, 60.0)])
def test_flight_to_a_waypoint_is_what_the_equations_say(waypoint):
    agent, aim = Agent(), np.array(waypoint)

    def derivative(_, state):
        thrust = 10.0 * (aim - state[:2]) - 5.0 * state[2:]
        thrust *= min(1.0, agent.a_max / max(np.hypot(*thrust), 1e-12))
        return np.concatenate([state[2:], thrust - agent.a_max / agent.v_max * state[2:]])

    exact = solve_ivp(derivative, (0, 60), [0, 0, 0, 1.0], t_eval=np.arange(61), rtol=1e-9, atol=1e-9, max_step=0.05)
    ours = flight(agent, (0, 0), [waypoint], capture_m=0.5, seconds=60, velocity=(0, 1.0))
    assert np.abs(ours - exact.y[:2].T).max() < 0.05


@given(st.lists(st.tuples(metres, metres), min_size=1, max_size=4), st.floats(0.5, 12.0), st.floats(0.5, 6.0))
def test_no_agent_passes_its_speed_or_its_thrust(route, v_max, a_max):
    legs = np.array([route])
    places, velocities, reached = np.zeros((1, 2)), np.zeros((1, 2)), np.zeros(1, np.int64)
    a = np.array([a_max])
    for _ in range(400):
        before = velocities.copy()
        fly(places, velocities, np.array([v_max]), a, a, legs, np.array([len(route)]), reached, STEP_S, STEP_S)
        assert np.hypot(*velocities[0]) <= v_max * (1 + 1e-12)
        change = (velocities - before)[0] / STEP_S
        assert np.hypot(*(change + a_max / v_max * before[0])) <= a_max * (1 + 1e-9)
        assert np.hypot(*change) <= 2 * a_max * (1 + 1e-9)


def test_waypoints_give_way_in_turn_and_the_last_holds():
    route = [(20.0, 0.0), (20.0, 20.0), (0.0, 20.0)]
    places = flight(Agent(), (0, 0), route, capture_m=1.25, seconds=60)
    for waypoint in route:
        assert np.hypot(*(places - waypoint).T).min() < 3.0
    assert places[-1] == pytest.approx(route[-1], abs=0.01)


def test_an_agent_without_a_route_comes_to_rest():
    places, velocities = np.zeros((1, 2)), np.array([[3.0, 0.0]])
    three, two = np.array([3.0]), np.array([2.0])
    fly(
        places,
        velocities,
        three,
        two,
        two,
        np.zeros((1, 1, 2)),
        np.zeros(1, np.int64),
        np.zeros(1, np.int64),
        20.0,
        STEP_S,
    )
    assert places[0] == pytest.approx([4.5, 0.0], abs=0.1)
    assert np.abs(velocities).max() < 1e-4


def test_a_rollout_is_the_flight_itself():
    agent = Agent(v_max=5.0, a_max=3.0)
    trace = np.zeros((64, 2))
    seconds, n, *_ = fly_to(0.0, 0.0, 1.0, 0.0, 60.0, 30.0, 5.0, 3.0, 1.25, 100.0, STEP_S, 1.0, trace)
    flown = flight(agent, (0, 0), [(60, 30)], capture_m=0.1, seconds=int(seconds), velocity=(1, 0))
    np.testing.assert_allclose(trace[: n - 1], flown[1:], atol=1e-9)
    assert np.hypot(*(trace[n - 1] - (60, 30))) <= 1.25
    assert n == int(seconds) + 1


def test_a_rollout_that_is_there_takes_no_time():
    trace = np.zeros((4, 2))
    assert fly_to(1.0, 2.0, 0.0, 0.0, 1.0, 2.0, 3.0, 2.0, 1.0, 10.0, STEP_S, 1.0, trace)[:2] == (0.0, 1)
    assert trace[0].tolist() == [1.0, 2.0]


def test_agents_of_a_team_do_not_touch_one_another():
    alone = flight(Agent(v_max=6.0), (0, 0), [(50, 0)], capture_m=1.0, seconds=10)
    team = Team((Agent(), Agent(v_max=6.0)))
    places, velocities = np.zeros((2, 2)), np.zeros((2, 2))
    routes = np.array([[[0.0, 50.0]], [[50.0, 0.0]]])
    one = np.ones(2, np.int64)
    fly(places, velocities, team.v_max, team.a_max, np.ones(2), routes, one, np.zeros(2, np.int64), 10.0, STEP_S)
    np.testing.assert_allclose(places[1], alone[-1])


@pytest.mark.parametrize(
    "bad", [{"v_max": 0.0}, {"a_max": np.nan}, {"radius_m": -1.0}, {"radius_m": 1e300}, {"v_max": 0.01, "a_max": 9.0}]
)
def test_impossible_agents_are_refused(bad):
    with pytest.raises(InvalidProblemError, match="expected"):
        Agent(**bad)


def test_a_team_has_agents():
    with pytest.raises(InvalidProblemError, match="expected 1 to"):
        Team(())
