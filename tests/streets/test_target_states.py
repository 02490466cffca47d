import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from sooner.grid import Grid
from sooner.streets import OccupancyGraph, TargetStates, growth
from tests.streets.graphs import random_graph


def enumerated(graph, detected):
    """States and transitions of the explored graph, by their definition."""
    touching = {tuple(edge) for edge in graph.explored_edges(detected).tolist()}
    touching |= {(b, a) for a, b in touching} | {(int(node), int(node)) for node in np.flatnonzero(detected)}
    transitions = {(s, t) for s in touching for t in touching if s[1] == t[0]}
    return touching, transitions


@given(st.integers(0, 2**32 - 1))
def test_states_and_transitions_are_those_of_the_definition(seed):
    graph = random_graph(np.random.default_rng(seed))
    states = TargetStates(graph)
    touching, transitions = enumerated(graph, np.ones(graph.n_nodes, bool))
    pairs = list(zip(states.previous.tolist(), states.current.tolist(), strict=True))
    assert len(set(pairs)) == states.n_states == len(touching)
    assert set(pairs) == touching
    told = {(pairs[s], pairs[t]) for s in range(states.n_states) for t in states.outgoing(s)}
    assert told == transitions
    assert states.n_transitions == len(transitions)
    degrees = graph.degrees
    assert states.n_transitions == (degrees**2).sum() + 2 * degrees.sum() + graph.n_nodes


@given(st.integers(0, 2**32 - 1))
def test_each_detected_node_adds_what_proposition_1_says(seed):
    """[Wolek2020, Proposition 1], over random orders of detection and graphs with triangles."""
    rng = np.random.default_rng(seed)
    graph = random_graph(rng)
    detected = np.zeros(graph.n_nodes, bool)
    counts = [0, 0]
    for node in rng.permutation(graph.n_nodes):
        grown = growth(graph, detected, int(node))
        detected[node] = True
        counts = [counts[0] + grown.states, counts[1] + grown.transitions]
        assert counts == [len(found) for found in enumerated(graph, detected)]
        assert TargetStates(graph).explored(detected).sum() == counts[0]


def test_random_graphs_have_triangles():
    triangles = 0
    for seed in range(20):
        graph = random_graph(np.random.default_rng(seed))
        near = np.zeros((graph.n_nodes, graph.n_nodes))
        near[tuple(graph.edges.T)] = near[tuple(graph.edges.T[::-1])] = 1
        triangles += np.trace(near @ near @ near) / 6
    assert triangles > 10


def test_reversing_a_state_twice_gives_it_back():
    states = TargetStates(random_graph(np.random.default_rng(5)))
    moving = np.arange(states.n_nodes, states.n_states)
    back = states.reverse[moving - states.n_nodes]
    assert np.array_equal(states.previous[back], states.current[moving])
    assert np.array_equal(states.current[back], states.previous[moving])
    assert np.array_equal(states.reverse[back - states.n_nodes], moving)


def test_a_heading_points_from_the_node_before_to_the_node_now():
    grid = Grid((2, 2), "square8", 5.0)  # cells 0, 1 in the north; 2, 3 in the south
    states = TargetStates(OccupancyGraph.of(grid, [0, 2, 3], [(0, 1), (1, 2)]))
    heading = dict(
        zip(zip(states.previous.tolist(), states.current.tolist(), strict=True), states.heading, strict=True)
    )
    assert np.isclose(heading[1, 0], np.pi / 2)
    assert np.isclose(heading[1, 2], 0.0)
    assert np.isclose(heading[0, 1], -np.pi / 2)
    assert np.isnan(heading[1, 1])


def test_a_lone_node_has_one_state_that_leads_to_itself():
    states = TargetStates(OccupancyGraph.of(Grid((1, 1)), [0], []))
    assert states.n_states == states.n_transitions == 1
    assert states.outgoing(0).tolist() == [0]
