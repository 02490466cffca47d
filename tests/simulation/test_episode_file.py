"""Episodes in files: what comes back is what went in; what nobody wrote is refused with a reason."""

import io
import json
import zipfile
from dataclasses import replace

import numpy as np
import pytest

from sooner.errors import DataFormatError, InvalidProblemError
from sooner.simulation import Agent, Estimator, Keep, Scene, World, load_episode, replayed, save_episode, simulate
from sooner.simulation.strategies import Lawnmower, RandomWaypoints
from sooner.streets import Evasive, TargetWalk
from tests.meddled import rewritten
from tests.simulation.streets import blocks
from tests.simulation.test_loop import Wrong

WORLD = World(blocks(), TargetWalk(rest=0.3), 2, Evasive(np.empty((0, 2)), 9.0))
SCENE = Scene(WORLD, (Agent(), Agent(v_max=5.0)), Estimator(decay=0.2), 40, 5, (0.5, 0.5))
FLOWN = simulate(SCENE, RandomWaypoints(), 3, Keep(True, 10))


@pytest.fixture
def saved(tmp_path):
    path = tmp_path / "episode.npz"
    save_episode(FLOWN, path)
    return path


def assert_same(one, other):
    assert one.seed == other.seed
    assert one.strategy == other.strategy
    assert one.calls == other.calls
    for name in ("targets", "places_m", "node_seconds", "sums"):
        np.testing.assert_array_equal(getattr(one, name), getattr(other, name))
    for a, b in zip(one.plans, other.plans, strict=True):
        for x, y in zip(a, b, strict=True):
            np.testing.assert_array_equal(x, y)
    for part in ("looks", "beliefs"):
        mine, theirs = getattr(one, part), getattr(other, part)
        assert (mine is None) == (theirs is None)
        for name in vars(mine) if mine is not None else ():
            np.testing.assert_array_equal(getattr(mine, name), getattr(theirs, name))


def test_a_saved_episode_comes_back(saved):
    loaded = load_episode(saved)
    assert_same(loaded, FLOWN)
    assert loaded.e == FLOWN.e
    assert loaded.scene.agents == SCENE.agents
    assert loaded.scene.estimator == SCENE.estimator


def test_a_bare_episode_comes_back(tmp_path):
    flown = simulate(replace(SCENE, world=World(blocks(), n_targets=0)), Lawnmower(), 3)
    save_episode(flown, tmp_path / "bare.npz")
    assert_same(load_episode(tmp_path / "bare.npz"), flown)


def test_a_loaded_episode_flies_again_the_same(saved):
    assert_same(replayed(load_episode(saved)), FLOWN)


def test_a_strategy_of_somebody_elses_can_be_kept_but_not_flown_again(tmp_path):
    flown = simulate(SCENE, Wrong(tuple(np.zeros((1, 2)) for _ in range(2))), 3)
    save_episode(flown, tmp_path / "e.npz")
    loaded = load_episode(tmp_path / "e.npz")
    assert loaded.strategy is None
    with pytest.raises(InvalidProblemError, match="not ours"):
        replayed(loaded)


def test_a_bias_that_is_a_function_cannot_be_kept(tmp_path):
    biased = World(blocks(), TargetWalk(bias=lambda states, weights: np.ones_like(weights)))
    flown = simulate(Scene(biased, seconds=10), Lawnmower(), 1)
    with pytest.raises(InvalidProblemError, match="function"):
        save_episode(flown, tmp_path / "e.npz")


def about(change):
    def changed(array):
        said = json.loads(bytes(array))
        change(said)
        return np.frombuffer(json.dumps(said).encode(), np.uint8)

    return changed


def deeper(said):
    said["agents"][0]["map_sensor"] = {"sensitivity": -1.0}


@pytest.mark.parametrize(
    "changes",
    [
        {"sums": None},
        {"about": None},
        {"looks_cells": None},
        {"beliefs_void": None},
        {"about": np.zeros(4, np.uint8)},
        {"about": np.frombuffer(b"[" * 100_000, np.uint8)},
        {"about": np.frombuffer(b"9" * 10_000, np.uint8)},
        {"about": about(lambda said: said.update(format="x"))},
        {"about": about(lambda said: said.pop("agents"))},
        {"about": about(lambda said: said.update(shape=[1e9, 1e9]))},
        {"about": about(lambda said: said.update(shape="20"))},
        {"about": about(lambda said: said.update(seconds=10**9))},
        {"about": about(lambda said: said.update(seconds=float("inf")))},
        {"about": about(lambda said: said.update(seed="x"))},
        {"about": about(lambda said: said.update(agents=[{"wings": 2}]))},
        {"about": about(lambda said: said.update(strategy={"name": "random", "settings": {"x": 1}}))},
        {"about": about(lambda said: said.update(strategy=[1]))},
        {"about": about(deeper)},
        {"cells": lambda a: a + 10**6},
        {"edges": lambda a: a[:, ::-1]},
        {"node_places_m": lambda a: a * np.nan},
        {"targets": lambda a: a + 10**6},
        {"targets": lambda a: a[:-1]},
        {"places_m": lambda a: a * np.inf},
        {"node_seconds": lambda a: a.astype(float)},
        {"sums": lambda a: -a - 1},
        {"calls": lambda a: np.array([[0, 10**6, 0]])},
        {"calls": lambda a: np.array([[0, 1, 5]])},
        {"route_lengths": lambda a: a[:-1]},
        {"route_lengths": lambda a: -a},
        {"waypoints": lambda a: a[1:]},
        {"looks_firsts": lambda a: a[::-1].copy()},
        {"looks_agents": lambda a: a + 2},
        {"looks_cells": lambda a: -a - 1},
        {"beliefs_void": lambda a: a + 1},
        {"beliefs_explored": lambda a: a.astype(int)},
        {"extra": np.zeros(3)},
    ],
    ids=lambda changes: next(iter(changes)),
)
def test_what_contradicts_itself_is_refused(saved, changes):
    with pytest.raises(DataFormatError, match="expected an episode"):
        load_episode(rewritten(saved, **changes))


def test_pickles_are_not_opened(saved):
    rewritten(saved, sums=np.array([{"a": 1}], dtype=object))
    with pytest.raises(DataFormatError, match="no array of numbers"):
        load_episode(saved)


@pytest.mark.parametrize("data", [b"", b"hello", b"PK\x03\x04" + b"\0" * 60])
def test_what_is_no_archive_is_refused(tmp_path, data):
    path = tmp_path / "x.npz"
    path.write_bytes(data)
    with pytest.raises(DataFormatError, match="npz"):
        load_episode(path)


def test_a_file_that_is_not_there_is_named(tmp_path):
    with pytest.raises(DataFormatError, match="no such file"):
        load_episode(tmp_path / "none.npz")


@pytest.mark.parametrize("shape", ["(99999999999,)", "(-2, -3)", "(6, None)"])
def test_an_array_that_says_it_is_larger_than_it_is_is_refused(tmp_path, shape):
    head = f"{{'descr': '<f8', 'fortran_order': False, 'shape': {shape}, }}"
    head = head + " " * (117 - len(head)) + "\n"
    data = b"\x93NUMPY\x01\x00" + len(head).to_bytes(2, "little") + head.encode() + np.zeros(6).tobytes()
    path = tmp_path / "x.npz"
    with zipfile.ZipFile(path, "w") as archive:
        archive.writestr("sums.npy", data)
    with pytest.raises(DataFormatError, match="no array of numbers"):
        load_episode(path)


def test_too_much_is_refused_before_it_is_unpacked(tmp_path, monkeypatch):
    monkeypatch.setattr("sooner.io.arrays.MOST_BYTES", 1000)
    save_episode(FLOWN, tmp_path / "e.npz")
    with pytest.raises(DataFormatError, match="bytes, came"):
        load_episode(tmp_path / "e.npz")


def test_damaged_files_are_refused(saved):
    whole = saved.read_bytes()
    rng = np.random.default_rng(0)
    for _ in range(60):
        damaged = bytearray(whole)
        for place in rng.integers(len(whole), size=8):
            damaged[place] = rng.integers(256)
        saved.write_bytes(bytes(damaged))
        try:
            load_episode(saved)
        except DataFormatError:
            continue


def test_a_name_twice_is_no_crash(tmp_path):
    part = io.BytesIO()
    np.save(part, np.zeros(3))
    path = tmp_path / "x.npz"
    with zipfile.ZipFile(path, "w") as archive:
        archive.writestr("sums.npy", part.getvalue())
        with pytest.warns(UserWarning, match="Duplicate"):
            archive.writestr("sums.npy", part.getvalue())
    with pytest.raises(DataFormatError, match="missing"):
        load_episode(path)
