"""Searches to train in: streets from seeds, the paper's team."""

from __future__ import annotations

from collections.abc import Iterable
from functools import lru_cache
from typing import Any

import numpy as np

from sooner.errors import InvalidProblemError
from sooner.scenarios import STREET_KINDS, street_grid
from sooner.simulation import Scene, World

__all__ = ["generated_scenes"]


def generated_scenes(seeds: Iterable[int] = range(12), **settings: Any) -> tuple[Scene, ...]:
    """A search over 200 m x 200 m of streets from each seed; gridiron, suburb and park by turns.

    Parameters
    ----------
    seeds : whole numbers      of the streets. Keep those you train on apart from those you report
    settings                   of each `Scene`, besides its world

    Raises
    ------
    InvalidProblemError        seeds that are not whole numbers of at least 0, settings that no `Scene` can have

    Examples
    --------
    >>> scenes = generated_scenes(range(3), seconds=120)
    >>> [scene.grid.shape for scene in scenes], scenes[0].seconds
    ([(40, 40), (40, 40), (40, 40)], 120)
    """
    if not isinstance(seeds, Iterable):
        raise InvalidProblemError(f"seeds = {seeds!r} came; expected several, such as range(12)")
    seeds = tuple(seeds)
    for seed in seeds:
        if not isinstance(seed, int | np.integer) or isinstance(seed, bool) or seed < 0:
            raise InvalidProblemError(f"seed {seed!r} came; expected whole numbers of at least 0")
    return tuple(Scene(_city(int(seed)), **settings) for seed in seeds)


@lru_cache(maxsize=32)  # worlds never change, and environments that fly side by side may share them
def _city(seed: int) -> World:
    kinds = tuple(STREET_KINDS)
    return World(street_grid(kinds[seed % len(kinds)], seed))
