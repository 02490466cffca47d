"""Grounds of drones that fly unlike one another, laid side by side: one ground, in which each has its own copy."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from sooner.problem.region_ground import RegionGround

__all__ = ["stacked", "stacked_actions"]

Whole = NDArray[np.int64]


def stacked(grounds: Sequence[RegionGround]) -> RegionGround:
    """One ground of all, over the same atoms: regions and actions of each copy come one after another, searches first.

    Gains, and what the legs pay, are those of the first.
    """
    order = stacked_actions(grounds)
    counts = np.concatenate([np.diff(each.starts) for each in grounds])[order]
    begins = np.concatenate([each.starts[:-1] + shift for each, shift in _shifted(grounds, "atoms")])[order]
    entries = np.repeat(begins - (np.cumsum(counts) - counts), counts) + np.arange(counts.sum())
    atoms, before = (np.concatenate([getattr(each, name) for each in grounds])[entries] for name in ("atoms", "before"))
    by_atom = np.argsort(atoms, kind="stable")
    ways = [each.ways_from(region) for each in grounds for region in range(each.n_regions)]
    number = np.argsort(order)
    firsts = np.cumsum([0, *(each.n_actions for each in grounds)])
    copies = np.repeat(np.arange(len(grounds)), [each.n_regions for each in grounds])
    return replace(
        grounds[0],
        n_regions=sum(each.n_regions for each in grounds),
        ends=np.concatenate([each.ends + shift for each, shift in _shifted(grounds, "to_last")])[order],
        seconds=np.concatenate([each.seconds for each in grounds])[order],
        limit_s=sum(each.limit_s for each in grounds),
        to_last=np.concatenate([each.to_last for each in grounds]),
        starts=np.concatenate([[0], np.cumsum(counts)]),
        atoms=atoms,
        before=before,
        cover_starts=np.concatenate([[0], np.cumsum(np.bincount(atoms, minlength=len(grounds[0].gains)))]),
        covers=np.repeat(np.arange(len(counts)), counts)[by_atom],
        cover_before=before[by_atom],
        way_starts=np.cumsum([0, *map(len, ways)]),
        ways=np.array([number[firsts[c] + way] for c, own in zip(copies, ways, strict=True) for way, _ in own]),
    )


def stacked_actions(grounds: Sequence[RegionGround]) -> Whole:
    """(A,) int: for each action of the stacked ground, its place in the actions of all, ground after ground."""
    is_edge = np.concatenate([np.arange(each.n_actions) >= each.n_regions for each in grounds])
    return np.argsort(is_edge, kind="stable")


def _shifted(grounds: Sequence[RegionGround], counted: str) -> list[tuple[RegionGround, int]]:
    """Each ground with how much stands before it, of what is counted."""
    sizes = [len(getattr(each, counted)) for each in grounds]
    return list(zip(grounds, np.cumsum([0, *sizes[:-1]]).tolist(), strict=True))
