"""What looks answer, and what their answers teach: against Bayes' law look by look, and against counting."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from sooner.belief import Belief, BetaGrid, EvidenceGrid
from sooner.errors import ImpossibleObservationError, InvalidProblemError
from sooner.sensors import miss_after_looks
from sooner.simulation.answers import AnswerModel, theta_of
from sooner.simulation.hidden import Hidden

SHAPE = (2, 3)
CELLS = 6


def by_enumeration(poc, outside, detect, alarm, cells, yes):
    """Where the person is, each place by itself: the product over all looks of what it makes of their answers."""
    places = np.append(poc, outside)
    for place in range(len(places)):
        for cell, said in zip(cells, yes, strict=True):
            chance = detect[cell] if place == cell else alarm
            places[place] *= chance if said else 1.0 - chance
    return places / places.sum()


@given(st.integers(0, 10_000), st.floats(0.0, 0.9), st.floats(0.01, 0.9))
def test_one_person_is_weighed_against_all_other_places(seed, outside, alarm):
    rng = np.random.default_rng(seed)
    belief, detect = Belief.from_weights(rng.random(SHAPE), outside), rng.random(CELLS)
    cells, yes = rng.integers(0, CELLS, 12), rng.random(12) < 0.5
    model = AnswerModel(belief, detect, alarm)
    known = model.after(np.bincount(cells, minlength=CELLS), np.bincount(cells[yes], minlength=CELLS))
    expected = by_enumeration(belief.poc.ravel(), outside, detect, alarm, cells, yes)
    np.testing.assert_allclose(known.poc.ravel(), expected[:-1], atol=1e-12)
    assert known.poc.sum() + known.outside == pytest.approx(1.0)


def test_evidence_learns_as_the_evidence_grid_says():
    rng = np.random.default_rng(3)
    theta, cells, yes = rng.random((3, 4)), rng.integers(0, 12, 30), rng.random(30) < 0.5
    grid = EvidenceGrid(theta).update(cells, yes, 0.8, 0.1)
    looks, hits = np.bincount(cells, minlength=12), np.bincount(cells[yes], minlength=12)
    model = AnswerModel(EvidenceGrid(theta), 0.8, 0.1)
    np.testing.assert_allclose(model.after(looks, hits).theta, grid.theta)


def test_rates_learn_as_the_beta_grid_says():
    cells, yes = np.array([0, 3, 3, 3]), np.array([True, False, True, True])
    model = AnswerModel(BetaGrid.uniform((2, 2), 2.0, 3.0))
    known = model.after(np.bincount(cells, minlength=4), np.bincount(cells[yes], minlength=4))
    expected = model.known.update(cells, yes)
    np.testing.assert_array_equal(known.alpha, expected.alpha)
    np.testing.assert_array_equal(known.beta, expected.beta)


def test_without_false_alarms_a_yes_settles_it():
    known = AnswerModel(Belief.from_weights(np.ones(SHAPE), 0.5), 0.3).after(
        np.array([1, 1, 1, 0, 0, 0]), np.eye(6, dtype=int)[2]
    )
    np.testing.assert_array_equal(known.poc.ravel(), np.eye(6)[2])


def test_who_was_missed_everywhere_is_elsewhere():
    model = AnswerModel(Belief.from_weights(np.ones(SHAPE), 0.2), 1.0)
    assert model.after(np.ones(6, int), np.zeros(6, int)).outside == pytest.approx(1.0)


def test_looks_that_correlate_teach_less():
    belief = Belief.from_weights([[1.0, 1.0]])
    model = AnswerModel(belief, 0.5, correlation=0.5)
    known = model.after(np.array([2, 0]), np.zeros(2, int))
    missed = miss_after_looks(np.array([0.5]), 2, 0.5)[0, -1]
    np.testing.assert_allclose(known.poc, [[missed / (1 + missed), 1 / (1 + missed)]])


@pytest.mark.parametrize("known", [Belief.from_weights([[0.0, 1.0]]), EvidenceGrid(np.array([[0.0, 1.0]]))])
def test_answers_that_cannot_be_are_refused(known):
    with pytest.raises(ImpossibleObservationError):
        AnswerModel(known, 1.0).after(np.array([1, 0]), np.array([1, 0]))
    with pytest.raises(ImpossibleObservationError):
        AnswerModel(known, 1.0).after(np.array([0, 1]), np.array([0, 0]))


@pytest.mark.parametrize(
    ("settings", "told"),
    [
        ({"detect": 1.5}, "outside"),
        ({"detect": np.nan}, "outside"),
        ({"false_alarm": -0.1}, "outside"),
        ({"detect": np.ones(3)}, "the map has 6"),
        ({"correlation": 2.0}, "correlation"),
        ({"correlation": 0.5, "false_alarm": 0.1}, "one person and no false alarms"),
    ],
)
def test_models_that_cannot_be_are_refused(settings, told):
    with pytest.raises(InvalidProblemError, match=told):
        AnswerModel(Belief.from_weights(np.ones(SHAPE)), **settings)


def test_rates_have_no_sensor_that_errs():
    with pytest.raises(InvalidProblemError, match="rates"):
        AnswerModel(BetaGrid.uniform(SHAPE), 0.9)


@pytest.mark.parametrize("kind", ["person", "targets", "rates"])
def test_what_is_believed_is_true_as_often_as_it_says(kind):
    """Calibration: the mean belief in a cell after looks, over many seeds, is how often somebody is there."""
    rng = np.random.default_rng(5)
    known = {
        "person": Belief.from_weights(rng.random(SHAPE), 0.2),
        "targets": EvidenceGrid(rng.random(SHAPE)),
        "rates": BetaGrid(3.0 * rng.random(SHAPE) + 0.5, np.ones(SHAPE)),
    }[kind]
    model = AnswerModel(known) if kind == "rates" else AnswerModel(known, 0.7, 0.2)
    cells = np.array([0, 0, 1, 2, 2, 2, 5])
    apart = []
    for seed in range(2000):
        hidden = Hidden(model, seed)
        hidden.look(cells, np.arange(7.0))
        apart.append(theta_of(model.after(hidden.looks, hidden.hits)) - hidden.truth)
    apart = np.array(apart)
    assert (np.abs(apart.mean(axis=0)) < 4.0 * apart.std(axis=0) / np.sqrt(2000)).all()


@pytest.mark.parametrize("outside", [0.0, 0.3])
def test_of_some_cells_alone_as_much_is_learnt(outside):
    """Where nobody looks, nothing is learnt but what looks elsewhere say: their share of the person's entropy."""
    rng = np.random.default_rng(1)
    model = AnswerModel(Belief.from_weights(rng.random(SHAPE), outside), 0.7, 0.2)
    looks, hits = np.array([3, 1, 0, 0, 0, 0]), np.array([1, 1, 0, 0, 0, 0])
    few, whole = model.narrowed(np.array([0, 1])), model.after(looks, hits)
    part = few.after(looks[:2], hits[:2])
    np.testing.assert_allclose(part.poc.ravel(), whole.poc.ravel()[:2])
    elsewhere = np.append(model.theta[2:], outside)
    share = elsewhere[elsewhere > 0] / elsewhere.sum()
    lump = -(share * np.log2(share)).sum()
    assert model.bits(whole) == pytest.approx(model.bits(part) + part.outside * lump)
