import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from sooner.errors import InvalidProblemError
from sooner.grid import Grid
from sooner.streets import OccupancyGraph
from tests.streets.graphs import random_graph

GRID = Grid((3, 4), "square8", 5.0)


@pytest.mark.parametrize(
    ("cells", "edges", "said"),
    [
        ([], [], "without nodes came"),
        ([1, 5, 1], [], r"two nodes in cell \[0, 1\] came"),
        ([1, 12], [], "a node in cell 12 came; the grid has cells 0 to 11"),
        ([-1, 3], [], "a node in cell -1 came"),
        ([0, 2], [(0, 1)], r"an edge between cells \[0, 0\] and \[0, 2\] came"),
        (
            [3, 4],
            [(0, 1)],
            r"an edge between cells \[0, 3\] and \[1, 0\] came",
        ),  # numbers 3 and 4
        ([0, 1], [(1, 1)], "an edge from node 1 to itself came"),
        ([0, 1], [(0, 2)], "an edge to node 2 came; there are 2 nodes"),
        ([0, 1], [(-1, 0)], "an edge to node -1 came"),
        ([0.5, 1.0], [], "expected whole numbers"),
        ([0, 1], [(0.0, 1.0)], "expected whole numbers"),
    ],
)
def test_a_graph_that_cannot_be_is_refused_with_the_reason(cells, edges, said):
    with pytest.raises(InvalidProblemError, match=said):
        OccupancyGraph.of(GRID, cells, edges)


@pytest.mark.parametrize("place", [(2.6, 0.0), (np.nan, 0.0), (0.0, np.inf), (5.0, 0.0)])
def test_a_node_beside_its_cell_is_refused(place):
    with pytest.raises(InvalidProblemError, match="which is not in its cell"):
        OccupancyGraph.of(GRID, [8], [], [place])


def test_places_of_another_number_are_refused():
    with pytest.raises(InvalidProblemError, match="for 1 nodes"):
        OccupancyGraph.of(GRID, [8], [], [(0.0, 0.0), (0.0, 0.0)])


def test_nodes_out_of_order_and_edges_told_twice_need_sorting():
    places = GRID.centres_m
    with pytest.raises(InvalidProblemError, match="out of the order"):
        OccupancyGraph(GRID, np.array([1, 0]), np.empty((0, 2), np.int64), places[[1, 0]])
    for edges in ([(1, 0)], [(0, 1), (0, 1)]):
        with pytest.raises(InvalidProblemError, match="told twice, or the larger node first"):
            OccupancyGraph(GRID, np.array([0, 1]), np.array(edges), places[:2])


def test_hexagons_carry_no_streets():
    with pytest.raises(InvalidProblemError, match="hexagons"):
        OccupancyGraph.of(Grid((2, 2), "hex"), [0], [])


def test_a_graph_cannot_be_changed_from_outside():
    cells = np.array([0, 1])
    graph = OccupancyGraph.of(GRID, cells, [(0, 1)])
    cells[:] = 7
    assert graph.cells.tolist() == [0, 1]
    with pytest.raises(ValueError, match="read-only"):
        graph.edges[0, 0] = 1


def test_every_table_says_the_same_of_the_edges():
    graph = random_graph(np.random.default_rng(3))
    told = {(a, b) for a, b in graph.edges.tolist()} | {(b, a) for a, b in graph.edges.tolist()}
    rows = [graph.neighbours[graph.starts[node] : graph.starts[node + 1]] for node in range(graph.n_nodes)]
    assert {(node, int(other)) for node, row in enumerate(rows) for other in row} == told
    assert all(np.all(np.diff(row) > 0) for row in rows)
    assert graph.degrees.tolist() == [len(row) for row in rows]
    assert np.array_equal(np.flatnonzero(graph.node_of_cell >= 0), graph.cells)
    assert np.array_equal(graph.node_of_cell[graph.cells], np.arange(graph.n_nodes))


@given(st.integers(0, 2**32 - 1))
def test_nodes_are_in_one_component_exactly_when_a_way_joins_them(seed):
    graph = random_graph(np.random.default_rng(seed), edge_share=0.2)
    reach = np.eye(graph.n_nodes, dtype=bool)
    reach[tuple(graph.edges.T)] = reach[tuple(graph.edges.T[::-1])] = True
    for _ in range(graph.n_nodes):
        reach = reach @ reach
    assert np.array_equal(graph.components[:, None] == graph.components, reach)
    first_seen = graph.components[np.sort(np.unique(graph.components, return_index=True)[1])]
    assert np.array_equal(first_seen, np.arange(len(first_seen)))


@given(st.integers(0, 2**32 - 1))
def test_the_order_in_which_nodes_come_does_not_matter(seed):
    rng = np.random.default_rng(seed)
    graph = random_graph(rng)
    order = rng.permutation(graph.n_nodes)
    number = np.argsort(order)
    edges = number[graph.edges][:, ::-1][rng.permutation(graph.n_edges)]
    again = OccupancyGraph.of(graph.grid, graph.cells[order], np.repeat(edges, 2, axis=0), graph.positions_m[order])
    assert np.array_equal(again.cells, graph.cells)
    assert np.array_equal(again.edges, graph.edges)
    assert np.array_equal(again.positions_m, graph.positions_m)


def test_explored_edges_have_both_nodes_detected():
    graph = OccupancyGraph.of(GRID, [0, 1, 2], [(0, 1), (1, 2)])
    assert graph.explored_edges(np.array([True, True, False])).tolist() == [[0, 1]]
