"""The slice of Experiment 3 with the Beta-Bernoulli sensor: its gains by Monte Carlo, its trials by the judge."""

import numpy as np
import pytest

from sooner.campaigns.study import Table, read_study
from sooner.campaigns.trial import Place, Trial
from sooner.errors import InvalidProblemError
from sooner.experiments.kuhlman2017.flight import fly
from sooner.experiments.kuhlman2017.ground import ground, posed
from sooner.experiments.published import study_folder
from sooner.problem import Plan, evaluate

STUDY = read_study(study_folder("kuhlman2017") / "beta.toml")


def flown(instance, planner, seed=0):
    (cell,) = STUDY.cells(Table(name="one", instances=[instance], planners=[planner]))
    return fly(Trial(cell.case, seed), Place(""))


@pytest.mark.parametrize("instance", ["med uniform, beta", "med nonuniform, beta"])
def test_the_planners_of_the_paper_fly_it_where_looks_go_on_teaching(instance):
    """Ways flown again and again pay well then, and greedy finds them; coverage flies no more searches than greedy."""
    info = {planner: flown(instance, planner)["info"] for planner in ("eps-B&B", "DFS", "DF-B&B", "greedy")}
    assert 100.5 > info["eps-B&B"] > 95
    assert 100.5 > info["greedy"] > 95
    assert 40 < info["DFS"] < 75
    assert 0 < info["DF-B&B"] < info["eps-B&B"]


def test_a_rate_has_no_search_effort():
    told = flown("med uniform, beta", "DFS")
    assert told["effort"] is None
    assert told["effort_corrected"] is None
    assert flown("med uniform", "DFS")["effort"] > 0


def test_what_a_plan_learns_about_rates_is_what_drawn_rates_and_looks_teach():
    """log2 of how much likelier the hits are under the drawn rate than under the prior, in the mean over draws."""
    from scipy.stats import betabinom, binom

    found = posed({"kind": "med", "nonuniform": True, "model": "beta"}, 0)
    actions = np.array(flown("med nonuniform, beta", "greedy")["actions"])
    looks, rng = found.looks(actions), np.random.default_rng(5)
    seen = np.flatnonzero(looks)
    alpha = np.where(found.theta[seen] == 0.5, 1.0, 3.0)
    bits = []
    for _ in range(30):
        rate = rng.beta(alpha, 1.0)
        hits = rng.binomial(looks[seen], rate)
        likelier = binom.logpmf(hits, looks[seen], rate) - betabinom.logpmf(hits, looks[seen], alpha, 1.0)
        bits.append(likelier.sum() / np.log(2.0))
    error = np.std(bits, ddof=1) / np.sqrt(len(bits))
    assert abs(np.mean(bits) - evaluate(found.problem, Plan.of(actions)).total) < 4 * error
    assert error < 0.01 * np.mean(bits)


def test_another_model_is_refused():
    with pytest.raises(InvalidProblemError, match="model 'gamma' came"):
        ground("vlf", 1, model="gamma")
