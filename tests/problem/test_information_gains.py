from itertools import product

import numpy as np
import pytest

from sooner.belief import Belief, BetaGrid, EvidenceGrid, beta_information
from sooner.errors import InvalidProblemError
from sooner.grid import Grid
from sooner.problem import (
    Plan,
    Searcher,
    SearchProblem,
    evaluate,
    evidence_detection_gains,
    glimpse_information_gains,
    information_gains,
)
from sooner.sensors import BinarySensor

SENSOR = BinarySensor(0.85, 0.15)


def test_gains_total_the_entropy_and_end_with_the_table() -> None:
    evidence = EvidenceGrid(np.array([[0.5, 0.03], [0.0, 1.0]]))
    gains = information_gains(evidence, SENSOR)
    assert gains.table.shape == (4, 64)
    assert gains.table.sum(axis=1) == pytest.approx(evidence.entropy.ravel(), abs=1e-8)
    assert not gains.of(np.arange(4), np.full(4, 64)).any()


def test_a_shorter_table_is_a_lower_limit() -> None:
    evidence = EvidenceGrid.uniform((1, 1))
    short, long = (information_gains(evidence, SENSOR, looks=looks) for looks in (3, 10))
    assert short.table.sum() < long.table.sum()
    assert np.array_equal(short.table, long.table[:, :3])


def test_gains_after_looks_are_never_what_the_looks_said_but_what_they_were_expected_to() -> None:
    """Expected over one look's two answers, the gains of the next look are the table's second column."""
    evidence = EvidenceGrid.uniform((1, 1), 0.3)
    hit = 0.3 * 0.85 + 0.7 * 0.15
    told = [information_gains(evidence.update([0], [h], 0.85, 0.15), SENSOR).first[0] for h in (True, False)]
    assert hit * told[0] + (1 - hit) * told[1] == pytest.approx(information_gains(evidence, SENSOR).table[0, 1])


def test_rates_take_no_sensor_and_evidence_needs_one() -> None:
    rates = BetaGrid.uniform((2, 2))
    assert information_gains(rates, looks=5).table == pytest.approx(beta_information(np.ones(4), np.ones(4), 5))
    with pytest.raises(InvalidProblemError, match="BetaGrid"):
        information_gains(rates, SENSOR)
    with pytest.raises(InvalidProblemError, match="no sensor"):
        information_gains(EvidenceGrid.uniform((2, 2)))


def test_information_over_a_poc_map_is_no_less_than_that_of_the_whole_map() -> None:
    """Every outcome of one look at each of three cells, against who is where."""
    belief = Belief.from_weights([[1.0, 2.0, 4.0]], outside=0.2)
    glimpse = np.array([[0.9, 0.5, 0.7]])
    poc, g = belief.poc.ravel(), glimpse.ravel()
    where = np.append(poc, belief.outside)
    joint = 0.0
    for hits in product((0, 1), repeat=3):
        given_where = np.array(
            [np.prod([(g[i] if h else 1 - g[i]) if i == x else 1 - h for i, h in enumerate(hits)]) for x in range(4)]
        )
        chance = where @ given_where
        if chance > 0:
            some = given_where > 0
            joint += np.sum((where * given_where)[some] * np.log2(given_where[some] / chance))
    cell_by_cell = glimpse_information_gains(belief, glimpse).first.sum()
    assert joint <= cell_by_cell
    assert joint > 0.6 * cell_by_cell


def test_detections_over_evidence_are_expected_targets() -> None:
    gains = evidence_detection_gains(EvidenceGrid(np.array([[0.5, 1.0]])), SENSOR)
    cells, looks = np.array([0, 1, 1]), np.array([0, 0, 2])
    assert gains.of(cells, looks) == pytest.approx(np.array([0.425, 0.85, 0.85 * 0.15**2]))


def test_the_judge_adds_bits_as_it_adds_probabilities() -> None:
    gains = information_gains(EvidenceGrid.uniform((1, 3)), SENSOR)
    problem = SearchProblem(Grid((1, 3)), gains, (Searcher((0, 0), 3),))
    value = evaluate(problem, Plan.of([0, 1, 1, 0])).value
    assert value == pytest.approx(2 * 0.599427, abs=1e-6)


@pytest.mark.parametrize("glimpse", [1.5, np.nan, np.ones((2, 2))])
def test_glimpses_that_make_no_sense_are_refused(glimpse: object) -> None:
    with pytest.raises(InvalidProblemError):
        glimpse_information_gains(Belief.from_weights([[1.0, 1.0]]), glimpse)  # type: ignore[arg-type]
