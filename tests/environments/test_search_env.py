"""An environment is the simulator: same searches, same scores, nothing that a team does not know."""

from dataclasses import replace

import gymnasium
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from sooner.environments import SearchEnv, SearchParallelEnv, generated_scenes
from sooner.errors import InvalidProblemError
from sooner.scenarios import street_grid
from sooner.sensors.graded import GradedSensor
from sooner.simulation import Agent, Scene, load_episode, save_episode
from tests.environments.small import assert_same_flight, flown, scene, wandering


@settings(max_examples=25)
@given(
    seed=st.integers(0, 2**40),
    n_targets=st.integers(0, 3),
    seconds=st.integers(1, 33),
    replan_s=st.integers(1, 7),
    waypoints=st.integers(1, 3),
)
def test_whatever_is_done_the_return_is_e_and_observations_are_in_their_space(
    seed, n_targets, seconds, replan_s, waypoints
):
    env = SearchEnv(scene(seconds, min(replan_s, seconds), n_targets), waypoints=waypoints)
    env.action_space.seed(seed % 2**32)
    rewards, infos, observations = flown(env, lambda _: env.action_space.sample(), seed=seed)
    episode = env.episode
    score = episode.e if n_targets else episode.e_nodes
    assert sum(rewards) == pytest.approx(score, rel=0, abs=1e-12)
    assert infos[-1]["e"] == score
    assert min(rewards) >= 0.0
    assert len(rewards) == -(-seconds // min(replan_s, seconds))
    assert all(observation in env.observation_space for observation in observations)
    assert infos[-1]["second"] == seconds
    assert infos[-1]["calls"] == len(episode.calls)
    assert infos[-1]["false_calls"] == episode.false_calls
    assert infos[-1]["nodes"] == pytest.approx((episode.found_nodes >= 0).mean())


def test_what_is_in_view_at_the_start_is_in_the_first_reward():
    sharp = GradedSensor(12.0, 61)
    env = SearchEnv(replace(scene(), agents=(Agent(map_sensor=sharp),) * 4, starts_m=np.full((4, 2), 35.0)))
    rewards, _, _ = flown(env, lambda _: np.zeros((4, 1, 2)), seed=0)
    at_once = env.episode.found_nodes == 0
    assert at_once.any()
    assert rewards[0] >= 0.5 * at_once.mean()


def test_a_policy_is_shown_what_the_team_believes():
    env = SearchEnv(scene())
    env.reset(seed=2)
    for _ in range(5):
        observation, *_ = env.step(env.action_space.sample())
        situation = env.turns.situation
        for layer, name in enumerate(("void", "occupied", "explored", "nodes")):
            told = getattr(situation.states, name).reshape(20, 20).astype(np.float32)
            np.testing.assert_array_equal(observation["maps"][layer], told)
        place, velocity, aim = np.split(observation["agents"].astype(float), 3, axis=1)
        np.testing.assert_allclose(-2.5 + 50.0 * (place + 1.0), situation.places_m, atol=1e-4)
        np.testing.assert_allclose(3.0 * velocity, situation.velocities_mps, atol=1e-6)
        aims = np.array([route[0] for route in situation.routes])
        np.testing.assert_allclose(-2.5 + 50.0 * (aim + 1.0), aims, atol=1e-4)
        assert observation["time_left"] == np.float32(1.0 - situation.now_s / 40.0)
    assert not np.shares_memory(observation["maps"], situation.states.void)


def test_a_policy_is_shown_where_looks_may_be_in_vain():
    glimpse = np.linspace(0.1, 0.9, 400)
    shaded = SearchEnv(replace(scene(), glimpse=glimpse))
    rewards, _, observations = flown(shaded, wandering(), seed=0)
    for observation in observations:
        np.testing.assert_allclose(observation["maps"][4].ravel(), glimpse, atol=1e-6)
    assert sum(rewards) == pytest.approx(shaded.episode.e, rel=0, abs=1e-12)
    assert (flown(SearchEnv(scene()), wandering(), seed=0)[2][0]["maps"][4] == 1.0).all()


def test_an_action_is_a_place_on_the_ground():
    """West is -1 and south is -1: an agent sent to a corner hovers there."""
    env = SearchEnv(scene(seconds=80, replan_s=80))
    corners = np.array([[[-1.0, -1.0]], [[1.0, -1.0]], [[1.0, 1.0]], [[-1.0, 1.0]]])
    env.reset(seed=0)
    env.step(corners)
    ends = np.array([[-2.5, -2.5], [97.5, -2.5], [97.5, 97.5], [-2.5, 97.5]])
    np.testing.assert_allclose(env.episode.places_m[-1], ends, atol=0.5)


def test_agents_that_overshoot_the_ground_by_far_are_shown_at_its_bound():
    fast = Scene(scene(side=10).world, (Agent(v_max=60.0, a_max=10.0),), seconds=30)
    env, side = SearchEnv(fast), [1.0]

    def to_and_fro(_):
        side[0] = -side[0]
        return np.full((1, 1, 2), side[0])

    _, _, observations = flown(env, to_and_fro, seed=0)
    assert all(observation in env.observation_space for observation in observations)


def test_a_seed_settles_everything_and_another_seed_another_search():
    env, policy = SearchEnv((scene(), scene(60))), wandering()
    one, other = flown(env, policy, seed=8), flown(env, policy, seed=9)
    again = flown(SearchEnv((scene(), scene(60))), policy, seed=8)
    assert one[0] == again[0]
    assert one[1] == again[1]
    assert one[0] != other[0]


def test_searches_that_the_environment_draws_follow_from_the_last_seed_and_are_not_those_reported():
    env = SearchEnv((scene(), scene(60)))

    def drawn():
        env.reset(seed=3)
        return [(info["scene"], info["seed"]) for _, info in (env.reset() for _ in range(20))]

    first = drawn()
    assert first == drawn()
    assert {number for number, _ in first} == {0, 1}
    assert len({seed for _, seed in first}) == 20
    assert min(seed for _, seed in first) >= 2**31


def test_options_ask_for_a_scene_and_those_of_others_are_left_alone():
    env = SearchEnv((scene(), scene(60)))
    for wanted in (1, 0, np.int64(1)):
        _, info = env.reset(seed=0, options={"scene": wanted, "somebody": "else's"})
        assert info["scene"] == wanted
        assert env.turns.scene.seconds == (40, 60)[wanted]


@pytest.mark.parametrize("policy", [wandering(), lambda _: np.zeros((4, 1, 2), np.float32)])
def test_agents_led_each_by_itself_fly_as_the_team_does(policy):
    team, each = SearchEnv(scene(60)), SearchParallelEnv(scene(60))
    observation, _ = team.reset(seed=6)
    observations, _ = each.reset(seed=6)
    while each.agents:
        for number, agent in enumerate(each.agents):
            own = observations[agent]
            np.testing.assert_array_equal(own["maps"], observation["maps"])
            np.testing.assert_array_equal(np.roll(own["agents"], number, axis=0), observation["agents"])
            np.testing.assert_array_equal(own["agents"][0], observation["agents"][number])
        action = policy(observation)
        observation, reward, over, _, info = team.step(action)
        observations, rewards, overs, cut, infos = each.step(dict(zip(each.agents, action, strict=True)))
        assert set(rewards.values()) == {reward}
        assert set(overs.values()) == {over}
        assert not any(cut.values())
        assert infos["agent_3"] == info
    assert over
    assert_same_flight(team.episode, each.episode)


def test_agents_do_not_share_arrays():
    observations, _ = SearchParallelEnv(scene()).reset(seed=0)
    for name, array in observations["agent_0"].items():
        assert not np.shares_memory(array, observations["agent_1"][name])


def test_a_picture_of_now_is_drawn_where_it_was_asked_for():
    env = SearchEnv(scene(), render_mode="rgb_array")
    env.reset(seed=0)
    before = env.render()
    env.step(env.action_space.sample())
    after = env.render()
    assert before.shape == after.shape == (378, 350, 3)
    assert before.dtype == np.uint8
    assert (before != after).any()
    silent = SearchEnv(scene())
    silent.reset(seed=0)
    assert silent.render() is None


def test_an_episode_of_an_environment_can_be_kept(tmp_path):
    env = SearchEnv(scene())
    flown(env, wandering(), seed=1)
    save_episode(env.episode, tmp_path / "episode.npz")
    again = load_episode(tmp_path / "episode.npz")
    assert again.strategy is None
    assert_same_flight(env.episode, again)
    assert len(again.plans) == 8


def test_cities_to_train_in_differ_and_come_again():
    scenes = generated_scenes(iter(range(4)), seconds=30)
    for seed, (kind, each) in enumerate(zip(("gridiron", "suburb", "park", "gridiron"), scenes, strict=True)):
        np.testing.assert_array_equal(each.world.graph.cells, street_grid(kind, seed).cells)
        assert each.seconds == 30


@pytest.mark.parametrize(
    ("action", "told"),
    [
        (np.zeros((4, 2)), r"shape \(4, 2\)"),
        (np.zeros((3, 1, 2)), r"shape \(3, 1, 2\)"),
        (np.zeros((4, 2, 2)), r"shape \(4, 2, 2\)"),
        ([[[0, 0]], [[0]], [[0, 0]], [[0, 0]]], "no array"),
        (np.full((4, 1, 2), 1.1), "1.1 came"),
        (np.full((4, 1, 2), np.nan), "nan came"),
        (np.full((4, 1, 2), -np.inf), "inf came"),
    ],
)
def test_an_action_that_is_none_is_refused(action, told):
    env = SearchEnv(scene())
    env.reset(seed=0)
    with pytest.raises(InvalidProblemError, match=told):
        env.step(action)
    each = SearchParallelEnv(scene())
    each.reset(seed=0)
    with pytest.raises(InvalidProblemError):
        each.step(dict(zip(each.agents, action, strict=False)))


@pytest.mark.parametrize(
    ("settings", "told"),
    [
        ({"scenes": ()}, "no scenes"),
        ({"scenes": (scene(), scene(side=10))}, "10 x 10 cells and 4 agents, 20 x 20"),
        ({"scenes": (scene(), replace(scene(), agents=(Agent(),)))}, "20 x 20 cells and 1 agents"),
        ({"scenes": ["a"]}, "'a' came among scenes; expected a Scene"),
        ({"scenes": 3}, "3 came among scenes"),
        ({"waypoints": 0}, "0 waypoints"),
        ({"waypoints": 1.5}, "1.5 waypoints an action came; expected a whole number"),
        ({"waypoints": 101}, "101 waypoints"),
        ({"capture": -0.1}, "capture = -0.1"),
        ({"capture": np.nan}, "capture = nan"),
        ({"render_mode": "human"}, "'human' came"),
    ],
)
def test_an_environment_that_cannot_be_is_refused(settings, told):
    for kind in (SearchEnv, SearchParallelEnv):
        with pytest.raises(InvalidProblemError, match=told):
            kind(**{"scenes": scene(), **settings})


@pytest.mark.parametrize("wanted", [2, -1, 0.0, True, "0"])
def test_a_scene_that_is_not_there_is_refused(wanted):
    with pytest.raises(InvalidProblemError, match="expected a whole number from 0 to 1"):
        SearchEnv((scene(), scene(60))).reset(options={"scene": wanted})


def test_options_that_are_no_mapping_are_refused():
    with pytest.raises(InvalidProblemError, match=r"options = \[1\] came; expected a mapping"):
        SearchEnv(scene()).reset(options=[1])


@pytest.mark.parametrize(
    ("seeds", "settings", "told"),
    [
        (["a"], {}, "seed 'a' came; expected whole numbers"),
        (3, {}, "seeds = 3 came"),
        ([0], {"seconds": 10.5}, "seconds = 10.5 came; expected whole seconds"),
    ],
)
def test_scenes_that_cannot_be_generated_are_refused(seeds, settings, told):
    with pytest.raises(InvalidProblemError, match=told):
        generated_scenes(seeds, **settings)


def test_steps_before_the_start_and_after_the_end_are_refused():
    env = SearchEnv(scene(5))
    with pytest.raises(InvalidProblemError, match="expected reset"):
        env.step(np.zeros((4, 1, 2)))
    env.reset(seed=0)
    env.step(np.zeros((4, 1, 2)))
    with pytest.raises(InvalidProblemError, match="after the end"):
        env.step(np.zeros((4, 1, 2)))


def test_actions_of_others_are_refused():
    env = SearchParallelEnv(scene())
    env.reset(seed=0)
    with pytest.raises(InvalidProblemError, match="actions of agent_7 came"):
        env.step({"agent_7": np.zeros((1, 2))})
    with pytest.raises(InvalidProblemError, match="actions of nobody came"):
        env.step({})


def test_both_faces_draw_the_same_searches():
    team, each = SearchEnv((scene(), scene(60))), SearchParallelEnv((scene(), scene(60)))
    team.reset(seed=5)
    each.reset(seed=5)
    for _ in range(5):
        assert team.reset()[1] == each.reset()[1]["agent_2"]


def test_a_negative_seed_is_refused():
    for env in (SearchEnv(scene()), SearchParallelEnv(scene())):
        with pytest.raises(gymnasium.error.Error, match="Seed must be"):
            env.reset(seed=-1)
