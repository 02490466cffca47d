"""Streets that go on: marks as a plain recomputation gives them, laws, and towns that nothing was learnt from."""

from math import atan2, exp, hypot, pi

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from sooner.belief import StreetContinuation, StreetKriging, StreetModel
from sooner.errors import InvalidProblemError
from sooner.grid import Grid
from sooner.scenarios import STREET_KINDS, street_grid

seeds = st.integers(0, 2**32 - 1)
WIDE = Grid((40, 40), "square8", 5.0)


def searched(rng, rows, cols):
    """A town half seen: void probabilities, what is explored, and where nodes were detected."""
    explored = rng.random((rows, cols)) < rng.uniform(0.2, 0.9)
    void = np.where(explored, rng.random((rows, cols)), 0.9)
    return void, explored, explored & (void < 0.3)


def plain_marks(void, explored, nodes):
    """Cell by cell, from the definition."""
    rows, cols = void.shape
    built = np.where(explored, np.where(nodes, 1.0, 1.0 - void), 0.0)
    share = (built.sum() + 16.0) / (explored.sum() + 64.0)

    def at(array, row, col, beyond):
        return array[row, col] if 0 <= row < rows and 0 <= col < cols else beyond

    marks, strengths = np.zeros((rows, cols, 37)), np.zeros((rows, cols, 16))
    for r, c in np.argwhere(built >= 0.5):
        if explored[max(r - 2, 0) : r + 3, max(c - 2, 0) : c + 3].all():
            continue
        for row, col in np.argwhere(~explored):
            down, right = row - r, col - c
            far = hypot(down, right)
            if far > 8.0:
                continue
            steps = round(far)
            way = [(r + round(down * n / steps), c + round(right * n / steps)) for n in range(1, steps)]
            if any(explored[cell] and built[cell] < 0.5 for cell in way):
                continue
            lined = sum(at(built, r + round(-down * n / far), c + round(-right * n / far), 0.0) for n in range(1, 6))
            distance = sum(far > edge for edge in (1.6, 2.6, 4.1, 6.1))
            marks[row, col, 5 * distance + min(int(lined), 4)] += 1.0
            sector = int((atan2(down, right) + pi) / (2.0 * pi) * 16) % 16
            strengths[row, col, sector] = max(strengths[row, col, sector], lined * exp(-far / 5.0))
    marks = np.minimum(marks, 4.0)
    for row, col in np.argwhere(~explored):
        told, lines = marks[row, col], strengths[row, col]
        facing = max(min(lines[k], lines[(k + 8 + turn) % 16]) for k in range(16) for turn in (-1, 0, 1))
        told[25:28] = *np.sort(lines)[:-3:-1], facing
        for n, side in enumerate((1, 3, 6)):
            square = np.s_[max(row - side, 0) : row + side + 1, max(col - side, 0) : col + side + 1]
            told[28 + n] = explored[square].sum() / (2 * side + 1) ** 2
            told[31 + n] = (built[square].sum() - share * explored[square].sum()) / (2 * side + 1)
        told[34:37] = share, explored.mean(), min(row, rows - 1 - row, col, cols - 1 - col, 5) / 5.0
    return marks.reshape(-1, 37)


@pytest.mark.parametrize(("seed", "rows", "cols"), [(0, 13, 17), (1, 20, 9), (2, 3, 30), (3, 1, 1), (4, 16, 16)])
def test_marks_are_those_of_a_plain_recomputation(seed, rows, cols):
    void, explored, nodes = searched(np.random.default_rng(seed), rows, cols)
    marks = StreetContinuation(Grid((rows, cols))).marks(void.ravel(), explored.ravel(), nodes.ravel())
    np.testing.assert_allclose(marks, plain_marks(void, explored, nodes), atol=1e-9)


@given(seeds)
def test_the_model_is_one_layer_of_hidden_units_over_the_marks(seed):
    rng = np.random.default_rng(seed)
    model = StreetModel(rng.normal(size=(37, 5)), rng.normal(size=5), rng.normal(size=5), 0.3)
    void, explored, nodes = (each.ravel() for each in searched(rng, 11, 12))
    streets = StreetContinuation(Grid((11, 12)), model)
    told = streets.expected_void(void, explored, nodes)
    log_odds = np.maximum(streets.marks(void, explored, nodes) @ model.hidden + model.offsets, 0.0) @ model.output + 0.3
    with np.errstate(over="ignore"):
        expected = np.clip(1.0 / (1.0 + np.exp(log_odds)), 0.01, 0.99)
    np.testing.assert_allclose(told, np.where(explored, void, expected), atol=1e-9)


@given(seeds)
def test_what_is_explored_stays_and_what_was_believed_of_the_rest_does_not_matter(seed):
    rng = np.random.default_rng(seed)
    void, explored, nodes = (each.ravel() for each in searched(rng, 15, 15))
    streets, before = StreetContinuation(Grid((15, 15))), void.copy()
    told = streets.expected_void(void, explored, nodes)
    np.testing.assert_array_equal(void, before)
    np.testing.assert_array_equal(told[explored], void[explored])
    assert (told[~explored] >= 0.01).all()
    assert (told[~explored] <= 0.99).all()
    np.testing.assert_array_equal(told, streets.expected_void(np.where(explored, void, 0.5), explored, nodes))


def test_a_street_that_was_seen_to_end_does_not_go_on():
    street, explored = np.zeros((40, 40), bool), np.zeros((40, 40), bool)
    street[10, :20] = street[30, :16] = True
    explored[:, :20] = True
    void = np.where(street, 0.0, 1.0).ravel()
    told = StreetContinuation(WIDE).expected_void(void, explored.ravel(), (street & explored).ravel()).reshape(40, 40)
    assert told[10, 20:22].max() < 0.5
    assert told[30, 20:22].min() > 0.8


def test_a_known_map_is_left_as_it_is():
    void = np.random.default_rng(0).random(1600)
    told = StreetContinuation(WIDE).expected_void(void, np.ones(1600, bool), void < 0.5)
    np.testing.assert_array_equal(told, void)


def log_loss(void, built):
    p = np.clip(1.0 - void, 0.005, 0.995)
    return -np.where(built, np.log(p), np.log(1.0 - p)).mean()


@pytest.mark.parametrize("kind", STREET_KINDS)
def test_it_foretells_new_towns_better_than_kriging_and_than_their_mean(kind):
    """Towns half seen in lanes, of seeds that nothing was learnt from; six of each kind."""
    losses = []
    for seed in range(90_000, 90_006):
        graph = street_grid(kind, seed)
        built = graph.node_of_cell >= 0
        explored = (np.arange(1600) % 40) // 5 % 4 < 2
        void = np.where(explored, np.where(built, 0.01, 0.99), 0.9)
        first, second = graph.positions_m[graph.edges].transpose(1, 2, 0)
        seen = (explored & built)[graph.cells[graph.edges]].all(axis=1)
        angles = np.arctan2(*(second - first)[::-1])[seen]
        kriged = StreetKriging().session(WIDE).expected_void(void, explored, angles)
        told = StreetContinuation(WIDE).expected_void(void, explored, explored & built)
        mean = np.full(1600, 1.0 - built[explored].mean())
        losses.append([log_loss(each[~explored], built[~explored]) for each in (told, kriged, mean)])
    learnt, kriged, mean = np.mean(losses, axis=0)
    assert learnt < 0.98 * kriged
    assert learnt < 0.98 * mean


def test_a_model_comes_back_from_its_file_with_five_digits(tmp_path):
    rng = np.random.default_rng(3)
    model = StreetModel(rng.normal(size=(37, 4)), rng.normal(size=4), rng.normal(size=4), -1.25)
    model.write(tmp_path / "model.csv")
    read = StreetModel.read(tmp_path / "model.csv")
    for name in ("hidden", "offsets", "output", "bias"):
        np.testing.assert_allclose(getattr(read, name), getattr(model, name), rtol=1e-4)


def test_hexagons_are_refused():
    with pytest.raises(InvalidProblemError, match="hexagonal cells came"):
        StreetContinuation(Grid((4, 4), "hex"))
