"""Atoms that several graphs share, where searchers fly unlike one another: cells that no action of any tells apart."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from itertools import pairwise

import numpy as np

from sooner.problem.atoms import Atoms, Footprints, atoms_of

__all__ = ["common_atoms"]


def common_atoms(footprints: Sequence[Footprints], n_cells: int) -> list[Atoms]:
    """The same atoms for all, with what the actions of each graph look at of them.

    Examples
    --------
    >>> when = np.zeros(3, np.float32)
    >>> wide = Footprints(np.array([0, 3]), np.array([0, 1, 2], np.int32), when, when)
    >>> narrow = Footprints(np.array([0, 1]), np.array([1], np.int32), when[:1], when[:1])
    >>> [each.covered.tolist() for each in common_atoms([wide, narrow], 4)], common_atoms([wide], 4)[0].n_atoms
    ([[0, 1], [1]], 1)
    """
    if len(footprints) == 1:
        return [atoms_of(footprints[0], n_cells)]
    entries = np.cumsum([0, *(len(each.cells) for each in footprints)])
    starts = [each.starts[:-1] + before for each, before in zip(footprints, entries[:-1], strict=True)]
    whole = Footprints(
        np.concatenate([*starts, entries[-1:]]),
        *(np.concatenate([getattr(each, name) for each in footprints]) for name in ("cells", "seconds", "back_s")),
    )
    atoms, actions = atoms_of(whole, n_cells), np.cumsum([0, *(each.n_actions for each in footprints)]).tolist()
    return [_part(atoms, first, last) for first, last in pairwise(actions)]


def _part(atoms: Atoms, first: int, last: int) -> Atoms:
    """Atoms with the entries of the actions from `first` to `last` - 1 only."""
    entries = slice(atoms.starts[first], atoms.starts[last])
    return replace(
        atoms,
        starts=atoms.starts[first : last + 1] - atoms.starts[first],
        covered=atoms.covered[entries],
        before=atoms.before[entries],
        seconds=atoms.seconds[entries],
        back_s=atoms.back_s[entries],
    )
