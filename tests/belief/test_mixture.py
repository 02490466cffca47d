"""Mixtures against scikit-learn on copied points, and on surfaces that are hardly surfaces."""

import numpy as np
import pytest

from sooner.belief.mixture import CELL_VARIANCE, fit_mixture


def hills(shape=(40, 50)):
    rows, cols = np.indices(shape)
    return 3 * np.exp(-((rows - 10) ** 2 + (cols - 12) ** 2) / 40) + np.exp(-((rows - 28) ** 2 + (cols - 38) ** 2) / 90)


def test_the_fit_is_that_of_scikit_learn_on_copies():
    mixture_of = pytest.importorskip("sklearn.mixture").GaussianMixture
    surface = hills()
    counts = np.floor(np.rint(surface / surface.max() * 255) / 30).astype(int)
    points = np.repeat(np.argwhere(counts), counts[counts > 0], axis=0)
    ours = fit_mixture(surface, 2, np.random.default_rng(0), tolerance=1e-10, rounds=2000)
    theirs = mixture_of(2, tol=1e-10, max_iter=2000, reg_covar=CELL_VARIANCE, means_init=ours.means).fit(points)
    assert ours.converged
    assert ours.means == pytest.approx(theirs.means_, abs=1e-3)
    assert ours.weights == pytest.approx(theirs.weights_, abs=1e-4)
    assert ours.covariances == pytest.approx(theirs.covariances_, rel=1e-3, abs=1e-3)


def test_weights_total_one_and_covariances_are_positive():
    for seed in range(5):
        mixture = fit_mixture(hills(), 5, np.random.default_rng(seed))
        assert mixture.weights.sum() == pytest.approx(1.0)
        assert (np.linalg.eigvalsh(mixture.covariances) > 0).all()


def test_the_same_seed_gives_the_same_mixture():
    first, second = (fit_mixture(hills(), 4, np.random.default_rng(2)) for _ in range(2))
    assert np.array_equal(first.means, second.means)


@pytest.mark.parametrize("surface", [np.zeros((4, 5)), np.ones((4, 5)), np.eye(20)[3].reshape(4, 5), np.ones((1, 1))])
@pytest.mark.parametrize("components", [1, 3, 30])
def test_degenerate_surfaces_are_fitted(surface, components):
    mixture = fit_mixture(surface, components, np.random.default_rng(0))
    assert len(mixture.weights) <= min(components, surface.size)
    assert np.isfinite(mixture.means).all()
    assert np.isfinite(mixture.covariances).all()


def test_a_fit_that_does_not_converge_starts_again_and_says_so():
    class Counting:
        def __init__(self):
            self.rng, self.calls = np.random.default_rng(0), 0

        def choice(self, *args, **kwargs):
            self.calls += 1
            return self.rng.choice(*args, **kwargs)

    counting = Counting()
    mixture = fit_mixture(hills(), 3, counting, tolerance=0.0, rounds=2, tries=4)
    assert not mixture.converged
    assert counting.calls == 4
