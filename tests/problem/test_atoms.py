"""Atoms of many cells and actions against cells grouped one by one."""

from collections import defaultdict

import numpy as np
import pytest

from sooner.problem.atoms import Footprints, atoms_of


@pytest.mark.parametrize(("n_cells", "n_actions", "seed"), [(40, 3, 1), (4000, 12, 2), (9000, 60, 3)])
def test_atoms_are_cells_that_the_same_actions_look_at_as_often(n_cells: int, n_actions: int, seed: int) -> None:
    rng = np.random.default_rng(seed)
    looks = rng.choice(3, (n_actions, n_cells), p=[0.7, 0.2, 0.1]) * (rng.random(n_cells) < 0.8)
    cells = [np.repeat(np.arange(n_cells, dtype=np.int32), row) for row in looks]
    starts = np.cumsum([0, *map(len, cells)])
    seconds, back = rng.random((2, starts[-1])).astype(np.float32)
    found = atoms_of(Footprints(starts, np.concatenate(cells), seconds, back), n_cells)
    together = defaultdict(set)
    for cell, column in enumerate(looks.T):
        together[column.tobytes() if column.any() else b""].add(int(found.of_cell[cell]))
    assert together.pop(b"", {-1}) == {-1}
    assert all(len(atoms) == 1 for atoms in together.values())
    assert len(set.union(*together.values())) == len(together) == found.n_atoms
    assert np.array_equal(found.sizes, np.bincount(found.of_cell[found.of_cell >= 0]))
    for action in range(n_actions):
        own, entries = found.of(action), slice(starts[action], starts[action + 1])
        covered = np.bincount(found.of_cell[cells[action]], minlength=found.n_atoms)
        assert np.array_equal(np.bincount(own, minlength=found.n_atoms) * found.sizes, covered)
        mean = found.seconds[found.starts[action] : found.starts[action + 1]] @ found.sizes[own]
        assert mean == pytest.approx(float(seconds[entries].astype(np.float64).sum()))
