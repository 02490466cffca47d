"""Plans that are made anew with what looks have answered."""

from dataclasses import dataclass, field, replace

import numpy as np
import pytest

from sooner.errors import DataFormatError
from sooner.missions import plan_mission, read_mission
from sooner.missions.estimates import Mean
from sooner.missions.plan_trials import PlanTrial, fly_plan
from sooner.missions.replanned import Replanning, check_replanning, fly_replanned
from sooner.problem import evaluate
from sooner.simulation.answers import theta_of
from sooner.simulation.hidden import Hidden
from tests.missions.test_plan_trials import ALARMS, EVIDENCE, INFORMATION, OVER_CELLS, POC, REGIONS, SMALL, THETA
from tests.small_mission import written

HOME = EVIDENCE.replace("start = [1, 1]", "start = [1, 1]\nend = [1, 1]")
TEAM = OVER_CELLS.replace("[budget]", "[[searcher]]\nstart = [13, 19]\n[budget]")
TWO_DRONES = EVIDENCE.replace("[budget]", REGIONS[REGIONS.index("[[") : REGIONS.index("[budget]")] + "[budget]")
APART = TWO_DRONES.replace("[1, 1]", "[12, 18]", 1).replace("[1, 1]", "[1, 1]\nend = [12, 1]")
RATES = OVER_CELLS.replace("detect = 0.8\nfalse_alarm = 0.1", 'model = "beta"') + INFORMATION
WING = OVER_CELLS.replace("[1, 1]", '[1, 1]\nkind = "fixed_wing"')
SPLIT = {
    "cells": (OVER_CELLS, 7.0),
    "a team": (TEAM, 7.0),
    "a fixed wing": (WING, 7.0),
    "bits": (OVER_CELLS + INFORMATION, 1.0),
    "regions": (EVIDENCE, 20.0),
    "regions and home again": (HOME, 15.0),
    "bits over regions": (HOME + INFORMATION, 0.1),
    "a team over regions": (APART, 5.0),
    "a team over regions that never rests": (APART + INFORMATION, 0.1),
    "a person and false alarms": (ALARMS, 6.0),
    "rates": (RATES, 7.0),
}


def mission_of(tmp_path, text):
    return read_mission(written(tmp_path, text, poc_csv=POC, theta_csv=THETA))


@dataclass(frozen=True, eq=False)
class Stubborn(Replanning):
    """Looks at what is left, and flies the old plan on."""

    def _better(self, problem, old, seed):
        evaluate(problem, old)  # it is legal
        return old


@pytest.mark.parametrize("name", SPLIT)
def test_a_plan_that_is_flown_in_parts_is_the_same_flight(tmp_path, name):
    text, every = SPLIT[name]
    mission = mission_of(tmp_path, text)
    score = plan_mission(mission, seconds=0.3, seed=1).score
    whole = list(fly_plan(score, range(6)))
    parts = [Stubborn(mission, score.plan, "anneal", every).flown(seed) for seed in range(6)]
    for one, other in zip(whole, parts, strict=True):
        assert replace(one, mean=0.0, first=0.0) == replace(other, mean=0.0, first=0.0)
        np.testing.assert_allclose([one.first, one.mean], [other.first, other.mean], rtol=1e-9)


@pytest.mark.slow
def test_answers_make_a_better_plan(tmp_path):
    text = OVER_CELLS.replace("steps = 60", "steps = 480").replace("false_alarm = 0.1", "false_alarm = 0.2")
    planned = plan_mission(mission_of(tmp_path, text + INFORMATION), seconds=0.5, seed=1)
    once = list(fly_plan(planned.score, range(8)))
    anew = list(fly_replanned(planned, 60.0, range(8)))  # 5.7 standard errors ahead; of 64 flights, 14
    ahead = Mean.of([other.value - one.value for one, other in zip(once, anew, strict=True)])
    assert ahead.value > 2.0 * ahead.error > 0.0


def test_answers_find_a_person_more_surely(tmp_path):
    """Alarms are not sounded twice: P(found | all answers), which is the chance that he is where one sounded."""
    text = ALARMS.replace("steps = 25", "steps = 80").replace("0.6", "0.5").replace("0.1", "0.3")
    mission = mission_of(tmp_path, text)
    plan = plan_mission(mission, "greedy", seconds=0.3, seed=1).score.plan

    def surely(every, seed):
        flight, hidden = Replanning(mission, plan, "greedy", every), Hidden(mission.sight.answers, seed)
        for stretch in flight.stretches(hidden, seed):
            hidden.look(stretch.soon.cells, stretch.soon.times)
        return theta_of(hidden.model.after(hidden.looks, hidden.hits))[hidden.hits > 0].sum()

    ahead = Mean.of([surely(8.0, seed) - surely(np.inf, seed) for seed in range(60)])
    assert ahead.value > 4.0 * ahead.error > 0.0


@dataclass(frozen=True, eq=False)
class Promising(Replanning):
    """Keeps what it has at each replan, and what the judge promises of the rest."""

    kept: list = field(default_factory=list)

    def _sight(self, hidden):
        self.kept.append(PlanTrial.told(0, self.mission.sight, hidden).value)
        return super()._sight(hidden)

    def _gains(self, aloft, sight):
        pending = np.bincount(aloft.pending.cells, minlength=sight.theta.size)
        self.kept[-1] += sight.worth(pending).sum()
        return super()._gains(aloft, sight)

    def _better(self, problem, old, seed):
        plan = super()._better(problem, old, seed)
        self.kept[-1] += evaluate(problem, plan).total
        return plan


@pytest.mark.parametrize(
    ("text", "every"),
    [
        (OVER_CELLS, 31.0),
        (OVER_CELLS + INFORMATION, 31.0),
        (TEAM, 31.0),
        (HOME, 40.0),
        (HOME + INFORMATION, 40.0),
        (APART, 30.0),
        (APART + INFORMATION, 30.0),
        (ALARMS, 9.0),
        (RATES, 31.0),
    ],
    ids=[
        "targets",
        "bits",
        "team",
        "regions",
        "bits over regions",
        "a team over regions",
        "bits of a team over regions",
        "a person",
        "rates",
    ],
)
def test_a_new_plan_keeps_its_promise(tmp_path, text, every):
    mission = mission_of(tmp_path, text)
    flights = Promising(mission, plan_mission(mission, seconds=0.3, seed=1).score.plan, "greedy", every)
    ended = []
    for seed in range(120):
        before = len(flights.kept)
        value = flights.flown(seed).value
        ended += [value] * (len(flights.kept) > before)
        del flights.kept[before + 1 :]  # of later replans
    off = Mean.of(np.subtract(ended, flights.kept[: len(ended)]))
    assert off.n >= 100
    assert abs(off.value) < 4.0 * off.error


def test_a_seed_is_one_flight(tmp_path):
    planned = plan_mission(mission_of(tmp_path, EVIDENCE + INFORMATION), seconds=0.3, seed=1)
    assert list(fly_replanned(planned, 20.0, range(3))) == list(fly_replanned(planned, 20.0, range(3)))


def test_targets_and_errors_come_as_often_as_they_should(tmp_path):
    sight = mission_of(tmp_path, OVER_CELLS).sight
    theta, cells = sight.theta.ravel(), np.tile(np.arange(280), 3)
    there, hits = np.zeros(280), np.zeros(280)
    for seed in range(1500):
        hidden = Hidden(sight.answers, seed)
        hidden.look(cells, np.arange(840.0))
        there += hidden.truth
        hits += hidden.hits
    np.testing.assert_allclose(there / 1500, theta, atol=0.07)
    np.testing.assert_allclose(hits / 4500, 0.8 * theta + 0.1 * (1 - theta), atol=0.06)


def test_looks_are_the_same_in_one_go_or_in_two(tmp_path):
    sight = mission_of(tmp_path, OVER_CELLS).sight
    cells, times = np.random.default_rng(5).integers(0, 30, 200), np.arange(200.0)
    once, twice = Hidden(sight.answers, 4), Hidden(sight.answers, 4)
    once.look(cells, times)
    twice.look(cells[:77], times[:77])
    twice.look(cells[77:], times[77:])
    np.testing.assert_array_equal(once.hits, twice.hits)
    np.testing.assert_array_equal(once.first, twice.first)
    assert once.false_alarms == twice.false_alarms


REFUSED = {
    "a person": (SMALL, "every look says no"),
    "a target": (ALARMS + "[objective]\ndetection_target = 0.2\n", "by the end"),
    "links": (TEAM.replace("[area]", "[area]\ncell_m = 5.0") + "[links]\nloss = 0.5\n", "no drone knows"),
}


@pytest.mark.parametrize("name", REFUSED)
def test_where_answers_do_not_help_it_is_refused(tmp_path, name):
    text, told = REFUSED[name]
    with pytest.raises(DataFormatError, match=told):
        check_replanning(mission_of(tmp_path, text))
