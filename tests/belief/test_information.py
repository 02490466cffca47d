"""Information three ways, with the literal equation (15) as the fourth, and against draws and quadrature."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy import integrate, stats

from sooner.belief import (
    EvidenceGrid,
    beta_information,
    beta_information_table,
    binary_entropy,
    information,
    information_table,
    look_information,
    theta_from_counts,
)
from sooner.errors import InvalidProblemError

rates = st.floats(0, 1)


def equation_15(theta: float, q: int, d: float, f: float) -> float:
    """I of q looks as printed, term by term."""
    m = np.arange(q + 1)
    given_x = [stats.binom.pmf(m, q, f), stats.binom.pmf(m, q, d)]
    prior = [1 - theta, theta]
    total = prior[0] * given_x[0] + prior[1] * given_x[1]
    bits = 0.0
    for x in (0, 1):
        here = (given_x[x] > 0) & (total > 0)
        bits += np.sum(prior[x] * given_x[x][here] * (np.log2(given_x[x][here]) - np.log2(total[here])))
    return bits


@given(rates, st.integers(1, 12), rates, rates)
def test_binomials_are_equation_15(theta: float, looks: int, d: float, f: float) -> None:
    found = np.cumsum(information([theta], looks, d, f)[0])
    expected = [equation_15(theta, q, d, f) for q in range(1, looks + 1)]
    assert found == pytest.approx(expected, abs=1e-12)


@given(rates, st.integers(1, 20), rates, rates)
def test_the_chain_rule_over_counts_agrees_with_binomials(theta: float, looks: int, d: float, f: float) -> None:
    chained = information_table(theta, 0, 0, looks, d, f)[0, 0, 1:]
    assert np.cumsum(information([theta], looks, d, f)[0]) == pytest.approx(chained, abs=1e-12)


def test_a_false_alarm_next_to_never_is_as_good_as_none() -> None:
    assert information([0.5], 2, 0.5, 5e-324)[0] == pytest.approx(information([0.5], 2, 0.5, 0.0)[0], rel=1e-12)


def test_table_1_is_the_papers_to_its_printed_digits() -> None:
    """But for 0.34636, printed as 0.347, which is what its rounded neighbours give: 0.737 - 0.390."""
    table = information_table(0.5, 2, 2, 3, 0.85, 0.15).round(3)
    assert table[1, 0, 2] == 0.346
    table[table == 0.346] = 0.347
    printed = {  # (nz0, nz1): q = 1, 2, 3
        (0, 0): (0.390, 0.599, 0.737),
        (1, 0): (0.209, 0.347, 0.432),
        (2, 0): (0.050, 0.094, 0.125),
        (0, 1): (0.209, 0.347, 0.432),
        (1, 1): (0.390, 0.599, 0.737),
        (2, 1): (0.209, 0.347, 0.432),
        (0, 2): (0.050, 0.094, 0.125),
        (1, 2): (0.209, 0.347, 0.432),
        (2, 2): (0.390, 0.599, 0.737),
    }
    for counts, bits in printed.items():
        assert table[counts][1:].tolist() == list(bits), counts


def test_every_entry_of_the_papers_whole_table_is_the_information_from_its_theta() -> None:
    table = information_table(0.5, 20, 20, 10, 0.85, 0.15)
    assert table.shape == (21, 21, 11)
    misses, hits = np.indices((21, 21))
    theta = theta_from_counts(0.5, misses, hits, 0.85, 0.15)
    direct = np.cumsum(information(theta.ravel(), 10, 0.85, 0.15), axis=1).reshape(21, 21, 10)
    assert table[..., 1:] == pytest.approx(direct, abs=1e-12)
    assert np.array_equal(table[..., 0], np.zeros((21, 21)))


@given(st.floats(0.5, 1), st.floats(0, 1))
def test_the_table_is_symmetric_where_both_errors_are_as_likely_and_only_there(d: float, f: float) -> None:
    table = information_table(0.5, 5, 5, 3, d, 1 - d)
    assert table == pytest.approx(np.swapaxes(table, 0, 1), abs=1e-12)
    lopsided = information_table(0.5, 2, 2, 1, 0.9, 0.3)
    assert lopsided[1, 0, 1] != pytest.approx(lopsided[0, 1, 1])


@given(st.lists(rates, min_size=1, max_size=6), st.integers(1, 48), rates, rates)
def test_information_is_at_most_the_entropy_and_each_look_helps_less(
    theta: list[float], looks: int, d: float, f: float
) -> None:
    gains = information(theta, looks, d, f)
    assert (gains >= 0).all()
    assert (np.diff(gains, axis=1) <= 0).all()
    assert (gains.sum(axis=1) <= EvidenceGrid([theta]).entropy[0] * (1 + 1e-12)).all()


@given(rates, rates, rates)
def test_what_a_look_teaches_is_the_entropy_it_is_expected_to_take(theta: float, d: float, f: float) -> None:
    hit = theta * d + (1 - theta) * f
    left = sum(
        chance * binary_entropy(np.clip(there / chance, 0, 1))
        for chance, there in ((hit, theta * d), (1 - hit, theta * (1 - d)))
        if chance > 0
    )
    assert look_information(theta, d, f) == pytest.approx(binary_entropy(theta) - left, abs=1e-9)


@pytest.mark.parametrize(("d", "f"), [(0.85, 0.15), (0.3, 0.05), (1.0, 0.2), (0.6, 0.0), (1.0, 0.0), (0.99, 1e-9)])
def test_many_different_cells_are_interpolated_to_rounding(d: float, f: float) -> None:
    rng = np.random.default_rng(1)
    theta = np.concatenate([rng.random(3000), 10.0 ** -rng.uniform(0, 12, 1500), 1 - 10.0 ** -rng.uniform(0, 12, 1500)])
    theta[:5] = [0.0, 1.0, 1e-300, np.nextafter(1.0, 0.0), 0.5]
    many = information(theta, 24, d, f)
    some = np.concatenate([np.arange(5), rng.choice(6000, 300, replace=False)])
    few = information(theta[some], 24, d, f)
    assert many[some] == pytest.approx(few, abs=1e-13)
    assert np.cumsum(many[some], axis=1) == pytest.approx(np.cumsum(few, axis=1), rel=1e-10)
    assert (many.sum(axis=1) <= EvidenceGrid([theta]).entropy[0] * (1 + 1e-12)).all()


@given(st.floats(1e-15, 1e-3), st.floats(0.01, 1))
def test_rare_targets_keep_their_digits(theta: float, d: float) -> None:
    """Without false alarms only all misses leave a doubt: h(theta) - (1 - theta + theta r) h(posterior)."""
    gains = information([theta], 3, d)
    total = float(EvidenceGrid([[theta]]).entropy[0, 0])
    for k in (1, 2, 3):
        there, nowhere = theta * (1 - d) ** k, 1 - theta
        left = -(there * np.log2(there / (there + nowhere)) if there else 0.0) + nowhere * np.log1p(
            there / nowhere
        ) / np.log(2)
        assert gains[0, :k].sum() == pytest.approx(total - left, rel=1e-8, abs=1e-14 * total)


def test_equal_cells_and_cells_of_their_own_sensor_are_told_apart() -> None:
    theta, detect = np.array([0.5, 0.2, 0.5, 0.5]), np.array([0.9, 0.9, 0.9, 0.6])
    together = information(theta, 4, detect, 0.1)
    alone = np.concatenate([information(theta[i : i + 1], 4, detect[i], 0.1) for i in range(4)])
    assert np.array_equal(together, alone)


def test_a_blind_look_teaches_nothing() -> None:
    assert not information([0.1, 0.5], 5, 0.4, 0.4).any()


@pytest.mark.parametrize(
    ("theta", "looks", "detect"),
    [([1.5], 2, 0.5), ([np.nan], 2, 0.5), ([0.5], 0, 0.5), ([0.5, 0.5, 0.5], 2, [0.5] * 2)],
)
def test_information_of_nonsense_is_refused(theta: list, looks: int, detect: object) -> None:
    with pytest.raises(InvalidProblemError):
        information(theta, looks, detect)  # type: ignore[arg-type]


positive = st.floats(0.1, 50)


def beta_by_quadrature(a: float, b: float, q: int) -> float:
    """Kullback-Leibler distance of each posterior from the prior, expected over the number of hits."""
    prior = stats.beta(a, b)
    bits = 0.0
    for m in range(q + 1):
        after = stats.beta(a + m, b + q - m)
        distance, _ = integrate.quad(
            lambda x, after=after: after.pdf(x) * (after.logpdf(x) - prior.logpdf(x)), 0, 1, limit=200
        )
        bits += stats.betabinom.pmf(m, q, a, b) * distance / np.log(2)
    return bits


@pytest.mark.parametrize(("a", "b", "q"), [(1.0, 1.0, 1), (1.0, 1.0, 4), (2.5, 1.2, 3), (8.0, 3.0, 2)])
def test_information_about_a_rate_is_that_of_quadrature(a: float, b: float, q: int) -> None:
    assert beta_information([a], [b], q).sum() == pytest.approx(beta_by_quadrature(a, b, q), rel=1e-6)


def test_information_about_a_rate_is_that_of_draws() -> None:
    rng = np.random.default_rng(3)
    a, b, q, n = 1.5, 2.5, 5, 200_000
    x = rng.beta(a, b, n)
    m = rng.binomial(q, x)
    ratio = np.log2(stats.binom.pmf(m, q, x) / stats.betabinom.pmf(m, q, a, b))
    error = ratio.std() / np.sqrt(n)
    assert abs(beta_information([a], [b], q).sum() - ratio.mean()) < 4 * error


@given(positive, positive, st.integers(1, 12))
def test_the_table_of_a_rate_is_the_information_from_its_counts(a: float, b: float, looks: int) -> None:
    table = beta_information_table(a, b, 2, 3, looks)
    misses, hits = (counts.ravel() for counts in np.indices((3, 4)))
    direct = np.cumsum(beta_information(a + hits, b + misses, looks), axis=1)
    assert table[..., 1:].reshape(12, looks) == pytest.approx(direct, abs=1e-11)


@given(st.lists(st.tuples(positive, positive), min_size=1, max_size=4), st.integers(2, 24))
def test_about_a_rate_each_look_helps_less_and_hits_are_as_good_as_misses(
    laws: list[tuple[float, float]], looks: int
) -> None:
    a, b = np.array(laws).T
    gains = beta_information(a, b, looks)
    assert (gains > 0).all()
    assert (np.diff(gains, axis=1) <= 0).all()
    assert gains == pytest.approx(beta_information(b, a, looks), abs=1e-12)


@pytest.mark.parametrize(("a", "looks"), [(0.0, 2), (np.nan, 2), (1.0, 0)])
def test_information_about_a_rate_that_makes_no_sense_is_refused(a: float, looks: int) -> None:
    with pytest.raises(InvalidProblemError):
        beta_information([a], [1.0], looks)
