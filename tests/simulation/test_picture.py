"""Pictures of episodes: they are drawn, whatever happened, and an animation has its frames."""

import io
from dataclasses import replace

import numpy as np
import pytest
from PIL import Image

from sooner.errors import InvalidProblemError
from sooner.simulation import Agent, Call, Estimator, Scene, World, simulate
from sooner.simulation.picture import animation_of, picture_of
from sooner.simulation.strategies import Lawnmower, RandomWaypoints
from tests.simulation.streets import blocks

FLOWN = simulate(Scene(World(blocks(), n_targets=2), seconds=40), RandomWaypoints(), 1)


def test_a_picture_is_a_png_and_the_same_twice():
    drawn = picture_of(FLOWN)
    assert drawn.startswith(b"\x89PNG")
    assert picture_of(FLOWN) == drawn


@pytest.mark.parametrize(
    "scene",
    [
        Scene(World(blocks(), n_targets=0), (Agent(),) * 9, seconds=4, replan_s=4),
        Scene(World(blocks()), (Agent(),), Estimator(prior="known"), seconds=1, replan_s=1),
    ],
)
def test_strange_episodes_have_pictures(scene):
    assert picture_of(simulate(scene, Lawnmower(), 1)).startswith(b"\x89PNG")


def test_false_calls_and_false_nodes_are_drawn():
    seconds = FLOWN.node_seconds.copy()
    seconds[0] = 3
    strange = replace(FLOWN, node_seconds=seconds, calls=(Call(9, 0, -1), Call(12, 44, 1)))
    assert picture_of(strange) != picture_of(FLOWN)


def test_an_animation_has_a_frame_every_so_many_seconds():
    with Image.open(io.BytesIO(animation_of(FLOWN, every_s=20))) as film:
        assert film.format == "GIF"
        assert film.n_frames == 3
        film.seek(2)
        last = np.asarray(film.convert("RGB"))
        film.seek(0)
        assert (np.asarray(film.convert("RGB")) != last).any()


@pytest.mark.parametrize("every_s", [0, -1])
def test_frames_that_are_none_are_refused(every_s):
    with pytest.raises(InvalidProblemError, match="frame every"):
        animation_of(FLOWN, every_s)
