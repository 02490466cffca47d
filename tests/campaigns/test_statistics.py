"""Estimates, rates and pairs, held against the library, against brute force, and against laws."""

from itertools import product

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy import stats

from sooner.campaigns.results import Results, collect
from sooner.campaigns.statistics import conditional, differences, estimate, paired, rate, sign_test
from sooner.errors import InvalidProblemError

NUMBERS = st.floats(-1e6, 1e6, allow_subnormal=False)


def at_once(sample, statistic: str, resamples: int = 4000) -> tuple[float, float, float]:
    """The percentile bootstrap that committed figures were made with: all resamples in one array."""
    of = {"mean": np.mean, "median": np.median}[statistic]
    values = np.asarray(sample, np.float64)
    drawn = values[np.random.default_rng(0).integers(0, len(values), (resamples, len(values)))]
    low, high = np.percentile(of(drawn, axis=1), [2.5, 97.5])
    return float(of(values)), float(low), float(high)


def results(planner: str, values: dict[int, float], instance: str = "hills") -> Results:
    return collect(instance, planner, 90, [(seed, {"pos": value}) for seed, value in values.items()])


@pytest.mark.parametrize("statistic", ["mean", "median"])
@pytest.mark.parametrize("n", [1, 2, 3, 30, 131, 999, 1000])
def test_up_to_a_thousand_trials_every_digit_is_as_it_was(n, statistic):
    for sample in (np.random.default_rng(n).normal(3.0, 7.0, n), np.arange(n) % 3, np.full(n, 0.1)):
        found = estimate(sample, statistic)
        assert (found.value, found.low, found.high) == at_once(sample, statistic)
        assert found.n == n


@given(st.lists(NUMBERS, min_size=1, max_size=40), st.sampled_from(["mean", "median"]), st.integers(1, 60))
def test_a_bootstrap_of_any_sample_is_as_if_drawn_at_once(sample, statistic, resamples):
    found = estimate(sample, statistic, resamples)
    assert (found.value, found.low, found.high) == at_once(sample, statistic, resamples)


def test_a_large_bootstrap_is_drawn_in_parts_and_still_the_same(monkeypatch):
    monkeypatch.setattr("sooner.campaigns.statistics._AT_ONCE", 7)
    sample = np.random.default_rng(3).random(31)
    assert estimate(sample, resamples=501).low == at_once(sample, "mean", 501)[1]


@pytest.mark.parametrize("statistic", ["mean", "median"])
def test_the_closed_form_agrees_with_the_bootstrap_that_it_replaces(statistic):
    sample = np.random.default_rng(5).gamma(2.0, 3.0, 3001)
    found = estimate(sample, statistic)
    value, low, high = at_once(sample, statistic)
    assert found.value == pytest.approx(value)
    assert (found.low, found.high) == (pytest.approx(low, abs=0.1 * (high - low)), pytest.approx(high, rel=0.01))


@pytest.mark.parametrize("n", [1001, 1002, 5000])
def test_the_median_of_many_lies_between_order_statistics_that_hold_it_in_95_of_100_samples(n):
    found = estimate(np.arange(n), "median")
    rank, mirrored = int(found.low) + 1, int(found.high) + 1
    assert found.value == np.median(np.arange(n))
    assert mirrored == n + 1 - rank
    held, next_held = (stats.binom.cdf(n - r, n, 0.5) - stats.binom.cdf(r - 1, n, 0.5) for r in (rank, rank + 1))
    assert next_held < 0.95 <= held


@pytest.mark.parametrize(
    ("n", "statistic", "least"), [(60, "mean", 0.90), (60, "median", 0.88), (1500, "median", 0.92)]
)
def test_intervals_hold_the_truth_about_as_often_as_they_say(n, statistic, least):
    rng = np.random.default_rng(11)
    truth = 2.0 if statistic == "mean" else stats.gamma.median(2.0)
    held = [e.low <= truth <= e.high for e in (estimate(rng.gamma(2.0, 1.0, n), statistic) for _ in range(200))]
    assert least <= np.mean(held) <= 0.99


def test_the_interval_is_that_of_the_library_but_for_the_luck_of_the_draw():
    sample = np.random.default_rng(2).exponential(1.0, 80)
    theirs = stats.bootstrap((sample,), np.mean, n_resamples=4000, method="percentile", rng=1).confidence_interval
    ours = estimate(sample)
    assert (ours.low, ours.high) == (pytest.approx(theirs.low, abs=0.02), pytest.approx(theirs.high, abs=0.02))


def test_three_trials_have_too_narrow_an_interval():
    rng = np.random.default_rng(8)
    held = [e.low <= 0 <= e.high for e in (estimate(rng.normal(size=3)) for _ in range(300))]
    assert np.mean(held) < 0.85


@pytest.mark.parametrize("sample", [[1.0, np.nan], [np.inf, 0.0], [], [[1.0, 2.0]]])
def test_a_sample_that_holds_no_number_or_none_at_all_is_refused(sample):
    with pytest.raises(InvalidProblemError, match=r"NaN or infinite|at least one trial"):
        estimate(sample)


def test_an_unknown_statistic_is_refused_by_name():
    with pytest.raises(InvalidProblemError, match=r"'mode' came; expected one of mean, median"):
        estimate([1.0], "mode")


@given(st.integers(1, 3000), st.data())
def test_a_rate_has_the_interval_of_wilson_inside_0_and_1_around_it(n, data):
    successes = data.draw(st.integers(0, n))
    found = rate(successes, n)
    theirs = stats.binomtest(successes, n).proportion_ci(method="wilson")
    assert (found.low, found.high) == (pytest.approx(theirs.low, abs=1e-12), pytest.approx(theirs.high, abs=1e-12))
    assert 0 <= found.low <= found.value <= found.high <= 1
    assert found.low < found.high
    other = rate(n - successes, n)
    assert (1 - other.high, 1 - other.low) == (pytest.approx(found.low), pytest.approx(found.high))


@pytest.mark.parametrize(("successes", "n"), [(0, 0), (-1, 4), (5, 4)])
def test_a_rate_of_impossible_counts_is_refused(successes, n):
    with pytest.raises(InvalidProblemError, match="0 <= successes <= n"):
        rate(successes, n)


@pytest.mark.parametrize("n", range(1, 11))
def test_the_sign_test_is_what_all_ways_to_toss_n_coins_say(n):
    heads = [sum(toss) for toss in product((0, 1), repeat=n)]
    for wins in range(n + 1):
        uneven = abs(2 * wins - n)
        assert sign_test(wins, n - wins) == pytest.approx(np.mean([abs(2 * h - n) >= uneven for h in heads]))


@given(st.integers(0, 4000), st.integers(0, 4000))
def test_the_sign_test_is_the_exact_binomial_test(wins, losses):
    expected = stats.binomtest(wins, wins + losses).pvalue if wins + losses else 1.0
    assert sign_test(wins, losses) == pytest.approx(expected, rel=1e-6, abs=1e-300)
    assert sign_test(wins, losses) == sign_test(losses, wins) <= 1.0


def test_a_conditional_mean_says_of_how_many():
    found = conditional([4.0, np.nan, 8.0, np.nan])
    assert (found.n, found.trials) == (2, 4)
    assert found.estimate == estimate([4.0, 8.0])
    assert conditional([np.nan]).estimate is None
    assert conditional([np.nan]).n == 0


SHARED = st.dictionaries(st.integers(0, 30), st.one_of(st.floats(-9, 9), st.just(1.0), st.none()), max_size=20)


@given(SHARED, SHARED)
def test_swapping_the_two_negates_the_difference_and_turns_wins_into_losses(one, other):
    one[31] = other[31] = 2.0
    ours, theirs = results("ours", one), results("theirs", other)
    here, there = paired(ours, theirs, "pos"), paired(theirs, ours, "pos")
    assert (here.wins, here.ties, here.losses) == (there.losses, there.ties, there.wins)
    assert here.p_value == there.p_value
    assert here.n == there.n == here.mean.n
    for a, b in ((here.mean, there.mean), (here.median, there.median)):
        assert (a.value, a.low, a.high) == (pytest.approx(-b.value), pytest.approx(-b.high), pytest.approx(-b.low))


@given(SHARED, SHARED)
def test_only_seeds_that_both_have_with_a_number_in_both_are_compared(one, other):
    one[31] = other[31] = 2.0
    expected = [
        one[s] - other[s]
        for s in sorted(one.keys() & other.keys())
        if isinstance(one[s], float) and isinstance(other[s], float)
    ]
    np.testing.assert_array_equal(differences(results("ours", one), results("theirs", other), "pos"), expected)


def test_pairing_sees_what_two_intervals_side_by_side_do_not():
    luck = np.random.default_rng(1).normal(0.0, 1.0, 40)
    ours, theirs = results("ours", dict(enumerate(luck + 0.05))), results("theirs", dict(enumerate(luck)))
    apart = [estimate(case.measure("pos")) for case in (ours, theirs)]
    assert apart[0].low < apart[1].high
    found = paired(ours, theirs, "pos")
    assert found.mean.low > 0
    assert found.p_value < 1e-9


def test_planners_without_a_common_seed_measure_or_instance_are_not_compared():
    ours = results("ours", {1: 0.5})
    with pytest.raises(InvalidProblemError, match="share no seed where both have pos"):
        paired(ours, results("theirs", {2: 0.5}), "pos")
    with pytest.raises(InvalidProblemError, match="no measure 'cost'; expected one of: pos"):
        paired(ours, ours, "cost")
    with pytest.raises(InvalidProblemError, match="seeds are shared luck on one instance only"):
        paired(ours, results("theirs", {1: 0.5}, "plain"), "pos")


ANSWERS = st.dictionaries(
    st.sampled_from("abcd"),
    st.one_of(st.none(), st.booleans(), st.integers(-9, 9), st.floats(-9, 9), st.text(max_size=2), st.just([1])),
)


@given(st.lists(ANSWERS, max_size=12), st.permutations(range(12)))
def test_every_number_of_every_answer_is_where_its_seed_is(answers, seeds):
    rows = list(zip(seeds, answers, strict=False))
    found = collect("hills", "greedy", None, rows)
    assert list(found.seeds) == sorted(seed for seed, _ in rows)
    numbers = {(seed, name): v for seed, answer in rows for name, v in answer.items() if isinstance(v, (int, float))}
    assert set(found.measures) == {name for _, name in numbers}
    for name, values in found.measures.items():
        expected = [numbers.get((seed, name), np.nan) for seed in found.seeds]
        np.testing.assert_array_equal(values, np.array(expected, float))
        kinds = {type(value) for (_, n), value in numbers.items() if n == name}
        assert (name in found.yes_no) == (kinds == {bool})


def test_what_is_not_finite_is_absent():
    found = collect(
        "hills", "greedy", None, [(1, {"gap": float("inf")}), (2, {"gap": 0.5}), (3, {"gap": float("nan")})]
    )
    np.testing.assert_array_equal(found.measures["gap"], [np.nan, 0.5, np.nan])


def test_results_that_contradict_themselves_are_refused():
    with pytest.raises(InvalidProblemError, match="greedy on hills, 90: seeds repeat or fall"):
        collect("hills", "greedy", 90, [(1, {}), (1, {})])
    with pytest.raises(InvalidProblemError, match=r"pos has shape \(1,\); expected \(2,\)"):
        Results("hills", "greedy", None, np.array([1, 2]), {"pos": np.array([0.5])}, frozenset())
    with pytest.raises(InvalidProblemError, match="found is yes or no"):
        Results("hills", "greedy", None, np.array([1]), {"found": np.array([0.5])}, frozenset({"found"}))


def test_results_keep_their_own_arrays_and_nobody_writes_to_them():
    seeds = np.array([1, 2])
    found = Results("hills", "greedy", None, seeds, {"pos": np.array([0.5, 1.0])}, frozenset())
    seeds[0] = 7
    assert found.seeds[0] == 1
    assert len(found) == 2
    with pytest.raises(ValueError, match="read-only"):
        found.measures["pos"][0] = 0.0
