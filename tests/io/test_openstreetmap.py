from pathlib import Path

import numpy as np
import pytest

from sooner.errors import DataFormatError, InvalidProblemError
from sooner.io.occupancy_graphs import EARTH_M, read_street_map
from sooner.io.openstreetmap import read_openstreetmap

osmium = pytest.importorskip("osmium")

CORNER = (46.0, 11.0)


def place(east_m, north_m):
    lat = CORNER[0] + np.degrees(north_m / EARTH_M)
    return lat, CORNER[1] + np.degrees(east_m / EARTH_M / np.cos(np.radians(CORNER[0])))


def extract(folder: Path, ways, lacking=(), bounds=(100.0, 100.0), name="city.osm") -> Path:
    """A file of ways [(tags, [(east_m, north_m), ...])] whose nodes are numbered from 1; `lacking` are left out."""
    lines, number, told = [], 0, []
    for way, (tags, points) in enumerate(ways, start=1):
        refs = []
        for point in points:
            number += 1
            refs.append(f'<nd ref="{number}"/>')
            lat, lon = place(*point)
            if number not in lacking:
                lines.append(f'<node id="{number}" version="1" lat="{lat:.9f}" lon="{lon:.9f}"/>')
        marks = [f'<tag k="{key}" v="{value}"/>' for key, value in tags.items()]
        told.append(f'<way id="{way}" version="1">{"".join(refs + marks)}</way>')
    box = ""
    if bounds:
        north, east = place(*bounds)
        box = f'<bounds minlat="{CORNER[0]}" minlon="{CORNER[1]}" maxlat="{north:.7f}" maxlon="{east:.7f}"/>'
    path = folder / name
    path.write_text(f'<osm version="0.6">{box}{"".join(lines + told)}</osm>')
    return path


STREET = {"highway": "residential"}
ALONG = (STREET, [(2.0, 52.5), (98.0, 52.5)])
UP = ({"highway": "footway"}, [(52.5, 2.0), (52.5, 98.0)])


def test_streets_become_an_occupancy_graph(tmp_path):
    street_map = read_openstreetmap(extract(tmp_path, [ALONG, UP]))
    graph = street_map.graph
    assert graph.grid.shape == (20, 20)
    assert graph.n_nodes == 39
    assert graph.degrees.max() == 4
    rows, cols = np.divmod(graph.cells, 20)
    assert ((rows == 9) | (cols == 10)).all()  # 52.5 m north is the 11th row from the south
    assert street_map.name == "city"
    assert "OpenStreetMap" in street_map.attribution
    assert street_map.south_west == pytest.approx(CORNER)


@pytest.mark.parametrize(
    "tags",
    [
        {"highway": "motorway"},
        {"highway": "trunk_link"},
        {"highway": "construction"},
        {"highway": "pedestrian", "area": "yes"},
        {"highway": "footway", "layer": "-1"},
        {"highway": "footway", "tunnel": "yes"},
        {"highway": "corridor", "indoor": "yes"},
        {"railway": "rail"},
        {},
    ],
)
def test_what_is_no_street_for_people_seen_from_above_is_left_out(tmp_path, tags):
    graph = read_openstreetmap(extract(tmp_path, [ALONG, (tags, UP[1])])).graph
    assert graph.n_nodes == 20


def test_the_window_and_the_scale_are_those_asked_for(tmp_path):
    path = extract(tmp_path, [ALONG, UP])
    graph = read_openstreetmap(path, shape=(4, 8), south_west=place(30.0, 40.0), scale=1.0).graph
    assert graph.grid.shape == (4, 8)
    assert graph.n_nodes == 8 + 4 - 1
    half = read_openstreetmap(path, scale=2.0)
    assert half.graph.grid.shape == (10, 10)
    assert half.graph.n_nodes == 19


def test_pbf_says_the_same_as_osm(tmp_path):
    path = extract(tmp_path, [ALONG, UP])
    packed = tmp_path / "city.osm.pbf"
    with osmium.SimpleWriter(str(packed)) as writer:
        for entity in osmium.FileProcessor(str(path)):
            writer.add(entity)
    one, two = (read_openstreetmap(file, (20, 20), south_west=CORNER).graph for file in (path, packed))
    assert np.array_equal(one.cells, two.cells)
    assert np.array_equal(one.edges, two.edges)


def test_an_extract_without_roads_is_refused(tmp_path):
    for ways in ([], [({"building": "yes"}, ALONG[1])], [({"highway": "motorway"}, ALONG[1])]):
        with pytest.raises(DataFormatError, match="an extract without roads came"):
            read_openstreetmap(extract(tmp_path, ways))


def test_roads_beside_the_window_are_no_street_in_it(tmp_path):
    with pytest.raises(DataFormatError, match="no street lies on the grid"):
        read_openstreetmap(extract(tmp_path, [ALONG]), (10, 10), south_west=place(0.0, 500.0))


def test_a_road_whose_nodes_are_missing_is_refused_or_cut(tmp_path):
    bent = (STREET, [(2.0, 22.5), (48.0, 22.5), (60.0, 22.5), (72.0, 22.5), (98.0, 22.5)])
    path = extract(tmp_path, [ALONG, bent], lacking=(5,))
    with pytest.raises(DataFormatError, match="1 roads came whose nodes are not all in the extract, way 2 among them"):
        read_openstreetmap(path)
    graph = read_openstreetmap(path, cut=True).graph
    assert graph.n_nodes == 20 + 10 + 6
    assert np.unique(graph.components).size == 3


def test_nodes_missing_far_from_the_window_do_no_harm(tmp_path):
    far = (STREET, [(2.0, 22.5), (98.0, 22.5), (300.0, 22.5), (400.0, 22.5)])
    assert read_openstreetmap(extract(tmp_path, [ALONG, far], lacking=(6,))).graph.n_nodes == 40


def test_an_extract_without_any_node_is_refused(tmp_path):
    with pytest.raises(DataFormatError, match="not all in the extract"):
        read_openstreetmap(extract(tmp_path, [ALONG], lacking=(1, 2)))


def test_a_file_without_bounds_needs_a_window(tmp_path):
    path = extract(tmp_path, [ALONG], bounds=None)
    with pytest.raises(DataFormatError, match="expected bounds, or a south-west corner"):
        read_openstreetmap(path)
    with pytest.raises(DataFormatError, match="expected bounds, or a number of cells"):
        read_openstreetmap(path, south_west=CORNER)
    assert read_openstreetmap(path, (20, 20), south_west=CORNER).graph.n_nodes == 20


def test_bounds_of_a_country_are_refused(tmp_path):
    with pytest.raises(DataFormatError, match="bounds of 300000 m by 200000 m came"):
        read_openstreetmap(extract(tmp_path, [ALONG], bounds=(300_000.0, 200_000.0)))


@pytest.mark.parametrize(
    ("name", "text"),
    [("a.osm", ""), ("a.osm", '<osm version="0.6"><node id="1" lat="x"'), ("a.pbf", "nonsense"), ("a.txt", "b")],
)
def test_what_is_no_extract_is_refused(tmp_path, name, text):
    (tmp_path / name).write_text(text)
    with pytest.raises(DataFormatError, match="it cannot be read"):
        read_openstreetmap(tmp_path / name)
    with pytest.raises(DataFormatError, match="no such file"):
        read_openstreetmap(tmp_path / "none.osm")
    with pytest.raises(DataFormatError, match="a folder came"):
        read_openstreetmap(tmp_path)


@pytest.mark.parametrize(
    "settings", [{"scale": 0.0}, {"scale": np.nan}, {"south_west": (95.0, 0.0)}, {"cell_m": -1.0}, {"shape": (0, 4)}]
)
def test_a_window_that_cannot_be_is_refused(tmp_path, settings):
    with pytest.raises(InvalidProblemError):
        read_openstreetmap(extract(tmp_path, [ALONG]), **({"shape": (20, 20)} | settings))


def test_without_pyosmium_the_message_says_what_to_install(tmp_path, monkeypatch):
    monkeypatch.setitem(__import__("sys").modules, "osmium", None)
    with pytest.raises(DataFormatError, match="pip install 'sooner\\[openstreetmap\\]'"):
        read_openstreetmap(extract(tmp_path, [ALONG]))


@pytest.mark.parametrize(
    ("name", "nodes", "edges"),
    [("randalls_island_x2", 1, 4), ("silver_spring_suburb_x2", 1, 1), ("west_oakland_gridiron", 2, 6)],
)
def test_real_extracts_give_the_graphs_made_of_them_by_others(occupancy_graphs, name, nodes, edges):
    """Of 218 to 466 nodes those that only one of the two has: ours are exact, theirs walked in steps of 5 cm."""
    theirs = read_street_map(occupancy_graphs / f"{name}.graph.json")
    path = occupancy_graphs / f"{name}.osm"
    ours = read_openstreetmap(path, (40, 40), 5.0, theirs.south_west, theirs.scale).graph
    told = theirs.graph
    assert len(np.setxor1d(ours.cells, told.cells)) == nodes
    pairs = [{tuple(pair) for pair in graph.cells[graph.edges].tolist()} for graph in (ours, told)]
    assert len(pairs[0] ^ pairs[1]) == edges
    _, mine, other = np.intersect1d(ours.cells, told.cells, return_indices=True)
    assert np.abs(ours.positions_m[mine] - told.positions_m[other]).max() < 0.03
