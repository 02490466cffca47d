from itertools import combinations

import numpy as np
import pytest

from sooner.errors import InvalidProblemError
from sooner.io import StreetMap, read_street_map, street_map_json
from sooner.scenarios import STREET_KINDS, street_grid


def share_of_largest(graph):
    return np.bincount(graph.components).max() / graph.n_nodes


@pytest.mark.parametrize("kind", STREET_KINDS)
def test_generated_streets_are_as_full_and_as_joined_as_the_authors_maps(kind):
    """Those have 349 to 504 nodes, 1.005 to 1.038 edges a node, and 84 to 91 % of nodes with two neighbours."""
    graphs = [street_grid(kind, seed) for seed in range(12)]
    for graph in graphs:
        assert 350 <= graph.n_nodes <= 520
        assert 0.99 <= graph.n_edges / graph.n_nodes <= 1.06
        assert graph.grid.shape == (40, 40)
        assert graph.grid.cell_m == 5.0
        assert 0.02 < np.mean(graph.degrees == 1) < 0.12
        assert 0.70 < np.mean(graph.degrees == 2) < 0.93
        assert np.bincount(graph.components).min() >= 5
    least = {"gridiron": 0.9, "suburb": 0.9, "park": 0.25}[kind]
    assert min(map(share_of_largest, graphs)) >= least


def test_parks_have_several_parts():
    assert max(len(np.unique(street_grid("park", seed).components)) for seed in range(8)) >= 3


@pytest.mark.parametrize("kind", STREET_KINDS)
def test_one_seed_one_map(kind):
    one, two = street_grid(kind, 5), street_grid(kind, 5)
    assert np.array_equal(one.cells, two.cells)
    assert np.array_equal(one.edges, two.edges)
    assert np.array_equal(one.positions_m, two.positions_m)


def test_seeds_and_kinds_differ():
    graphs = [street_grid(kind, seed) for kind in STREET_KINDS for seed in range(3)]
    for one, two in combinations(graphs, 2):
        assert not np.array_equal(one.cells, two.cells)


def test_other_shapes_have_as_many_nodes_to_a_cell():
    graph = street_grid("suburb", 1, (25, 60), 2.0)
    assert graph.grid.shape == (25, 60)
    assert 350 / 1600 <= graph.n_nodes / graph.grid.n_cells <= 520 / 1600


@pytest.mark.parametrize(
    ("settings", "said"),
    [
        ({"kind": "canals"}, "expected one of gridiron, suburb, park"),
        ({"seed": -1}, "seeds count from 0"),
        ({"shape": (40, 19)}, "at least 20 x 20"),
        ({"cell_m": 0.0}, "cell size"),
    ],
)
def test_streets_that_cannot_be_are_refused(settings, said):
    with pytest.raises(InvalidProblemError, match=said):
        street_grid(**settings)


def test_generated_streets_are_written_and_read(tmp_path):
    graph = street_grid("park", 2)
    path = tmp_path / "park.graph.json"
    path.write_bytes(street_map_json(StreetMap(graph, "a park")))
    again = read_street_map(path).graph
    assert np.array_equal(again.cells, graph.cells)
    assert np.array_equal(again.edges, graph.edges)
