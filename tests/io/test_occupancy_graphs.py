import json
from pathlib import Path

import numpy as np
import pytest

from sooner.errors import DataFormatError
from sooner.io.occupancy_graphs import StreetMap, read_street_map, street_map_json
from tests.streets.graphs import random_graph

GOOD = {
    "name": "three",
    "attribution": "nobody",
    "cell_m": 5.0,
    "size_m": 20.0,
    "nodes": [[7, 2.0, 3.0, 0, 0], [3, 6.0, 7.0, 1, 1], [4, 12.0, 19.0, 2, 3]],
    "edges": [[3, 7]],
}


def written(folder: Path, said) -> Path:
    path = folder / "map.graph.json"
    path.write_text(said if isinstance(said, str) else json.dumps(said))
    return path


def test_rows_count_from_the_south_in_the_file_and_from_the_north_in_the_grid(tmp_path):
    street_map = read_street_map(written(tmp_path, GOOD))
    graph = street_map.graph
    assert graph.grid.shape == (4, 4)
    assert [graph.grid.cell(cell) for cell in graph.cells] == [(0, 2), (2, 1), (3, 0)]
    assert graph.edges.tolist() == [[1, 2]]
    assert graph.positions_m.tolist() == [[9.5, 16.5], [3.5, 4.5], [-0.5, 0.5]]  # from the south-west cell's centre
    assert (street_map.name, street_map.attribution, street_map.scale) == ("three", "nobody", 1.0)


def test_a_street_map_comes_back_as_it_was_written(tmp_path):
    graph = random_graph(np.random.default_rng(8), rows=7, cols=5)
    street_map = StreetMap(graph, "seven by five", "us", (46.1, 11.2), 2.0)
    path = tmp_path / "map.json"
    path.write_bytes(street_map_json(street_map))
    again = read_street_map(path)
    assert again.graph.grid.shape == (7, 5)
    assert np.array_equal(again.graph.cells, graph.cells)
    assert np.array_equal(again.graph.edges, graph.edges)
    assert np.allclose(again.graph.positions_m, graph.positions_m)
    assert (again.name, again.attribution, again.south_west, again.scale) == ("seven by five", "us", (46.1, 11.2), 2.0)


@pytest.mark.parametrize(
    ("change", "said"),
    [
        ({"nodes": []}, "nodes: [] came; expected a list of at least one node"),
        ({"nodes": None}, "nodes: nothing came"),
        ({"edges": {}}, "edges: {} came"),
        ({"cell_m": 0}, "cell_m: 0 came; expected a positive number"),
        ({"cell_m": True}, "cell_m: True came"),
        ({"cell_m": "5"}, "cell_m: '5' came"),
        ({"size_m": 21.0}, "size_m: 21.0 came; expected metres that are whole cells of 5 m"),
        ({"size_m": 1e300}, "size_m: 1e+300 came"),
        ({"size_m": None}, "shape: nothing came; expected [rows, columns]"),
        ({"cell_m": 1e300, "shape": [4, 4]}, "cell_m: 1e+300 came; expected 0.001 to 1e+06 m"),
        ({"size_m": 50_000.0}, "shape: [10000, 10000] came; expected [rows, columns] of at most 1000000 cells"),
        ({"shape": [4]}, "shape: [4] came"),
        ({"shape": [10**30, 4]}, "came; expected [rows, columns]"),
        ({"nodes": [[0, 2.0, 3.0, 0]]}, "nodes[0]: [0, 2.0, 3.0, 0] came; expected numbers"),
        ({"nodes": [[0, 2.0, 3.0, 0.0, 0]]}, "nodes[0]:"),
        ({"nodes": [7]}, "nodes[0]: 7 came"),
        ({"nodes": [*GOOD["nodes"], [4, 17.0, 3.0, 3, 0]]}, "nodes[3]: a second node 4 came; expected each id once"),
        ({"nodes": [*GOOD["nodes"], [5, 3.0, 3.0, 0, 0]]}, "nodes 7 and 5 came in one cell, bx 0, by 0"),
        ({"nodes": [[0, 2.0, 23.0, 0, 4]], "edges": []}, "cell bx 0, by 4 came; expected columns 0 to 3 and rows 0"),
        ({"nodes": [[0, 2.0, 3.0, -1, 0]], "edges": []}, "cell bx -1, by 0 came"),
        (
            {"nodes": [[0, 2.0, 3.0, 1, 0]], "edges": []},
            "x_m 2, y_m 3 came, which is not in its cell, bx 1, by 0; expected x_m 5",
        ),
        ({"edges": [[3, 9]]}, "edges[0]: node 9 came; expected a node of this file"),
        ({"edges": [[3, 3]]}, "an edge from node 3 to itself came"),
        ({"edges": [[7, 4]]}, "an edge between nodes 7 and 4 came, whose cells do not touch"),
        ({"edges": [[3]]}, "edges[0]: [3] came; expected a pair of nodes"),
        ({"edges": [["3", "7"]]}, "edges[0]: ['3', '7'] came"),
        ({"sw_corner_latlon": [1.0]}, "sw_corner_latlon: [1.0] came"),
        ({"sw_corner_latlon": [91.0, 0.0]}, "sw_corner_latlon"),
        (
            {"sw_corner_latlon": [46.0, 1e300]},
            "[46.0, 1e+300] came; expected [latitude, longitude], from",
        ),
        ({"scale_real_metres_per_map_metre": -2}, "scale_real_metres_per_map_metre: -2 came"),
    ],
)
def test_a_file_that_cannot_be_is_refused_with_the_key(tmp_path, change, said):
    with pytest.raises(DataFormatError) as refused:
        read_street_map(written(tmp_path, GOOD | change))
    assert said in str(refused.value)


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("", "it is not JSON"),
        ("[" * 100_000, "it is not JSON"),
        ("[1, 2]", "[1, 2] came"),
        ('{"cell_m": ' + "9" * 5000 + "}", "it is not JSON"),
        (json.dumps(GOOD).replace("2.0", "NaN", 1), "nodes[0]: [7, nan, 3.0, 0, 0] came"),
        (json.dumps(GOOD).replace("5.0", "Infinity", 1), "cell_m: inf came"),
        (json.dumps(GOOD).replace("2.0", "1e999", 1), "nodes[0]:"),
    ],
)
def test_hostile_text_is_refused(tmp_path, text, said):
    with pytest.raises(DataFormatError) as refused:
        read_street_map(written(tmp_path, text))
    assert said in str(refused.value)


def test_every_node_outside_its_cell_is_told(tmp_path):
    with pytest.raises(DataFormatError) as refused:
        read_street_map(written(tmp_path, GOOD | {"nodes": [[k, 99.0, 3.0, k, 0] for k in range(3)]}))
    assert [fault.key for fault in refused.value.faults] == ["nodes[0]", "nodes[1]", "nodes[2]"]


def test_names_of_files_do_not_reach_a_terminal_raw(tmp_path):
    assert read_street_map(written(tmp_path, GOOD | {"attribution": "\x1b[31mus"})).attribution == "\\x1b[31mus"


def test_every_fault_is_told_ten_at_most(tmp_path):
    nodes = [[k, 2.0, 3.0, 0, 99] for k in range(30)]
    with pytest.raises(DataFormatError) as refused:
        read_street_map(written(tmp_path, GOOD | {"nodes": nodes}))
    assert len(refused.value.faults) == 10


def test_a_missing_file_is_refused(tmp_path):
    with pytest.raises(DataFormatError, match="no such file"):
        read_street_map(tmp_path / "none.json")


@pytest.mark.parametrize(
    ("name", "nodes", "edges", "parts"),
    [
        ("authors_map1_randalls_island", 504, 523, [261, 107, 62, 30, 18, 9, 8, 4, 4, 1]),
        ("authors_map2_silver_spring", 349, 354, [305, 44]),
        ("authors_map3_nyc", 370, 372, [347, 23]),
    ],
)
def test_the_authors_maps_have_their_nodes_edges_and_components(occupancy_graphs, name, nodes, edges, parts):
    street_map = read_street_map(occupancy_graphs / f"{name}.graph.json")
    graph = street_map.graph
    assert (graph.n_nodes, graph.n_edges, graph.grid.shape) == (nodes, edges, (40, 40))
    assert sorted(np.bincount(graph.components).tolist(), reverse=True) == parts
    assert street_map.scale == 2.0
    assert "OpenStreetMap" in street_map.attribution
