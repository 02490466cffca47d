"""Drones in the air at once keep apart, or take off later; what is told is what two flown tracks come to."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from sooner.errors import DataFormatError
from sooner.missions import read_mission
from sooner.missions.flight_plans import flights
from sooner.missions.leg_tracks import leg_track
from sooner.missions.separation import STEP_S, Apart, Track, closest, separated
from tests.missions.leg_missions import leg_mission, there_and_back

APART = Apart(30.0, 10.0)
ROUND, FAR = [[200, 900], [800, 900], [800, 100]], [[1400, 900], [1400, 300]]


def random_track(number, rng, lasts=60.0):
    """A flight of a few straight legs in a small box, where meetings are likely."""
    times = np.linspace(0.0, lasts, 6) + rng.uniform(0, 30)
    return Track(number, number, f"drone {number}", times, rng.uniform([0, 0, 40], [300, 300, 80], (6, 3)))


def finely(a, b, later_a, later_b, apart=APART):
    """The nearest of a hundred looks a second, by the plain definition; None where never both are in the air."""
    low = max(a.times[0] + later_a, b.times[0] + later_b)
    high = min(a.times[-1] + later_a, b.times[-1] + later_b)
    if low > high:
        return None
    times = np.linspace(low, high, int((high - low) * 100) + 2)
    away = a.at(times - later_a) - b.at(times - later_b)
    return float(np.maximum(np.hypot(*away[:, :2].T) / apart.horizontal_m, np.abs(away[:, 2]) / apart.vertical_m).min())


@settings(max_examples=60)
@given(st.integers(0, 2**32 - 1), st.floats(0, 40))
def test_the_closest_approach_is_never_told_too_far_and_hardly_too_near(seed, later):
    rng = np.random.default_rng(seed)
    a, b = random_track(0, rng), random_track(1, rng)
    met, true = closest(a, b, APART, 0.0, later), finely(a, b, 0.0, later)
    assert (met is None) == (true is None)
    if met is not None:
        assert met.share <= true + 1e-9
        assert met.share >= true - 1.2  # of two moments in one half second, at up to some 40 m/s
        assert max(met.horizontal_m / 30.0, met.vertical_m / 10.0) == pytest.approx(met.share)


@settings(max_examples=30)
@given(st.integers(0, 2**32 - 1), st.integers(2, 5))
def test_delays_keep_all_apart_and_are_whole_steps(seed, count):
    rng = np.random.default_rng(seed)
    tracks = [random_track(number, rng) for number in range(count)]
    found = separated(tracks, APART)
    assert all(delay % STEP_S == 0 for delay in found.delays_s)
    assert 0.0 in found.delays_s
    for a, later_a in zip(tracks, found.delays_s, strict=True):
        for b, later_b in zip(tracks, found.delays_s, strict=True):
            if a.number < b.number:
                near = finely(a, b, later_a, later_b)
                assert near is None or near >= 1.0 - 1e-9
    assert found.ends_s == max(t.times[-1] + d for t, d in zip(tracks, found.delays_s, strict=True))
    assert all(met.share >= 1.0 for met in found.meetings)


def test_flights_of_one_drone_do_not_overtake_each_other():
    rng = np.random.default_rng(1)
    first, second = random_track(0, rng), random_track(1, rng)
    third = Track(2, 1, "drone 1 again", second.times[-1] + 10.0 + first.times, first.places)
    delays = separated([first, second, third], APART).delays_s
    assert delays[2] >= delays[1]


def test_apart_in_height_they_need_not_wait():
    times, line = np.array([0.0, 100.0]), np.array([[0.0, 0.0, 60.0], [1000.0, 0.0, 60.0]])
    low, high = Track(0, 0, "low", times, line), Track(1, 1, "high", times, line + np.array([0, 0, 15]))
    found = separated([low, high], APART)
    assert found.delays_s == (0.0, 0.0)
    assert (found.meetings[0].horizontal_m, found.meetings[0].vertical_m) == (0.0, 15.0)
    assert separated([low, high], Apart(30.0, 20.0)).delays_s == (0.0, 5.0)


# ---------------------------------------------------------------- of missions


@pytest.mark.parametrize("hilly", [False, True])
def test_from_one_place_at_one_moment_they_take_off_one_after_the_other(tmp_path, hilly):
    score = there_and_back(leg_mission(tmp_path, 3, 2, hilly), ROUND, FAR)
    told = flights(score)
    delays = told.separation.delays_s
    assert delays[0] == 0.0
    assert 0.0 < delays[2] < delays[4] < 120.0
    planned = [moves.moves.departs_s for moves in score.mission.problem.searchers]
    for plan, departs, delay, sortie in zip(told.plans, planned, delays, score.mission.sorties, strict=True):
        assert plan.departs_s == pytest.approx(departs - sortie.takeoff_s + delay)
    assert sum("takes off" in note for note in told.notes) == sum(delay > 0 for delay in delays)
    assert any("come nearest to each other" in note for note in told.notes)
    tracks = [leg_track(score, number, plan) for number, plan in enumerate(told.plans)]
    for a in tracks:
        for b in tracks:
            near = None if a.drone >= b.drone else finely(a, b, 0.0, 0.0)
            assert near is None or near >= 1.0 - 1e-9


def test_a_track_goes_up_along_the_plan_and_down(tmp_path):
    score = there_and_back(leg_mission(tmp_path, 2, 1, True), ROUND)
    plan = flights(score).plans[0]
    track, home_m = leg_track(score, 0, plan), plan.home_altitude_m
    assert track.times[-1] - track.times[0] == pytest.approx(plan.takeoff_s + plan.duration_s + plan.landing_s)
    assert (np.diff(track.times) >= 0).all()
    assert track.places[[0, -1], 2] == pytest.approx([home_m, home_m], abs=1e-6)
    (up,) = track.at(np.array([plan.takeoff_s]))
    assert up[2] == pytest.approx(home_m + plan.waypoints[0].altitude_m, abs=0.01)
    speeds = np.linalg.norm(np.diff(track.places, axis=0), axis=1) / np.maximum(np.diff(track.times), 1e-9)
    moved = np.diff(track.times) > 1e-6
    assert speeds[moved].max() < np.hypot(12.0, 4.0)
    assert np.linalg.norm(np.diff(track.places, axis=0), axis=1)[~moved].max(initial=0.0) < 0.01


def test_heights_of_their_own_or_wishes_of_the_mission_change_who_waits(tmp_path):
    path = leg_mission(tmp_path, 2)
    _, two = path.read_text().split("[[searcher]]")[1:]
    higher = path.read_text().replace("[[searcher]]" + two, "[[searcher]]\naltitude_m = 75" + two)
    path.write_text(higher)
    waits = flights(there_and_back(path, ROUND)).separation.delays_s
    assert 0.0 < waits[1] < 30.0  # the columns of take-off are one still
    path.write_text(higher + "[separation]\nhorizontal_m = 200\nvertical_m = 40\n")
    assert flights(there_and_back(path, ROUND)).separation.delays_s[1] > waits[1]


def test_who_may_not_wait_is_refused_with_two_names_a_place_and_a_time(tmp_path):
    path = leg_mission(tmp_path, 2, more="[separation]\nwait_s = 0")
    with pytest.raises(
        DataFormatError, match=r"separation: drone 0 and drone 1 come within 0.0 m .* east, .* after 0 s"
    ):
        flights(there_and_back(path, ROUND))


def test_one_drone_has_nobody_to_keep_apart_from(tmp_path):
    assert flights(there_and_back(leg_mission(tmp_path, 1, 2), ROUND)).separation is None


def test_distances_between_drones_are_for_legs(tmp_path):
    path = leg_mission(tmp_path, 2, more="[separation]\nhorizontal_m = -1")
    with pytest.raises(DataFormatError, match=r"separation\.horizontal_m"):
        read_mission(path)
    path = leg_mission(tmp_path, 1, more="[separation]\nhorizontal_m = 20\n[budget]\nsteps = 40")
    path.write_text(path.read_text().replace('moves = "legs"\nvehicle = "vehicle.toml"\nbatteries = 1', ""))
    path.write_text(path.read_text().replace("radius_m = 60.0", ""))
    with pytest.raises(DataFormatError, match=r"separation: how far drones keep apart came"):
        read_mission(path)
