import contextlib
import hashlib
import json
import zipfile
from itertools import islice

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.ndimage import label

from sooner.errors import DataFormatError, InvalidProblemError
from sooner.grid import Grid
from sooner.scenarios.natural import (
    EXPERIMENT_2_CELLS,
    NATURAL_KINDS,
    NaturalEnvironment,
    _largest_component,
    _majority,
    _without_small_obstacles,
    downsampled,
    experiment_2,
    natural_environment,
    natural_environments,
    starts,
)

NONUNIFORM = ("low", "med", "high", "vhf")
FROZEN = {
    "vlf": (3, "900234fc"),
    "low": (2, "6213e94d"),
    "med": (2, "8853fb5f"),
    "high": (2, "ba27fee3"),
    "vhf": (1, "8d9908c6"),
    "fine": (2, "cc1cdd05"),
}
SIDES_AND_CORNERS = np.ones((3, 3))

maps = st.integers(0, 2**32 - 1).map(lambda seed: np.random.default_rng(seed).random((9, 14)) < 0.6)


def obstacles(free: np.ndarray) -> np.ndarray:
    """Cells of each obstacle."""
    return np.bincount(label(~free, SIDES_AND_CORNERS)[0].ravel())[1:]


@pytest.fixture(scope="module")
def environments() -> dict[str, list[NaturalEnvironment]]:
    return {kind: list(islice(natural_environments(kind), 10)) for kind in NATURAL_KINDS}


@pytest.mark.parametrize("kind", NATURAL_KINDS)
def test_free_space_is_one_piece_of_about_two_thirds(environments, kind):
    for environment in environments[kind]:
        assert label(environment.free)[1] == 1
        assert 0.9 * 0.66 <= environment.free.mean() <= 0.68


@pytest.mark.parametrize("kind", NATURAL_KINDS)
def test_no_obstacle_is_smaller_than_twenty_five_cells_of_the_usual_size(environments, kind):
    for environment in environments[kind]:
        width = environment.grid.shape[1]
        assert obstacles(environment.free).min() >= 25 * (width / 200) ** 2


def test_higher_frequencies_make_more_and_smaller_obstacles(environments):
    counts = {kind: np.mean([obstacles(made.free).size for made in environments[kind]]) for kind in environments}
    assert counts["vlf"] < counts["low"] < counts["med"] < counts["high"] < counts["vhf"]
    assert counts["vlf"] < 5
    assert counts["vhf"] > 15


def test_environments_are_numbered_by_the_seeds_that_algorithm_4_accepts(environments):
    seeds = [environment.seed for environment in environments["low"]]
    assert seeds == sorted(set(seeds))
    assert seeds[0] >= 1
    fifth = natural_environment("low", 5)
    assert fifth.seed == seeds[4]
    assert fifth.checksum() == environments["low"][4].checksum()


def test_the_ground_is_what_it_was():
    """Frozen: benchmarks name environments by kind and number."""
    found = {kind: natural_environment(kind, 1, nonuniform=kind in NONUNIFORM) for kind in NATURAL_KINDS}
    assert {kind: (made.seed, made.checksum()[:8]) for kind, made in found.items()} == FROZEN


def test_smaller_cells_draw_the_same_ground():
    usual, fine = natural_environment("med"), natural_environment("med", shape=(300, 600), cell_m=2.2 / 3)
    assert usual.seed == fine.seed
    assert np.mean(usual.free == fine.free[::3, ::3]) > 0.98


def test_more_cells_are_more_ground_of_the_same_character():
    usual, large = natural_environment("vhf"), natural_environment("vhf", shape=(200, 400))
    assert 2.5 < obstacles(large.free).size / obstacles(usual.free).size < 6


@given(maps)
def test_of_two_free_pieces_the_larger_one_stays(free):
    kept = _largest_component(free)
    sizes = np.bincount(label(free)[0].ravel())[1:]
    assert kept.sum() == sizes.max()
    assert not (kept & ~free).any()
    assert label(kept)[1] == 1


@given(maps, st.integers(1, 9))
def test_small_obstacles_go_and_what_is_free_stays_in_one_piece(free, smallest):
    piece = _largest_component(free)
    opened = _without_small_obstacles(piece, smallest)
    assert (opened >= piece).all()
    assert label(opened)[1] == 1
    assert sorted(obstacles(opened)) == sorted(size for size in obstacles(piece) if size >= smallest)


@pytest.mark.parametrize("kind", NONUNIFORM)
def test_half_the_cells_have_low_entropy_wherever_obstacles_stand(kind):
    agree = []
    for environment in islice(natural_environments(kind, nonuniform=True), 10):
        assert environment.low_entropy.mean() == pytest.approx(0.5, abs=1e-4)
        assert set(np.unique(environment.theta).round(2)) == {0.5, 0.97}
        agree.append(np.corrcoef(environment.low_entropy.ravel(), environment.free.ravel())[0, 1])
    assert abs(np.mean(agree)) < 0.15


def test_low_entropy_leaves_the_obstacles_as_they_are():
    plain, nonuniform = (natural_environment("high", 3, nonuniform=flag) for flag in (False, True))
    assert np.array_equal(plain.free, nonuniform.free)
    assert (plain.theta == 0.5).all()


@pytest.mark.parametrize("n_cells", EXPERIMENT_2_CELLS)
def test_experiment_2_draws_the_same_ground_in_more_or_fewer_cells(n_cells):
    made, finest = experiment_2(2, n_cells), experiment_2(2, EXPERIMENT_2_CELLS[-1])
    assert made.grid.n_cells == n_cells
    assert made.grid.shape[1] == 2 * made.grid.shape[0]
    assert made.grid.cell_m * made.grid.shape[1] == pytest.approx(440.0)
    assert label(made.free)[1] == 1
    rows, cols = ((np.arange(old) * new) // old for old, new in zip((400, 800), made.grid.shape, strict=True))
    assert np.mean(made.free[np.ix_(rows, cols)] == finest.free) > 0.98


def test_downsampling_to_its_own_size_changes_nothing():
    environment = natural_environment("vhf", 2, nonuniform=True)
    assert downsampled(environment, (100, 200)).checksum() == environment.checksum()


@settings(max_examples=30)
@given(maps, st.integers(1, 9), st.integers(1, 14))
def test_a_coarse_cell_is_what_most_of_its_ground_is(free, rows, cols):
    fine = np.kron(free, np.ones((rows, cols)))  # every old cell cut so that new cells are whole numbers of pieces
    share = fine.reshape(rows, 9, cols, 14).mean((1, 3))
    tie = free[
        np.ix_(((np.arange(rows) + 0.5) * 9 / rows).astype(int), ((np.arange(cols) + 0.5) * 14 / cols).astype(int))
    ]
    expected = np.where(np.isclose(share, 0.5), tie, share > 0.5)
    assert np.array_equal(_majority(free, (rows, cols)), expected)


@given(st.integers(1, 50), st.integers(0, 2**32))
def test_starts_are_free_and_different_and_come_again(count, seed):
    environment = NaturalEnvironment("low", 3, Grid((10, 10), "square8", 2.2, np.arange(100).reshape(10, 10) % 2 == 0))
    cells = starts(environment, count, seed)
    assert len(set(cells)) == count
    assert all(environment.free[cell] for cell in cells)
    assert cells == starts(environment, count, seed)


def test_a_saved_environment_comes_back(tmp_path):
    for flag in (False, True):
        made = natural_environment("med", 2, nonuniform=flag)
        made.save(tmp_path / "a.npz")
        made.save(tmp_path / "b")
        read = NaturalEnvironment.load(tmp_path / "a.npz")
        assert (read.kind, read.seed, read.grid.cell_m) == (made.kind, made.seed, made.grid.cell_m)
        assert np.array_equal(read.free, made.free)
        assert np.array_equal(read.theta, made.theta)
        assert (tmp_path / "a.npz").read_bytes() == (tmp_path / "b").read_bytes()


def written(path, **changed) -> None:
    """A small environment's file, with members changed or left out, and its checksum set right again."""
    facts = {"kind": "low", "seed": 3, "rows": 2, "cols": 3, "cell_m": 2.2} | changed.pop("facts", {})
    about = json.dumps(facts).encode()
    flags = np.array([[0, 1, 0], [0, 0, 0]], np.uint8)
    checksum = hashlib.sha256(about + np.packbits(flags == 0).tobytes()).hexdigest().encode()
    whole = {"about": np.frombuffer(about, np.uint8), "obstacles": flags}
    whole |= {"checksum": np.frombuffer(checksum, np.uint8)} | changed
    np.savez(path, **{name: array for name, array in whole.items() if array is not None})


HOSTILE = {
    "no about": {"about": None},
    "no obstacles": {"obstacles": None},
    "no checksum": {"checksum": None},
    "a stranger": {"stranger": np.zeros(1, np.uint8)},
    "pickle": {"obstacles": np.array([["boo"]], object)},
    "floats": {"obstacles": np.full((2, 3), np.nan)},
    "a row": {"obstacles": np.zeros(6, np.uint8)},
    "nothing": {"obstacles": np.zeros((0, 3), np.uint8)},
    "no flags": {"obstacles": np.full((2, 3), 2, np.uint8)},
    "all obstacles": {"obstacles": np.ones((2, 3), np.uint8)},
    "other obstacles": {"obstacles": np.eye(2, 3, dtype=np.uint8)},
    "another shape": {"low_entropy": np.zeros((3, 2), np.uint8)},
    "low entropy added": {"low_entropy": np.zeros((2, 3), np.uint8)},
    "long about": {"about": np.zeros(5000, np.uint8)},
    "no JSON": {"about": np.frombuffer(b"{", np.uint8)},
    "a list": {"about": np.frombuffer(b"[1]", np.uint8)},
    "nested": {"about": np.frombuffer(b"[" * 999, np.uint8)},
    "an unknown kind": {"facts": {"kind": "hilly"}},
    "a kind that is a list": {"facts": {"kind": ["low"]}},
    "a seed that is text": {"facts": {"seed": "1"}},
    "a seed below one": {"facts": {"seed": -1}},
    "NaN metres": {"facts": {"cell_m": float("nan")}},
    "no metres": {"facts": {"cell_m": 0.0}},
}


def test_the_small_file_is_good_before_it_is_spoilt(tmp_path):
    written(tmp_path / "good.npz")
    assert NaturalEnvironment.load(tmp_path / "good.npz").free.tolist() == [[True, False, True], [True, True, True]]


@pytest.mark.parametrize("how", HOSTILE)
def test_a_spoilt_file_is_refused(tmp_path, how):
    written(tmp_path / "bad.npz", **HOSTILE[how])
    with pytest.raises(DataFormatError, match=r"bad\.npz.*came.*expected"):
        NaturalEnvironment.load(tmp_path / "bad.npz")


@pytest.mark.parametrize("shape", ["(4, -3)", "(999999999, 999999999)", "(2, 3.0)", "(((", "2, 2, 2"])
def test_a_header_that_lies_is_refused_before_anything_is_made_of_that_size(tmp_path, shape):
    written(tmp_path / "good.npz")
    header = f"{{'descr': '|u1', 'fortran_order': False, 'shape': {shape}, }}\n".encode()
    with zipfile.ZipFile(tmp_path / "good.npz") as good, zipfile.ZipFile(tmp_path / "bad.npz", "w") as bad:
        for name in good.namelist():
            content = good.read(name)
            if name == "obstacles.npy":
                content = b"\x93NUMPY\x01\x00" + len(header).to_bytes(2, "little") + header + bytes(6)
            bad.writestr(name, content)
    with pytest.raises(DataFormatError):
        NaturalEnvironment.load(tmp_path / "bad.npz")


@given(st.data())
def test_a_damaged_file_is_refused_or_the_same(tmp_path_factory, data):
    path = tmp_path_factory.getbasetemp() / "damaged.npz"
    made = NaturalEnvironment("low", 3, Grid((4, 6), "square8", 2.2, np.arange(24).reshape(4, 6) % 5 == 0))
    made.save(path)
    content = bytearray(path.read_bytes())
    place = data.draw(st.integers(0, len(content) - 1))
    content[place] = data.draw(st.integers(0, 255))
    path.write_bytes(content[: data.draw(st.sampled_from([len(content), place]))])
    with contextlib.suppress(DataFormatError):
        assert NaturalEnvironment.load(path).checksum() == made.checksum()


@pytest.mark.parametrize(
    "make",
    [
        lambda: natural_environment("hilly"),
        lambda: natural_environment("low", 0),
        lambda: natural_environment("low", shape=(0, 5)),
        lambda: natural_environment("low", cell_m=float("nan")),
        lambda: natural_environment("fine", nonuniform=True),
        lambda: experiment_2(1, 5000),
        lambda: downsampled(natural_environment("low"), (50, 90)),
        lambda: downsampled(natural_environment("low"), (200, 400)),
        lambda: downsampled(natural_environment("low"), (0, 0)),
        lambda: starts(natural_environment("low"), 20_001, 0),
        lambda: starts(natural_environment("low"), 1, -1),
    ],
)
def test_what_makes_no_sense_is_refused(make):
    with pytest.raises(InvalidProblemError, match="came"):
        make()
