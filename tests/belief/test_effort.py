"""Search effort on the ground: figures by the printed equation, and draws for the corrected one."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from sooner.belief import (
    effort_by_looks,
    expected_effort,
    expected_search_time,
    search_time_limit,
    theta_from_counts,
)
from sooner.errors import InvalidProblemError

SENSOR = (0.85, 0.15)


def test_the_printed_equation_gives_the_figures_of_an_independent_reproduction() -> None:
    effort = effort_by_looks([0.5], 3, *SENSOR, variant="printed")
    assert effort[0] == pytest.approx(np.array([2.769, 2.168, 1.567, 1.153]), abs=5e-4)


def test_the_corrected_equation_adds_the_targets_not_found_in_time() -> None:
    effort = effort_by_looks([0.5], 3, *SENSOR)
    assert effort[0] == pytest.approx(np.array([2.793, 2.185, 1.578, 1.159]), abs=5e-4)


@pytest.mark.parametrize("k", [0, 1, 3])
def test_the_corrected_equation_is_what_draws_show(k: int) -> None:
    rng = np.random.default_rng(5)
    n, theta, tau = 200_000, 0.4, 3.0
    present = rng.random(n) < theta
    hits = rng.binomial(k, np.where(present, *SENSOR))
    limit = search_time_limit(theta_from_counts(theta, k - hits, hits, *SENSOR), 0.01, tau)
    time = np.where(present, np.minimum(rng.exponential(tau, n), limit), limit)
    expected = effort_by_looks([theta], 3, *SENSOR, tau=tau)[0, k]
    assert abs(time.mean() - expected) < 4 * time.std() / np.sqrt(n)


@given(st.floats(0.02, 0.999), st.floats(0.001, 0.01), st.floats(0.1, 10))
def test_at_the_limit_a_cell_in_vain_is_as_likely_as_the_threshold(prior: float, threshold: float, tau: float) -> None:
    left = prior * np.exp(-search_time_limit(prior, threshold, tau) / tau)
    assert left / (1 - prior + left) == pytest.approx(threshold)


@given(st.floats(0, 0.999), st.floats(0.001, 0.2))
def test_the_variants_differ_by_what_the_note_says(prior: float, threshold: float) -> None:
    limit = search_time_limit(prior, threshold)
    one, other = (expected_search_time(prior, threshold, variant=v) for v in ("corrected", "printed"))
    assert one - other == pytest.approx(limit * (1 - prior) * threshold / (1 - threshold), abs=1e-12)


@pytest.mark.parametrize("variant", ["corrected", "printed"])
def test_no_effort_where_nobody_is_thought_to_be_and_tau_where_somebody_must_be(variant: str) -> None:
    time = expected_search_time([0.0, 0.005, 1.0], 0.01, 2.0, variant)  # type: ignore[arg-type]
    assert time == pytest.approx(np.array([0.0, 0.0, 2.0]))


def test_a_sensor_without_errors_leaves_only_those_who_are_there() -> None:
    assert effort_by_looks([0.3], 2, 1.0, 0.0)[0, 1:] == pytest.approx([0.3, 0.3])


def test_a_flight_s_effort_is_read_cell_by_cell_and_averages_over_the_shares_of_looks() -> None:
    theta, looks = np.array([0.5, 0.2, 0.5, 0.5]), np.array([0, 2, 2, 1])
    found = expected_effort(theta, looks, *SENSOR)
    table = effort_by_looks(theta, 2, *SENSOR)
    assert found == pytest.approx(table[np.arange(4), looks])
    shares = np.array([0.25, 0.5, 0.25])
    assert (effort_by_looks([0.5], 2, *SENSOR) @ shares)[0] == pytest.approx(
        expected_effort([0.5] * 4, [0, 1, 1, 2], *SENSOR).mean()
    )


@given(st.floats(0.05, 0.5), st.floats(0.5, 0.9), st.integers(1, 6))
def test_effort_lies_within_the_search_of_a_cell_in_vain(theta: float, d: float, looks: int) -> None:
    effort = effort_by_looks([theta], looks, d, 0.1)[0]
    highest = search_time_limit(theta_from_counts(theta, 0, looks, d, 0.1), 0.01)
    assert (effort >= 0).all()
    assert (effort <= highest + 1e-9).all()


@given(st.floats(0.3, 0.99), st.floats(0.5, 0.7))
def test_looks_spare_effort_while_no_outcome_leads_below_the_threshold(theta: float, d: float) -> None:
    effort = effort_by_looks([theta], 3, d, 0.3, threshold=0.001)[0]
    assert (np.diff(effort) <= 1e-12).all()


def test_a_look_at_a_cell_that_would_not_be_searched_can_only_cost() -> None:
    effort = effort_by_looks([0.009], 2, *SENSOR)[0]
    assert effort[0] == 0.0 < effort[1]


@pytest.mark.parametrize(
    "wrong",
    [
        {"theta": [1.5]},
        {"threshold": 0.0},
        {"threshold": 1.0},
        {"tau": 0.0},
        {"looks": -1},
        {"variant": "other"},
    ],
)
def test_effort_of_nonsense_is_refused(wrong: dict) -> None:
    arguments = {"theta": [0.5], "looks": 1, "detect": 0.85, "false_alarm": 0.15, **wrong}
    with pytest.raises(InvalidProblemError):
        effort_by_looks(**arguments)


@pytest.mark.parametrize("looks", [[1], [0.5, 1.0], [-1, 0]])
def test_looks_that_are_no_counts_are_refused(looks: list) -> None:
    with pytest.raises(InvalidProblemError, match="numbers of looks"):
        expected_effort([0.5, 0.5], looks, *SENSOR)
