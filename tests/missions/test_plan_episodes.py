"""Episodes of plans: they are the trials, come back from files as they were, fly again the same, and are drawn."""

import io
import json
from itertools import pairwise

import numpy as np
import pytest
from PIL import Image

from sooner.belief import Belief, BetaGrid, EvidenceGrid
from sooner.errors import DataFormatError, IllegalPlanError, InvalidProblemError
from sooner.grid import Grid
from sooner.missions import plan_mission, score_plan
from sooner.missions.plan_episodes import plan_episode, replayed_plan
from sooner.missions.plan_trials import Flyover
from sooner.missions.replanned import Replanning
from sooner.simulation import load_episode, save_episode
from sooner.simulation.answers import AnswerModel
from sooner.simulation.plan_episode import Answers, Course, Flown, Intent, PlanEpisode
from sooner.simulation.plan_episode_file import load_plan_episode, plan_episode_npz
from sooner.simulation.plan_picture import animated_plan, plan_episode_picture
from tests.meddled import rewritten
from tests.missions.test_plan_trials import ALARMS, FLOWN, INFORMATION, OVER_CELLS, SMALL
from tests.missions.test_replanned import APART, HOME, RATES, TEAM, WING, mission_of

ONCE = {name: (text, None) for name, text in FLOWN.items()}
ANEW = {
    "a team over regions": (APART, 20.0),
    "regions and home again": (HOME + INFORMATION, 15.0),
    "a team over cells": (TEAM, 13.0),
    "a fixed wing": (WING, 13.0),
    "a person and false alarms": (ALARMS, 6.0),
    "rates": (RATES, 31.0),
}
CASES = ONCE | {f"{name}, planned anew": case for name, case in ANEW.items()}


@pytest.fixture
def flown(tmp_path):
    """(mission, plan, episode) of a mission's text."""

    def fly(text, every=None, seed=4):
        mission = mission_of(tmp_path, text)
        plan = plan_mission(mission, "greedy", seconds=0.2, seed=1).score.plan
        return mission, plan, plan_episode(mission, plan, seed, "greedy", every)

    return fly


@pytest.mark.parametrize("name", CASES)
def test_an_episode_is_the_trial_of_its_seed_and_comes_back_from_a_file(flown, tmp_path, name):
    text, every = CASES[name]
    mission, plan, episode = flown(text, every)
    trial = Replanning(mission, plan, "greedy", np.inf if every is None else every).flown(4)
    assert len(episode.there) == trial.there
    assert episode.false.sum() == trial.false_alarms
    if trial.there:
        assert np.isfinite(episode.found).sum() == trial.found
        assert np.isnan(trial.first) or episode.found.min() == trial.first
    data = plan_episode_npz(episode)
    (tmp_path / "episode.npz").write_bytes(data)
    loaded = load_episode(tmp_path / "episode.npz")
    save_episode(loaded, tmp_path / "again.npz")
    assert (tmp_path / "again.npz").read_bytes() == data
    assert loaded.flown.mission == mission.name
    assert plan_episode_npz(replayed_plan(loaded, mission)) == data


@pytest.mark.parametrize("name", ANEW)
def test_drones_fly_from_plan_to_plan_without_a_jump(flown, name):
    text, every = ANEW[name]
    mission, _, episode = flown(text, every)
    assert len(episode.plans) > 1
    for searcher, course in zip(mission.problem.searchers, episode.courses, strict=True):
        assert (np.diff(course.times) >= 0).all()
        assert course.times[-1] <= searcher.budget + 1e-6
        start, ground = mission.problem.grid.centres_m[mission.problem.grid.index(searcher.start)], episode.grid
        np.testing.assert_allclose(course.at(0.0), start)
        if searcher.end is not None:
            np.testing.assert_allclose(course.at(1e9), ground.centres_m[ground.index(searcher.end)])
    for plan in episode.plans[1:]:
        for course, whole in zip(plan.courses, episode.courses, strict=True):
            if len(course.times):
                np.testing.assert_allclose(course.places_m[0], whole.at(float(course.times[0])), atol=1e-6)


def test_looks_are_made_from_where_drones_are(flown):
    _, _, episode = flown(APART, 20.0)
    places = [
        episode.courses[who].at(when)
        for who, when in zip(episode.answers.searchers.tolist(), episode.answers.times.tolist(), strict=True)
    ]
    apart = np.linalg.norm(episode.grid.centres_m[episode.answers.cells] - places, axis=1)
    assert np.median(apart) < 6.0 + 4.0  # the radius and a cell: courses spread an action's time over its length


def test_without_replans_an_episode_is_the_flyover(flown):
    mission, plan, episode = flown(SMALL)
    assert len(episode.plans) == 1
    flyover = Flyover.of(score_plan(mission, plan))
    np.testing.assert_array_equal(episode.answers.cells, flyover.looks.cells)
    np.testing.assert_array_equal(episode.answers.times, flyover.looks.times)
    np.testing.assert_array_equal(episode.flown.actions[0], plan.actions[0])


def test_beliefs_follow_the_answers(flown):
    _, _, episode = flown(ALARMS, 6.0)
    poc, outside = episode.model.known.poc.ravel().copy(), 0.0
    for cell, yes, time in zip(episode.answers.cells, episode.answers.yes, episode.answers.times, strict=True):
        there, not_there = (0.6, 0.1) if yes else (0.4, 0.9)
        poc *= np.where(np.arange(poc.size) == cell, there, not_there)
        poc /= poc.sum() + outside
        if time in (0.0, 7.0, 25.0):
            np.testing.assert_allclose(episode.theta_at(time), poc, rtol=1e-9)


@pytest.mark.parametrize("text", [ALARMS, OVER_CELLS, RATES], ids=["person", "targets", "rates"])
def test_what_is_learnt_is_the_entropy_that_is_gone(flown, text):
    _, _, episode = flown(text)
    times, model = [0.0, 5.0, 24.0], episode.model
    expected = [model.bits(model.known) - model.bits(episode.known_at(time)) for time in times]
    np.testing.assert_allclose(episode.learnt_at(times), expected, atol=1e-9)


@pytest.mark.parametrize("text", [SMALL, ALARMS, RATES, APART], ids=["person", "alarms", "rates", "regions"])
def test_episodes_are_drawn(flown, text):
    _, _, episode = flown(text)
    drawn = plan_episode_picture(episode)
    assert drawn.startswith(b"\x89PNG")
    assert plan_episode_picture(episode) == drawn


def test_blocks_of_cells_are_drawn_where_there_are_too_many(flown, monkeypatch):
    _, _, episode = flown(ALARMS)
    drawn = plan_episode_picture(episode)
    monkeypatch.setattr("sooner.simulation.plan_picture.MOST_CELLS", 20)
    monkeypatch.setattr("sooner.simulation.plan_picture.MOST_TARGETS", 0)
    assert plan_episode_picture(episode) != drawn


def test_an_animation_moves(flown):
    _, _, episode = flown(APART, 20.0)
    with Image.open(io.BytesIO(animated_plan(episode, frames=4))) as film:
        assert film.n_frames == 4
        frames = []
        for number in range(4):
            film.seek(number)
            frames.append(np.asarray(film.convert("RGB")))
    assert all((one != other).any() for one, other in pairwise(frames))
    with pytest.raises(InvalidProblemError, match="frames came"):
        animated_plan(episode, frames=1)


def test_another_mission_flies_another_episode_or_none(flown, tmp_path):
    _, _, episode = flown(SMALL)
    with pytest.raises(InvalidProblemError, match="the mission has"):
        replayed_plan(episode, mission_of(tmp_path, OVER_CELLS))
    with pytest.raises(IllegalPlanError, match="starts at"):
        replayed_plan(episode, mission_of(tmp_path, SMALL.replace("[2, 2]", "[0, 0]")))


def about(**said):
    def changed(array):
        return np.frombuffer(json.dumps(json.loads(bytes(array)) | said).encode(), np.uint8)

    return changed


@pytest.mark.parametrize(
    "changes",
    [
        {"truth": None},
        {"extra": np.zeros(2)},
        {"about": np.zeros(4, np.uint8)},
        {"about": np.frombuffer(b"[" * 100_000, np.uint8)},
        {"about": about(format="sooner episode 1")},
        {"about": about(shape=[6])},
        {"about": about(shape=[10**9, 10**9])},
        {"about": about(shape=[6.0, 7.0])},
        {"about": about(connectivity="round")},
        {"about": about(cell_m=-1)},
        {"about": about(kind="rates")},
        {"about": about(kind="ghost")},
        {"about": about(false_alarm=2)},
        {"about": about(outside=0.5)},
        {"about": about(correlation="much")},
        {"about": about(seed=-1)},
        {"about": about(ticks=True)},
        {"about": about(every=-3)},
        {"about": about(unit="guesses")},
        {"about": about(mission=7)},
        {"known": lambda a: a * 2},
        {"known": lambda a: a * np.nan},
        {"detect": lambda a: a + 1},
        {"detect": lambda a: np.zeros(3)},
        {"truth": lambda a: a + 1},
        {"truth": lambda a: 0 * a},  # an alarm of nobody, from looks that raise no false ones
        {"looks_cells": lambda a: a + 10**6},
        {"looks_times": lambda a: a[::-1].copy()},
        {"looks_searchers": lambda a: a + 1},
        {"looks_yes": lambda a: a.astype(int)},
        {"actions": lambda a: a[1:]},
        {"action_counts": lambda a: 0 * a},
        {"action_counts": np.zeros(0, np.int64)},
        {"plan_times": lambda a: a + 1},
        {"course_lengths": lambda a: 0 * a},
        {"course_lengths": lambda a: -a},
        {"course_times": lambda a: a[::-1].copy()},
        {"course_places_m": lambda a: a[:, :1]},
    ],
    ids=lambda changes: next(iter(changes)),
)
def test_files_that_contradict_themselves_are_refused(flown, tmp_path, changes):
    _, _, episode = flown(SMALL.replace("0.5", "0.9"), seed=2)
    assert episode.answers.yes.any()
    path = tmp_path / "episode.npz"
    path.write_bytes(plan_episode_npz(episode))
    with pytest.raises(DataFormatError, match="expected an episode of a plan"):
        load_plan_episode(rewritten(path, **changes))


def test_damaged_files_are_refused(flown, tmp_path):
    whole, path = plan_episode_npz(flown(ALARMS)[2]), tmp_path / "episode.npz"
    rng = np.random.default_rng(0)
    for _ in range(60):
        damaged = bytearray(whole)
        for place in rng.integers(len(whole), size=8):
            damaged[place] = rng.integers(256)
        path.write_bytes(bytes(damaged))
        try:
            load_plan_episode(path)
        except DataFormatError:
            continue


@pytest.mark.parametrize("known", [Belief.from_weights(np.ones((2, 3))), EvidenceGrid.uniform((2, 3), 0.3)])
def test_obstacles_and_maps_without_a_size_in_metres_come_back(tmp_path, known):
    grid = Grid((2, 3), "hex", obstacles=np.arange(6).reshape(2, 3) == 4)
    episode = _bare(grid, AnswerModel(known, np.linspace(0.1, 0.9, 6)))
    path = tmp_path / "episode.npz"
    path.write_bytes(plan_episode_npz(episode))
    loaded = load_plan_episode(path)
    np.testing.assert_array_equal(loaded.grid.obstacles, grid.obstacles)
    assert plan_episode_npz(loaded) == path.read_bytes()
    assert plan_episode_picture(loaded).startswith(b"\x89PNG")


def _bare(grid, model):
    nothing = Answers(np.zeros(0, np.int64), np.zeros(0), np.zeros(0, np.int64), np.zeros(0, bool))
    course = Course(np.array([0.0, 1.0]), grid.centres_m[:2])
    wish = Flown("bare", 0, "greedy", None, 20, (np.array([0, 1]),), "probability", None)
    return PlanEpisode(grid, model, wish, np.zeros(grid.n_cells), nothing, (Intent(0.0, (course,)),))


def test_an_episode_of_other_cells_is_refused():
    with pytest.raises(InvalidProblemError, match="6 cells"):
        _bare(Grid((2, 3)), AnswerModel(BetaGrid.uniform((1, 3))))
