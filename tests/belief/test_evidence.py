import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from sooner.belief import BetaGrid, EvidenceGrid, binary_entropy, stationary_theta, theta_from_counts
from sooner.errors import ImpossibleObservationError, InvalidProblemError

maps = arrays(float, (2, 3), elements=st.floats(0, 1))
inner = st.floats(0.01, 0.99)
looks = st.lists(st.tuples(st.integers(0, 5), st.booleans()), max_size=12)


def by_the_book(theta: float, hit: bool, d: float, f: float) -> float:
    """[Kuhlman2017, eq. (14)] as it is printed."""
    there, nowhere = (d, f) if hit else (1 - d, 1 - f)
    return there * theta / (there * theta + nowhere * (1 - theta))


@given(arrays(float, (2, 3), elements=inner), looks, inner, inner)
def test_an_update_is_the_printed_equation_look_by_look(
    prior: np.ndarray, seen: list[tuple[int, bool]], d: float, f: float
) -> None:
    theta = prior.ravel().copy()
    for cell, hit in seen:
        theta[cell] = by_the_book(theta[cell], hit, d, f)
    after = EvidenceGrid(prior).update([c for c, _ in seen], [h for _, h in seen], d, f)
    assert after.theta.ravel() == pytest.approx(theta, rel=1e-9)


@given(maps, looks, inner, inner, st.randoms(use_true_random=False))
def test_the_order_of_looks_does_not_matter(
    prior: np.ndarray, seen: list[tuple[int, bool]], d: float, f: float, random: object
) -> None:
    shuffled = seen.copy()
    random.shuffle(shuffled)  # type: ignore[attr-defined]
    one, other = (
        EvidenceGrid(prior).update([c for c, _ in some], [h for _, h in some], d, f) for some in (seen, shuffled)
    )
    assert one.theta == pytest.approx(other.theta, abs=1e-12)


def test_theta_is_kept_as_it_came_and_unlooked_cells_stay() -> None:
    prior = np.array([[0.1, 0.3, 0.0, 1.0]])
    assert np.array_equal(EvidenceGrid(prior).theta, prior)
    after = EvidenceGrid(prior).update([0], [True], 0.85, 0.15)
    assert after.theta[0, 1:] == pytest.approx(prior[0, 1:])


@pytest.mark.parametrize(
    ("theta", "hits", "d", "f"),
    [
        (0.0, [True], 0.8, 0.0),  # a hit where nothing is, without false alarms
        (1.0, [False], 1.0, 0.1),  # a miss of what is there, by a sensor that never misses
        (0.5, [True, False], 1.0, 0.0),
        (0.5, [True], 0.0, 0.0),
        (0.5, [False], 1.0, 1.0),
    ],
)
def test_what_cannot_be_observed_is_refused(theta: float, hits: list[bool], d: float, f: float) -> None:
    with pytest.raises(ImpossibleObservationError, match="cannot be, at 1 cells"):
        EvidenceGrid([[theta]]).update([0] * len(hits), hits, d, f)
    with pytest.raises(ImpossibleObservationError):
        theta_from_counts(theta, hits.count(False), hits.count(True), d, f)


@pytest.mark.parametrize(
    ("theta", "hit", "d", "f", "after"),
    [
        (0.5, True, 0.8, 0.0, 1.0),
        (0.5, False, 1.0, 0.2, 0.0),
        (0.0, False, 0.8, 0.0, 0.0),
        (1.0, True, 1.0, 0.0, 1.0),
        (1.0, False, 0.9, 0.0, 1.0),
    ],
)
def test_certainty_is_reached_and_kept(theta: float, hit: bool, d: float, f: float, after: float) -> None:
    assert EvidenceGrid([[theta]]).update([0], [hit], d, f).theta[0, 0] == after


def test_a_hundred_hits_are_undone_by_a_hundred_misses() -> None:
    sure = EvidenceGrid.uniform((1, 1)).update([0] * 100, [True] * 100, 0.85, 0.15)
    assert sure.theta[0, 0] == 1.0
    assert sure.entropy[0, 0] > 0.0
    assert sure.update([0] * 100, [False] * 100, 0.85, 0.15).theta[0, 0] == pytest.approx(0.5)


@given(st.floats(0, 1), st.integers(0, 6), st.integers(0, 6), inner, inner)
def test_counts_give_what_looks_one_by_one_give(prior: float, misses: int, hits: int, d: float, f: float) -> None:
    seen = EvidenceGrid([[prior]]).update([0] * (misses + hits), [False] * misses + [True] * hits, d, f)
    assert theta_from_counts(prior, misses, hits, d, f) == pytest.approx(seen.theta[0, 0], abs=1e-12)


def test_the_papers_low_entropy_prior_is_that_of_two_hits() -> None:
    assert theta_from_counts(0.5, 0, 2, 0.85, 0.15) == pytest.approx(0.97, abs=5e-4)


@given(st.integers(0, 20), st.integers(0, 20), inner)
def test_misses_and_hits_are_mirror_images_where_both_errors_are_as_likely(misses: int, hits: int, d: float) -> None:
    one, other = theta_from_counts(0.5, misses, hits, d, 1 - d), theta_from_counts(0.5, hits, misses, d, 1 - d)
    assert one + other == pytest.approx(1.0)


@given(maps)
def test_entropy_is_at_most_a_bit_and_none_where_certain(theta: np.ndarray) -> None:
    entropy = EvidenceGrid(theta).entropy
    assert (entropy >= 0).all()
    assert (entropy <= 1).all()
    assert entropy == pytest.approx(binary_entropy(theta), abs=1e-12)


@given(maps, st.floats(0, 1), st.floats(0, 1), st.integers(0, 5))
def test_targets_come_and_go_as_a_chain_of_two_states(prior: np.ndarray, a: float, b: float, steps: int) -> None:
    state = np.stack([1 - prior, prior], axis=-1)
    expected = state @ np.linalg.matrix_power(np.array([[1 - a, a], [b, 1 - b]]), steps)
    later = EvidenceGrid(prior).predict(a, b, steps)
    assert later.theta == pytest.approx(expected[..., 1], abs=1e-12)
    assert np.isfinite(later.entropy).all()


@given(maps, st.floats(0.01, 0.5), st.floats(0.01, 0.5))
def test_left_alone_cells_tend_to_the_stationary_theta(prior: np.ndarray, a: float, b: float) -> None:
    far = EvidenceGrid(prior).predict(a, b, 5000)
    assert far.theta == pytest.approx(np.full((2, 3), stationary_theta(a, b)))


def test_a_chain_that_never_changes_has_no_limit_and_changes_nothing() -> None:
    with pytest.raises(InvalidProblemError, match="no limit"):
        stationary_theta(0.0, 0.0)
    prior = np.array([[0.0, 0.3, 1.0]])
    assert EvidenceGrid(prior).predict(0.0, 0.0, 7).theta == pytest.approx(prior)


def test_hits_and_misses_count_into_a_beta_law() -> None:
    rate = BetaGrid.uniform((1, 2), 2.0, 3.0).update([0, 1, 0, 0], [True, False, True, False])
    assert rate.alpha.tolist() == [[4.0, 2.0]]
    assert rate.beta.tolist() == [[4.0, 4.0]]
    assert rate.mean == pytest.approx(np.array([[0.5, 1 / 3]]))


@pytest.mark.parametrize("bad", [[[1.5]], [[-0.1]], [[np.nan]], [0.5], [[]]])
def test_a_theta_that_makes_no_sense_is_refused(bad: list) -> None:
    with pytest.raises(InvalidProblemError, match="theta"):
        EvidenceGrid(bad)  # type: ignore[arg-type]


@pytest.mark.parametrize(("alpha", "beta"), [([[0.0]], [[1.0]]), ([[1.0]], [[np.inf]]), ([[1.0]], [[1.0, 1.0]])])
def test_a_beta_law_that_makes_no_sense_is_refused(alpha: list, beta: list) -> None:
    with pytest.raises(InvalidProblemError):
        BetaGrid(alpha, beta)  # type: ignore[arg-type]


@pytest.mark.parametrize(("cells", "hits"), [([6], [True]), ([-1], [True]), ([0, 1], [True]), ([0.0], [True])])
def test_looks_that_make_no_sense_are_refused(cells: list, hits: list) -> None:
    with pytest.raises(InvalidProblemError, match="look"):
        EvidenceGrid.uniform((2, 3)).update(cells, hits, 0.8, 0.1)
    with pytest.raises(InvalidProblemError, match="look"):
        BetaGrid.uniform((2, 3)).update(cells, hits)
