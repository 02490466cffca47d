import numpy as np
import pytest
import shapely

from sooner.errors import DataFormatError
from sooner.io.local_frame import LocalFrame
from sooner.missions import read_mission
from sooner.missions.faults import Faults
from sooner.missions.layers import Layers
from sooner.missions.settings import Settings
from sooner.planners import solve
from sooner.planners.registry import make_planner
from tests.missions.drawn import LAT, LON, box, drawn, mission, place, point, polygon_of, raster

AREA = box(0, 0, 1000, 1000, (300, 300, 500, 600))
LAUNCH = ("launch", point(50, 50))
POLYGON = 'polygon = "area.geojson"\ncell_m = 50'


@pytest.fixture
def folder(tmp_path):
    drawn(tmp_path / "area.geojson", ("Area", AREA), LAUNCH)
    return tmp_path


def layers(path):
    import tomllib

    faults = Faults(path)
    found = Layers.read(faults, Settings.model_validate(tomllib.loads(path.read_text())))
    faults.refuse()
    return found


def refused(path, key, *words):
    with pytest.raises(DataFormatError) as caught:
        read_mission(path)
    fault = next((each for each in caught.value.faults if each.key == key), None)
    assert fault is not None, str(caught.value)
    for word in words:
        assert word in str(fault)


# ---------------------------------------------------------------- polygons


def test_without_a_map_the_person_is_anywhere_in_the_polygon_alike(folder):
    found = layers(mission(folder, POLYGON))
    weights = found.weights / found.weights.max()
    assert weights.sum() * 2500.0 == pytest.approx(found.area.polygon.area, rel=1e-9)
    assert found.area.polygon.area == pytest.approx(1e6 - 200 * 300, rel=0.01)
    assert (weights[found.obstacles == False] == 1.0).all()  # noqa: E712
    assert found.outside == 0.0
    assert any("metres true to 1e-06" in note for note in found.notes)


def test_cells_that_can_be_entered_lie_wholly_in_the_area_and_off_its_margin(folder):
    drawn(folder / "zones.geojson", ("Village", box(600, 100, 800, 300)), ("Mast", point(200, 800), {"radius_m": 80}))
    text = POLYGON.replace("50", "20") + '\nno_fly = "zones.geojson"\nmargin_m = 15'
    found = layers(mission(folder, text))
    free = found.area.flyable(15.0)
    assert free.area < found.area.polygon.area - 200 * 200 - np.pi * 80**2
    rows, cols = np.nonzero(~found.obstacles)
    x, y = cols * 20.0, (found.shape[0] - 1 - rows) * 20.0
    squares = shapely.box(x - 10, y - 10, x + 10, y + 10)
    assert shapely.area(shapely.difference(squares, free)).max() < 1e-3
    assert len(rows) * 400.0 > 0.8 * free.area
    assert found.area.polygon.exterior.distance(free) == pytest.approx(15.0, abs=1e-6)
    mast = shapely.Point(found.area.frame.metres([place(200, 800)[::-1]])[0])
    assert free.distance(mast) == pytest.approx(95.0, abs=0.5)


def test_a_mission_over_a_polygon_is_planned_and_lies_on_the_globe(folder):
    from sooner.missions.flight_plans import flights
    from tests.georeferenced import greedily

    read = read_mission(mission(folder, POLYGON, 'start = "launch"\nend = "launch"\nspeed_mps = 10'))
    (plan,) = flights(greedily(read)).plans
    area = polygon_of(AREA)
    line = shapely.LineString([(each.lon, each.lat) for each in plan.waypoints])
    assert area.buffer(1e-9).covers(line)


def test_starts_are_read_by_title_place_and_cell(folder):
    lon, lat = place(60, 60)
    texts = ['start = "launch"', f"start = {{ lat = {lat}, lon = {lon} }}", "start = [19, 2]"]
    starts = [read_mission(mission(folder, POLYGON, text)).problem.searchers[0].start for text in texts]
    assert max(abs(row - 19) + abs(col - 2) for row, col in starts) <= 2


def test_several_files_and_titles_make_one_area(folder):
    drawn(folder / "two.geojson", ("West", box(-500, 0, 0, 500)), ("East", box(5000, 0, 6000, 500)))
    text = 'polygon = ["area.geojson", { file = "two.geojson", title = "West" }]\ncell_m = 50'
    found = layers(mission(folder, text))
    assert found.area.polygon.area == pytest.approx(1e6 - 6e4 + 2.5e5, rel=0.01)


def test_a_projection_of_the_user_s_own_is_the_frame(folder):
    found = layers(mission(folder, POLYGON + '\nframe = "EPSG:32632"'))
    assert found.first.crs == found.area.ground.crs == "EPSG:32632"


# ---------------------------------------------------------------- where the person may be


def test_a_map_of_another_projection_keeps_its_probability(folder):
    values = np.random.default_rng(3).random((24, 24))
    raster(folder / "poc.tif", values)
    found = layers(mission(folder, POLYGON + '\npoc = "poc.tif"\noutside = 0.1'))
    lon, lat = np.meshgrid(np.arange(24) + 0.5, np.arange(24) + 0.5)
    east, north = -100 + 50 * lon, 1100 - 50 * lat
    inside = (east > 0) & (east < 1000) & (north > 0) & (north < 1000)
    inside &= ~((east > 300) & (east < 500) & (north > 300) & (north < 600))
    kept = values[inside].sum() / values.sum()
    assert found.outside == pytest.approx(1 - 0.9 * kept, abs=1e-3)
    assert any("lies beyond the search area" in note for note in found.notes)
    read = read_mission(mission(folder, POLYGON + '\npoc = "poc.tif"\noutside = 0.1'))
    assert read.belief.outside == pytest.approx(found.outside)
    assert read.belief.poc.sum() == pytest.approx(0.9 * kept, abs=1e-3)


@pytest.mark.parametrize("scale", [1.0, 100.0])
def test_segments_hold_their_own_probability(folder, scale):
    west, east = box(0, 0, 400, 800), box(400, 0, 1000, 800)
    drawn(folder / "s.geojson", ("A", west, {"POC": 0.3 * scale}), ("B", east, {"POC": 0.5 * scale}))
    found = layers(mission(folder, 'segments = "s.geojson"\ncell_m = 50'))
    assert found.weights.sum() == pytest.approx(0.8, abs=1e-9)
    assert found.outside == pytest.approx(0.2, abs=1e-9)
    edge = found.area.frame.metres([place(400, 400)[::-1]])[0][0]
    cols = np.arange(found.shape[1]) * 50.0
    assert found.weights[:, cols < edge - 40].sum() == pytest.approx(0.3, abs=0.05)


def test_what_segments_have_beyond_the_polygon_is_outside(folder):
    drawn(folder / "s.geojson", ("A", box(-1000, 0, 1000, 250)))
    text = POLYGON + '\n[area.segments]\nfile = "s.geojson"\npoc = { A = 60 }'
    found = layers(mission(folder, text))
    assert found.weights.sum() == pytest.approx(0.3, rel=1e-3)
    assert found.outside == pytest.approx(0.7, rel=1e-3)
    assert any("30.0% of the probability lies beyond" in note for note in found.notes)


RINGS = "rings_m = [150, 400, 900]\nquantiles = [0.25, 0.5, 0.95]"


def test_rings_around_the_last_known_place_make_area_and_map(folder):
    text = 'points = "area.geojson"\ncell_m = 25\n[area.last_known]\nplace = "launch"\n' + RINGS
    found = layers(mission(folder, text))
    assert found.outside == pytest.approx(0.05, abs=1e-3)
    assert found.area.polygon.area == pytest.approx(np.pi * 900**2, rel=1e-3)
    middle = found.area.points["launch"]
    away = np.hypot(
        *np.meshgrid(
            np.arange(found.shape[1]) * 25 - middle[0],
            (found.shape[0] - 1 - np.arange(found.shape[0])) * 25 - middle[1],
        )
    )
    assert found.weights[away < 150].sum() == pytest.approx(0.25, abs=0.03)


def test_rings_that_reach_beyond_the_polygon_are_outside(folder):
    lon, lat = place(0, 500)
    text = POLYGON + f"\n[area.last_known]\nplace = {{ lat = {lat}, lon = {lon} }}\n" + RINGS
    assert layers(mission(folder, text)).outside == pytest.approx(1 - 0.95 / 2, abs=0.15)


def test_evidence_is_brought_to_the_grid(folder):
    raster(folder / "theta.tif", np.full((24, 24), 0.4))
    found = layers(mission(folder, POLYGON + '\nevidence = "theta.tif"'))
    assert np.abs(found.theta - 0.4).max() < 1e-12


# ---------------------------------------------------------------- what looks see, what stands there


def test_rasters_of_any_projection_lie_over_the_area(folder):
    cols = np.indices((24, 24))[1]
    raster(folder / "difficulty.tif", np.where(cols < 12, 0.0, 3.0))
    raster(folder / "dem.tif", 800.0 + 2.0 * (cols + 0.5))
    stones = np.zeros((24, 24))
    stones[3, 3] = 1
    raster(folder / "rocks.tif", stones)
    text = POLYGON + '\nelevation = "dem.tif"\nobstacles = "rocks.tif"'
    found = layers(mission(folder, text, sensor='difficulty = "difficulty.tif"'))
    assert set(np.unique(found.glimpse.round(9))) >= {0.25, 1.0}
    slope = np.diff(found.area.elevation, axis=1) / 50.0
    assert slope == pytest.approx(np.full(slope.shape, 0.04), rel=0.01)
    (row, col), (east, north) = (3, 3), (-100 + 3.5 * 50, 1100 - 3.5 * 50)
    x, y = found.area.frame.metres([place(east, north)[::-1]])[0]
    assert found.obstacles[found.shape[0] - 1 - round(y / 50), round(x / 50)]
    assert (row, col) == (3, 3)


def test_classes_of_ground_say_what_a_look_detects(folder):
    classes = np.where(np.indices((24, 24))[1] < 12, 10, 20).astype(np.uint8)
    raster(folder / "cover.tif", classes)
    drawn(folder / "cover.geojson", ("", box(-200, -200, 500, 1200), {"class": "forest"}))
    for text, sensor in (
        ('land_cover = "cover.tif"', "land_cover = { 10 = 0.2, 20 = 0.9 }"),
        ('land_cover = "cover.geojson"', "land_cover = { forest = 0.2, else = 0.9 }"),
    ):
        found = layers(mission(folder, POLYGON + "\n" + text, sensor=sensor))
        assert found.glimpse[:, 2] == pytest.approx(np.full(found.shape[0], 0.2))
        assert found.glimpse[:, -3] == pytest.approx(np.full(found.shape[0], 0.9))


def test_buildings_of_an_extract_are_not_flown_over(folder):
    pytest.importorskip("osmium")
    nodes = [place(*corner) for corner in ((600, 600), (700, 600), (700, 700), (600, 700))]
    said = "".join(f'<node id="{i + 1}" lat="{lat}" lon="{lon}"/>' for i, (lon, lat) in enumerate(nodes))
    refs = "".join(f'<nd ref="{i}"/>' for i in (1, 2, 3, 4, 1))
    (folder / "town.osm").write_text(
        f'<osm version="0.6">{said}<way id="1">{refs}<tag k="building" v="yes"/></way></osm>'
    )
    found = layers(mission(folder, POLYGON + '\nobstacles = "town.osm"'))
    assert found.area.no_fly.area == pytest.approx(1e4, rel=0.01)


def test_drawings_lie_beside_a_raster_that_is_the_grid_itself(folder):
    from sooner.io.georeference import Georeference
    from sooner.io.geotiff import geotiff

    frame = LocalFrame.around(polygon_of(AREA), 50.0, crs="EPSG:32632")
    ground = Georeference("EPSG:32632", frame.ground.corner, 50.0, 50.0)
    (folder / "poc.tif").write_bytes(geotiff(np.ones(frame.shape), ground))
    drawn(folder / "zone.geojson", ("Zone", box(600, 600, 800, 800)), ("home", point(50, 50)))
    plain = layers(mission(folder, 'poc = "poc.tif"'))
    found = layers(mission(folder, 'poc = "poc.tif"\nno_fly = "zone.geojson"'))
    assert plain.area is None
    assert plain.obstacles is None
    assert (found.weights == plain.weights).all()
    assert 4 <= found.obstacles.sum() - 0 <= 36
    assert found.area.no_fly.area == pytest.approx(4e4, rel=0.01)
    assert "home" in found.area.points


def test_ground_that_is_alike_but_for_rounding_is_cut_into_regions(folder):
    raster(folder / "even.tif", np.ones((24, 24)))
    searcher = 'start = "launch"\nmoves = "regions"\nspeed_mps = 5\naccel_mps2 = 2'
    sensor = 'glimpse = "even.tif"\nradius_m = 60'
    read = read_mission(mission(folder, POLYGON, searcher, sensor, "seconds = 300"))
    assert read.problem.searchers


def test_a_map_in_degrees_is_laid_on_a_grid_of_metres(folder):
    raster(folder / "poc.tif", np.random.default_rng(3).random((24, 24)))
    found = layers(mission(folder, 'poc = "poc.tif"'))
    assert found.cell_m == pytest.approx(50.0, rel=0.01)
    assert found.outside < 1e-9
    assert "tmerc" in found.first.crs


# ---------------------------------------------------------------- what is refused

BOW = {"type": "Polygon", "coordinates": [[place(0, 0), place(900, 900), place(900, 0), place(0, 900), place(0, 0)]]}
WIDE = {"type": "Polygon", "coordinates": [[[10, 46], [12, 46], [12, 46.1], [10, 46]]]}


def with_files(folder):
    drawn(folder / "bow.geojson", ("Bow", BOW))
    drawn(folder / "wide.geojson", ("Wide", WIDE))
    drawn(folder / "tiny.geojson", ("Tiny", box(0, 0, 20, 20)))
    drawn(folder / "zone.geojson", ("Zone", box(0, 0, 200, 200)))
    drawn(folder / "all.geojson", ("All", box(-100, -100, 1200, 1200)))
    drawn(folder / "line.geojson", ("Line", {"type": "LineString", "coordinates": [place(0, 0), place(900, 900)]}))
    drawn(folder / "twins.geojson", ("x", point(100, 100)), ("x", point(700, 700)))
    drawn(folder / "far.geojson", ("far", point(3000, 100)))
    drawn(folder / "much.geojson", ("A", box(0, 0, 500, 500), {"poc": 80}), ("B", box(500, 0, 900, 500), {"poc": 40}))
    drawn(folder / "none.geojson", ("A", box(0, 0, 500, 500)))
    raster(folder / "poc.tif", np.ones((24, 24)))
    raster(folder / "elsewhere.tif", np.ones((4, 4)), west=50_000.0)
    raster(folder / "part.tif", np.ones((4, 4)))
    raster(folder / "two.tif", np.full((24, 24), 2.0))
    raster(folder / "naked.tif", np.ones((24, 24)), crs=None)
    (folder / "poc.csv").write_text("1,2\n3,4\n")


START = 'start = "launch"'
BAD = {
    "self-crossing": (
        'polygon = "bow.geojson"',
        START,
        "",
        "area.polygon",
        ("Bow", "crosses itself at longitude 11.2"),
    ),
    "no polygon": ('polygon = "line.geojson"', START, "", "area.polygon", ("no polygon",)),
    "no file": ('polygon = "gone.kml"', START, "", "area.polygon", ("no such file",)),
    "a number": ("polygon = 3", START, "", "area.polygon", ("3 came",)),
    "unknown key": ('polygon = { fil = "a" }', START, "", "area.polygon", ("fil",)),
    "unknown title": (
        'polygon = { file = "area.geojson", title = "X" }',
        START,
        "",
        "area.polygon",
        ("'X' came", "'Area'"),
    ),
    "too wide": ('polygon = "wide.geojson"', START, "", "area.polygon", ("100 km",)),
    "smaller than a footprint": (
        'polygon = "tiny.geojson"\ncell_m = 5',
        'start = [2, 2]\nmoves = "regions"\nspeed_mps = 5\naccel_mps2 = 2',
        "radius_m = 40\n",
        "area.polygon",
        ("one look covers 5027 m2",),
    ),
    "smaller than a cell": ('polygon = "tiny.geojson"\ncell_m = 50', START, "", "area.cell_m", ("smaller cells",)),
    "launch in a zone": (POLYGON + '\nno_fly = "zone.geojson"', START, "", "searcher[0].start", ("no-fly zone",)),
    "launch beyond": (
        POLYGON + '\npoints = "far.geojson"',
        'start = "far"',
        "",
        "searcher[0].start",
        ("m out of the search area",),
    ),
    "a title of two": (
        POLYGON + '\npoints = "twins.geojson"',
        'start = "x"',
        "",
        "searcher[0].start",
        ("several points",),
    ),
    "a title of none": (POLYGON, 'start = "y"', "", "searcher[0].start", ("'y' came", "'launch'")),
    "a zone over all": (POLYGON + '\nno_fly = "all.geojson"', START, "", "area.margin_m", ("nothing of the area",)),
    "a line without a radius": (POLYGON + '\nno_fly = "line.geojson"', START, "", "area.no_fly", ("radius_m",)),
    "segments past one": ('segments = "much.geojson"', START, "", "area.segments", ("total 120",)),
    "segments without POC": ('segments = "none.geojson"', START, "", "area.segments", ("poc = None",)),
    "segments and a map": (
        'segments = "much.geojson"\npoc = "poc.tif"',
        START,
        "",
        "area",
        ("poc and segments came",),
    ),
    "rings that shrink": (
        POLYGON + '\n[area.last_known]\nplace = "launch"\nrings_m = [300, 200]\nquantiles = [0.5, 0.9]',
        START,
        "",
        "area.last_known",
        ("that grow",),
    ),
    "no place": (
        POLYGON + "\n[area.last_known]\nrings_m = [300]\nquantiles = [0.5]",
        START,
        "",
        "area.last_known.place",
        ("nothing came",),
    ),
    "a map elsewhere": (POLYGON + '\npoc = "elsewhere.tif"', START, "", "area.poc", ("elsewhere",)),
    "a map without a projection": (
        POLYGON + '\npoc = "naked.tif"',
        START,
        "",
        "area.poc",
        ("without a coordinate reference system",),
    ),
    "a map of numbers alone": (POLYGON + '\npoc = "poc.csv"', START, "", "area.poc", ("place on the globe",)),
    "elevation of a part": (POLYGON + '\nelevation = "part.tif"', START, "", "area.elevation", ("says nothing of",)),
    "glimpse of two": (POLYGON, START, 'glimpse = "two.tif"', "sensor.glimpse", ("2 came in two.tif",)),
    "a class without a number": (
        POLYGON + '\nland_cover = "poc.tif"',
        START,
        "land_cover = { 7 = 0.5 }",
        "sensor.land_cover",
        ("class 1",),
    ),
    "classes without a map": (POLYGON, START, "land_cover = { 7 = 0.5 }", "area.land_cover", ("nothing came",)),
    "land cover without a table": (
        POLYGON + '\nland_cover = "poc.tif"',
        START,
        "",
        "sensor.land_cover",
        ("nothing came",),
    ),
    "no rings": (
        'points = "area.geojson"\n[area.last_known]\nplace = "launch"\nrings_m = []\nquantiles = [0.5]',
        START,
        "",
        "area.last_known.rings_m",
        ("nothing came",),
    ),
    "rings of a thousand kilometres": (
        'points = "area.geojson"\n[area.last_known]\nplace = "launch"\nrings_m = [1e6]\nquantiles = [0.5]',
        START,
        "",
        "area.last_known",
        ("100 km",),
    ),
    "hexagons": (POLYGON + '\ngrid = "hex"', START, "", "area.grid", ("square cells",)),
    "too many cells": ('polygon = "area.geojson"\ncell_m = 0.1', START, "", "area.polygon", ("at most 20,000,000",)),
    "an unknown frame": (POLYGON + '\nframe = "EPSG:1"', START, "", "area.frame", ("EPSG:32632",)),
    "a frame in degrees": (POLYGON + '\nframe = "EPSG:4326"', START, "", "area.frame", ("degrees",)),
    "zones on a map without a place": (
        'poc = "poc.csv"\nno_fly = "zone.geojson"',
        "start = [0, 0]",
        "",
        "area.no_fly",
        ("without a georeference",),
    ),
}


@pytest.mark.parametrize("name", BAD)
@pytest.mark.filterwarnings("ignore::rasterio.errors.NotGeoreferencedWarning")
def test_what_cannot_be_is_refused_by_file_and_key(folder, name):
    area, searcher, sensor, key, words = BAD[name]
    with_files(folder)
    budget = "seconds = 300" if "regions" in searcher else "steps = 40"
    refused(mission(folder, area, searcher, sensor, budget), key, *words)


def test_nothing_is_written_where_a_mission_is_refused(folder):
    before = {each.name: each.read_bytes() for each in folder.iterdir()}
    path = mission(folder, 'polygon = "bow.geojson"')
    with pytest.raises(DataFormatError):
        read_mission(path)
    assert {each.name for each in folder.iterdir()} == {*before, "mission.toml"}


def test_the_corner_is_where_tests_think_it_is():
    assert LocalFrame.around(polygon_of(AREA), 50.0).metres([[LAT, LON]])[0].max() < 100.0


# ---------------------------------------------------------------- where drones may be beyond the search area

CAR_PARK = ("car park", point(-250, 500))
FLIGHT = 'flight_area = { file = "flight.geojson", title = "flight" }'
LEGS = 'start = "car park"\nend = "car park"\nmoves = "legs"\nspeed_mps = 12\naccel_mps2 = 2'
REGIONS = LEGS.replace("legs", "regions")


@pytest.fixture
def beyond(folder):
    drawn(folder / "flight.geojson", ("flight", box(-350, -100, 1100, 1100)), CAR_PARK)
    drawn(folder / "beside.geojson", ("flight", box(1500, 0, 2000, 500)), ("car park", point(1600, 100)))
    drawn(folder / "west.geojson", ("flight", box(-350, -100, 500, 1100)), CAR_PARK)
    return folder


@pytest.mark.parametrize(
    ("searcher", "sensor", "budget"),
    [
        ('start = "car park"\nend = "car park"', "glimpse = 0.7", "steps = 60"),
        (REGIONS, "radius_m = 60", "seconds = 400"),
        (LEGS, "radius_m = 60", "seconds = 400"),
    ],
    ids=["cells", "regions", "legs"],
)
def test_drones_start_beside_the_search_area_and_look_for_nobody_there(beyond, searcher, sensor, budget):
    found = read_mission(mission(beyond, f"{POLYGON}\n{FLIGHT}\nmargin_m = 10", searcher, sensor, budget))
    assert found.belief is not None
    whole, corner = found.area.polygon, found.area.frame.metres([[LAT, LON]])[0]
    assert found.area.flyable(10.0).area == pytest.approx(1430 * 1180, rel=0.01)
    grid = found.problem.grid
    away = np.array([whole.distance(shapely.Point(each)) for each in grid.centres_m])
    poc = found.belief.poc.ravel()
    assert not poc[away > 75.0].any()
    assert poc.sum() == pytest.approx(1.0)
    assert corner[0] > 300  # the grid holds the car park too
    best = solve(found.problem, make_planner("parallel-track" if found.over_legs else "greedy"), seed=1).best
    assert best.value > 0.02


def test_evidence_beyond_the_search_area_is_of_nobody_where_drones_may_be_there(beyond):
    raster(beyond / "theta.tif", np.full((40, 60), 0.4), west=-800.0, north=1500.0)
    found = layers(mission(beyond, f'{POLYGON}\n{FLIGHT}\nevidence = "theta.tif"', 'start = "car park"'))
    assert set(np.unique(found.theta.round(9))) == {0.0, 0.4}
    assert (found.theta > 0).sum() * 2500.0 == pytest.approx(found.area.polygon.area, rel=0.2)


def test_cells_out_of_the_flight_area_are_shut(beyond):
    told = f'{POLYGON}\nflight_area = {{ file = "west.geojson", title = "flight" }}'
    found = layers(mission(beyond, told, 'start = "car park"'))
    free = ~found.obstacles
    east = np.indices(found.shape)[1] * 50.0
    edge = found.area.frame.metres([list(reversed(place(500, 0)))])[0][0]
    assert free.any()
    assert east[free].max() + 25.0 <= edge + 1e-6
    assert any("of the search area lies beyond the flight area" in note for note in found.notes)


def test_a_place_beyond_the_flight_area_is_refused_with_its_distance(beyond):
    told = f'{POLYGON}\n{FLIGHT}\npoints = "far.geojson"'
    with_files(beyond)
    refused(mission(beyond, told, 'start = "far"'), "searcher[0].start", "m out of the flight area")


def test_a_flight_area_elsewhere_is_refused_with_its_distance(beyond):
    told = f'{POLYGON}\nflight_area = {{ file = "beside.geojson", title = "flight" }}'
    refused(mission(beyond, told, 'start = "car park"'), "area.flight_area", "500 m from the search area")


def test_circles_that_the_mission_tells_are_not_flown_over(folder):
    lon, lat = place(700, 500)
    told = f"{POLYGON}\nno_fly = [{{ lat = {lat}, lon = {lon}, radius_m = 120 }}]"
    zone = layers(mission(folder, told)).area.no_fly
    assert zone.area == pytest.approx(np.pi * 120**2, rel=0.01)
    assert zone.centroid.distance(zone.exterior) >= 120 - 1e-6  # nothing of the circle is left out
    refused(mission(folder, f"{POLYGON}\nno_fly = {{ lat = 46.1, radius_m = 120 }}"), "area.no_fly", "lon")


@pytest.mark.parametrize(
    "sensor",
    ["sweep_width_m = 80", "[sensor.camera]\nfov_deg = 90\naltitude_m = 40\npixels = 2000\nexposure_s = 0.0005"],
    ids=["sweep width", "camera"],
)
def test_an_area_that_one_look_covers_is_refused_along_legs(folder, sensor):
    drawn(folder / "tiny.geojson", ("Tiny", box(0, 0, 20, 20)), ("car park", point(10, 10)))
    told = 'polygon = { file = "tiny.geojson", title = "Tiny" }\ncell_m = 5'
    refused(mission(folder, told, LEGS, sensor, "seconds = 300"), "area.polygon", "one look covers 5027 m2")


COPTER = """speed_mps = 12.0
accel_mps2 = 2.0
airspeed_mps = 17.0
climb_mps = 4.0
descent_mps = 3.0
endurance_s = 40
reserve = 0.0
"""
VEHICLE = 'start = "car park"\nend = "car park"\nmoves = "legs"\nvehicle = "copter.toml"\naltitude_m = 30'
BAD_LEGS = {
    "no time to get there": (FLIGHT, VEHICLE, "radius_m = 60", "searcher[0].start", ("m to the search area and back",)),
    "too near to the border": (
        FLIGHT + "\nmargin_m = 120",
        LEGS,
        "radius_m = 60",
        "searcher[0].start",
        ("100.0 m from the border", "margin_m = 120"),
    ),
    "no width": (FLIGHT, LEGS, "sweep_width_m = 0", "sensor.sweep_width_m", ("0 came",)),
    "a width of no number": (FLIGHT, LEGS, "sweep_width_m = nan", "sensor.sweep_width_m", ("nan came",)),
    "a width and a glimpse": (FLIGHT, LEGS, "sweep_width_m = 60\nglimpse = 0.5", "sensor.glimpse", ("sweep_width_m",)),
    "heights beyond the sky": (
        FLIGHT + '\nelevation = "sky.tif"',
        LEGS,
        "radius_m = 60",
        "area.elevation",
        ("heights from 0 to",),
    ),
    "a frame of far away": (
        FLIGHT + '\nframe = "EPSG:3857"',
        LEGS,
        "radius_m = 60",
        "area.frame",
        ("EPSG:3857", "off here"),
    ),
    "a start on an island": (
        'flight_area = "island.geojson"\nmargin_m = 10\npoints = "flight.geojson"',
        LEGS,
        "radius_m = 60",
        "searcher[0].start",
        ("no way leads",),
    ),
    "no batteries": (FLIGHT, VEHICLE + "\nbatteries = 0", "radius_m = 60", "searcher[0].batteries", ("at least 1",)),
}


@pytest.mark.parametrize("name", BAD_LEGS)
def test_what_cannot_be_flown_along_legs_is_refused_and_nothing_written(beyond, name):
    area, searcher, sensor, key, words = BAD_LEGS[name]
    (beyond / "copter.toml").write_text(COPTER)
    drawn(beyond / "island.geojson", ("island", box(-300, 400, -200, 600)), ("flight", box(-50, 0, 1000, 1000)))
    raster(beyond / "sky.tif", np.where(np.indices((40, 60))[0] == 20, 1e9, 0.0), west=-800.0, north=1500.0)
    path = mission(beyond, f"{POLYGON}\n{area}", searcher, sensor, "seconds = 300")
    before = sorted(beyond.iterdir())
    refused(path, key, *words)
    assert sorted(beyond.iterdir()) == before
