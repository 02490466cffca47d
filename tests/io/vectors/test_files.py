import json
import random
import sqlite3
import tracemalloc
import zipfile

import numpy as np
import pyogrio
import pyogrio.raw
import pytest
import shapely

from sooner.errors import DataFormatError
from sooner.io.vectors import read_features
from sooner.io.vectors.wkb import wkb
from tests.io.vectors.drawn import LAT, LON, square, write

HOLED = square(holes=[square(LAT + 0.004, LON + 0.004, 0.002)])


def refused(path, *words, layer=None):
    with pytest.raises(DataFormatError) as caught:
        read_features(path, layer)
    assert path.name in str(caught.value)
    for word in words:
        assert word in str(caught.value)


def collection(*geometries, **members):
    features = [{"type": "Feature", "properties": {}, "geometry": each} for each in geometries]
    return json.dumps({"type": "FeatureCollection", "features": features} | members)


def written(tmp_path, text, name="drawn.geojson"):
    path = tmp_path / name
    path.write_bytes(text if isinstance(text, bytes) else text.encode())
    return path


# ---------------------------------------------------------------- what GDAL writes


@pytest.mark.parametrize("suffix", ["geojson", "gpkg", "kml", "kmz"])
def test_polygons_with_holes_come_as_gdal_wrote_them(tmp_path, suffix):
    shapes = [HOLED, shapely.MultiPolygon([square(LAT, LON + 1), square(LAT + 1, LON)])]
    path = write(tmp_path / f"area.{suffix}", shapes, Name=["North", "Two parts"])
    found = read_features(path)
    assert [each.name for each in found] == ["North", "Two parts"]
    for feature, shape in zip(found, shapes, strict=True):
        assert shapely.equals_exact(shapely.normalize(feature.geometry), shapely.normalize(shape), 1e-9)


@pytest.mark.parametrize("suffix", ["geojson", "gpkg", "kml", "kmz", "gpx"])
def test_points_and_lines_are_read_as_gdal_reads_them(tmp_path, suffix):
    for number, shape in enumerate([shapely.Point(LON, LAT), shapely.LineString([(LON, LAT), (LON + 1, LAT + 1)])]):
        layer = ("waypoints", "routes")[number] if suffix == "gpx" else None
        path = write(tmp_path / f"{number}.{suffix}", [shape], layer=layer, name=["launch"])
        (found,) = read_features(path)
        _, _, theirs, _ = pyogrio.raw.read(path, layer=layer)
        assert found.name == "launch"
        assert shapely.equals_exact(found.geometry, shapely.from_wkb(theirs[0]), 1e-9)


@pytest.mark.parametrize("crs", ["EPSG:32632", "EPSG:3035", "EPSG:3857", "EPSG:4258"])
def test_a_geopackage_of_another_projection_comes_in_degrees(tmp_path, crs):
    from rasterio.warp import transform

    away = shapely.transform(HOLED, lambda xy: np.column_stack(transform("EPSG:4326", crs, *xy.T)))
    (found,) = read_features(write(tmp_path / "area.gpkg", [away], crs=crs))
    assert shapely.hausdorff_distance(found.geometry, HOLED) < 2e-6
    assert found.geometry.area == pytest.approx(HOLED.area, rel=1e-4)


def test_a_geopackage_of_a_projection_without_a_number_is_read(tmp_path):
    crs = f"+proj=tmerc +lat_0={LAT} +lon_0={LON} +k=1 +datum=WGS84 +units=m"
    (found,) = read_features(write(tmp_path / "area.gpkg", [shapely.box(0, 0, 1000, 1000)], crs=crs))
    assert found.geometry.bounds[:2] == pytest.approx((LON, LAT), abs=1e-5)


def test_the_layer_of_a_geopackage_is_chosen_by_name(tmp_path):
    path = write(tmp_path / "area.gpkg", [square()], layer="segments", POC=[30.0])
    write(path, [shapely.Point(LON, LAT)], layer="launch", append=True)
    assert read_features(path, "launch")[0].geometry.geom_type == "Point"
    assert read_features(path, "segments")[0].properties["POC"] == 30.0
    refused(path, "2 layers came (segments, launch)", "layer = its name")
    refused(path, "'roads' was asked for", "segments, launch", layer="roads")


def test_tracks_of_gpx_are_lines_in_their_segments(tmp_path):
    text = """<?xml version="1.0"?><gpx version="1.1" xmlns="http://www.topografix.com/GPX/1/1">
    <wpt lat="46" lon="11"><name>launch</name><sym>Flag</sym></wpt><trk><name>border</name>
    <trkseg><trkpt lat="46" lon="11"/><trkpt lat="46.1" lon="11"/></trkseg>
    <trkseg><trkpt lat="46" lon="12"/></trkseg></trk></gpx>"""
    point, track = read_features(written(tmp_path, text, "flown.gpx"))
    assert (point.kind, point.name, point.properties["sym"]) == ("waypoint", "launch", "Flag")
    assert (track.kind, track.geometry.wkt) == ("track", "LINESTRING (11 46, 11 46.1)")


def test_caltopo_shapes_markers_and_assignments_keep_title_and_class(tmp_path):
    ring = [[11, 46], [11.1, 46], [11.1, 46.1], [11, 46]]

    def feature(kind, geometry, **properties):
        return {"type": "Feature", "geometry": geometry, "properties": {"class": kind} | properties}

    said = [
        feature("Folder", None, title="Search"),
        feature("Shape", {"type": "Polygon", "coordinates": [ring]}, title="Area"),
        feature("Marker", {"type": "Point", "coordinates": [11, 46, 0, 0]}, title="LKP"),
        feature("Assignment", {"type": "Polygon", "coordinates": [ring]}, title="", letter="AA", number="101"),
    ]
    text = json.dumps({"type": "FeatureCollection", "features": said})
    found = read_features(written(tmp_path, text, "export.json"))
    assert [(each.kind, each.name) for each in found] == [
        ("Shape", "Area"),
        ("Marker", "LKP"),
        ("Assignment", "AA 101"),
    ]


@pytest.mark.parametrize("encoding", ["utf-8", "utf-16", "latin-1"])
def test_xml_of_any_encoding_is_read_and_its_document_type_refused(tmp_path, encoding):
    head = f'<?xml version="1.0" encoding="{encoding}"?>'
    mark = (
        '<kml xmlns="http://www.opengis.net/kml/2.2"><Placemark><name>Rüti</name>'
        "<Point><coordinates>11,46,0</coordinates></Point></Placemark></kml>"
    )
    path = written(tmp_path, (head + mark).encode(encoding), "a.kml")
    assert read_features(path)[0].name == "Rüti"
    entities = '<!DOCTYPE kml [<!ENTITY a "aaaaaaaaaa"><!ENTITY b "&a;&a;&a;&a;">]>'
    path = written(tmp_path, (head + entities + mark.replace("Rüti", "&b;")).encode(encoding), "b.kml")
    refused(path, "DOCTYPE")


def test_kml_reads_tracks_data_and_several_geometries_of_a_placemark(tmp_path):
    text = """<kml xmlns="http://www.opengis.net/kml/2.2" xmlns:gx="http://www.google.com/kml/ext/2.2"><Document>
    <NetworkLink><Link><href>http://127.0.0.1:1/x.kml</href></Link></NetworkLink>
    <Placemark><name>S1</name><ExtendedData><Data name="poc"><value>30</value></Data></ExtendedData>
    <MultiGeometry><Point><coordinates>0,0</coordinates></Point><Polygon><outerBoundaryIs><LinearRing><coordinates>
    11,46 12,46 12,47</coordinates></LinearRing></outerBoundaryIs></Polygon></MultiGeometry></Placemark>
    <Folder><Placemark><gx:Track><gx:coord>11 46 0</gx:coord><gx:coord>12 46 0</gx:coord></gx:Track></Placemark>
    </Folder></Document></kml>"""
    first, second = read_features(written(tmp_path, text, "a.kml"))
    assert (first.name, first.properties["poc"], first.geometry.geom_type) == ("S1", "30", "Polygon")
    assert second.geometry.wkt == "LINESTRING (11 46, 12 46)"


# ---------------------------------------------------------------- what is refused


def point(lon, lat):
    return collection({"type": "Point", "coordinates": [lon, lat]})


BAD_GEOJSON = {
    "nothing": ("", "not JSON"),
    "a list": ("[]", "a list or a bare value"),
    "no features": (collection(), "without any shape or point"),
    "folders only": (collection(None), "without any shape or point"),
    "deep": ("[" * 100_000, "not JSON"),
    "many brackets": ("[]," * 1_000_001 * 2, "brackets"),
    "NaN": ('{"type":"Point","coordinates":[NaN,46]}', "NaN"),
    "infinity by a large exponent": ('{"type":"Point","coordinates":[1e999,46]}', "not a finite number"),
    "words": ('{"type":"Point","coordinates":["a","b"]}', "not pairs of numbers"),
    "one number": ('{"type":"Point","coordinates":[1]}', "not pairs of numbers"),
    "unknown geometry": ('{"type":"Circle","coordinates":[1,2]}', "type Circle"),
    "no coordinates": ('{"type":"Polygon"}', "without coordinates"),
    "collections within one another": (
        '{"type":"GeometryCollection","geometries":[{"type":"GeometryCollection","geometries":[]}]}',
        "type GeometryCollection",
    ),
    "a border of two places": ('{"type":"Polygon","coordinates":[[[1,2],[3,4],[1,2]]]}', "three apart"),
    "a pole": (point(11, 89.95), "89.9"),
    "latitude first": (point(46, 111.2), "longitude from -180"),
    "beyond the date line": (point(181.0, 46), "longitude from -180"),
    "across the date line": (
        collection({"type": "LineString", "coordinates": [[179.9, 1], [-179.9, 1]]}),
        "date line",
    ),
    "a projection by a link": (
        collection({"type": "Point", "coordinates": [1, 2]}, crs={"type": "link", "properties": {"href": "http://x"}}),
        "EPSG's",
    ),
    "a projection by an address": (
        collection({"type": "Point", "coordinates": [1, 2]}, crs={"properties": {"name": "http://127.0.0.1/crs"}}),
        "EPSG's",
    ),
    "a projection that is none": (
        collection({"type": "Point", "coordinates": [1, 2]}, crs={"properties": {"name": "EPSG:999999"}}),
        "projection",
    ),
    "metres said to be degrees": (point(650_000, 5_100_000), "longitude from -180"),
}


@pytest.mark.parametrize("name", BAD_GEOJSON)
def test_bad_geojson_is_refused(tmp_path, name):
    text, words = BAD_GEOJSON[name]
    refused(written(tmp_path, text), words)


def test_older_geojson_with_a_projection_comes_in_degrees(tmp_path):
    text = collection(
        {"type": "Point", "coordinates": [500_000, 5_100_000]}, crs={"properties": {"name": "EPSG:32632"}}
    )
    assert read_features(written(tmp_path, text))[0].geometry.x == pytest.approx(9.0, abs=1e-9)


BAD_XML = {
    "no XML": ("a.kml", b"hello", "not XML"),
    "cut short": ("a.kml", b"<kml><Placemark>", "not XML"),
    "other XML": ("a.kml", b"<gpx/>", "a root <gpx> came"),
    "deep": ("a.kml", b"<kml>" + b"<a>" * 1000 + b"</a>" * 1000 + b"</kml>", "in one another"),
    "unknown encoding": ("a.kml", b'<?xml version="1.0" encoding="none"?><kml/>', "not XML"),
    "external entity": ("a.gpx", b'<!DOCTYPE gpx SYSTEM "http://127.0.0.1:1/x.dtd"><gpx/>', "DOCTYPE"),
    "NaN": ("a.gpx", b'<gpx><wpt lat="nan" lon="11"/></gpx>', "not a finite number"),
    "no latitude": ("a.gpx", b'<gpx><wpt lon="11"/></gpx>', "without lat and lon"),
    "words": ("a.kml", b"<kml><Placemark><Point><coordinates>a,b</coordinates></Point></Placemark></kml>", "'a,b'"),
    "nothing drawn": ("a.gpx", b"<gpx/>", "without any shape"),
}


@pytest.mark.parametrize("name", BAD_XML)
def test_bad_xml_is_refused(tmp_path, name):
    file, data, words = BAD_XML[name]
    refused(written(tmp_path, data, file), words)


def test_zip_bombs_are_refused_in_bounded_memory(tmp_path):
    bomb, many = tmp_path / "bomb.kmz", tmp_path / "many.kmz"
    with zipfile.ZipFile(bomb, "w", zipfile.ZIP_DEFLATED) as archive, archive.open("doc.kml", "w") as member:
        for _ in range(40):
            member.write(b" " * 1_000_000)
    with zipfile.ZipFile(many, "w") as archive:
        for number in range(6000):
            archive.writestr(f"file-of-a-long-name-{number}.txt", "")
    tracemalloc.start()
    refused(bomb, "unpack to more than 20 MB")
    refused(many, "more than 1000 files")
    assert tracemalloc.get_traced_memory()[1] < 100e6
    tracemalloc.stop()


@pytest.mark.parametrize("data", [b"", b"PK\x05\x06", b"PK\x05\x06" + bytes(18), b"no archive at all, but long enough"])
def test_archives_that_are_none_are_refused(tmp_path, data):
    refused(written(tmp_path, data, "a.kmz"), "a.kmz")


def test_members_outside_the_archive_are_not_read(tmp_path):
    (tmp_path / "doc.kml").write_text("<kml/>")
    path = tmp_path / "a.kmz"
    with zipfile.ZipFile(path, "w") as archive:
        archive.writestr("../doc.kml.txt", "x")
    refused(path, "without a .kml")


def test_a_geopackage_without_a_projection_is_refused(tmp_path):
    path = write(tmp_path / "area.gpkg", [square()])
    with sqlite3.connect(path) as database:
        database.execute("UPDATE gpkg_geometry_columns SET srs_id = -1")
    refused(path, "without a coordinate reference system")


def test_views_of_a_geopackage_are_not_read_and_nothing_is_written(tmp_path):
    path = write(tmp_path / "area.gpkg", [square()], layer="segments", name=["A"])
    forever = "WITH RECURSIVE n(i) AS (SELECT 1 UNION ALL SELECT i + 1 FROM n) SELECT i AS geom FROM n"
    with sqlite3.connect(path) as database:
        database.execute(f"CREATE VIEW endless AS {forever}")
        database.execute("UPDATE gpkg_geometry_columns SET table_name = 'endless'")
    before = path.read_bytes()
    refused(path, "0 layers came (none)")
    assert path.read_bytes() == before
    assert [each.name for each in tmp_path.iterdir()] == ["area.gpkg"]


def test_a_geopackage_whose_list_of_layers_is_endless_is_refused(tmp_path):
    path = write(tmp_path / "area.gpkg", [square()], layer="segments")
    forever = "WITH RECURSIVE n(i) AS (SELECT 1 UNION ALL SELECT i + 1 FROM n) SELECT i AS table_name FROM n"
    with sqlite3.connect(path) as database:
        database.execute("DROP TABLE gpkg_geometry_columns")
        database.execute(f"CREATE VIEW gpkg_geometry_columns AS {forever}")
    refused(path, "without the tables of a GeoPackage")


def test_a_geopackage_that_another_program_holds_is_refused(tmp_path):
    path = write(tmp_path / "area.gpkg", [square()])
    (tmp_path / "area.gpkg-wal").write_bytes(b"x")
    refused(path, "close it there")


@pytest.mark.parametrize("data", [b"", b"SQLite format 3\0", b"SQLite format 3\0" + bytes(4000)])
def test_databases_that_are_none_are_refused(tmp_path, data):
    refused(written(tmp_path, data, "a.gpkg"), "a.gpkg")


def test_geometry_is_read_as_its_bytes_say_or_refused():
    for geometry in (HOLED, shapely.MultiPoint([(1, 2), (3, 4)]), shapely.LineString([(1, 2, 3), (4, 5, 6)])):
        for order in (0, 1):
            for flavour in ("iso", "extended"):
                data = shapely.to_wkb(geometry, byte_order=order, flavor=flavour)
                assert wkb(data).equals(geometry)
                for cut in range(1, len(data), 7):
                    with pytest.raises(ValueError, match=r"too soon|type"):
                        wkb(data[:cut])
    nested = b"\x01\x06\x00\x00\x00\x01\x00\x00\x00" * 100_000
    with pytest.raises(ValueError, match="type 6"):
        wkb(nested)
    with pytest.raises(ValueError, match="too soon"):
        wkb(b"\x01\x02\x00\x00\x00\xff\xff\xff\xff")


@pytest.mark.parametrize("name", ["/vsicurl/http://127.0.0.1:1/a.geojson", "http://127.0.0.1:1/a.kml"])
def test_addresses_are_names_of_files_that_are_not_there(tmp_path, name):
    with pytest.raises(DataFormatError, match="no such file"):
        read_features(tmp_path / name)


def test_too_many_vertices_are_refused_and_as_many_as_may_be_are_read(tmp_path):
    turns = np.linspace(0, 2 * np.pi, 100_000)
    ring = np.column_stack([11 + 0.01 * np.cos(turns), 46 + 0.01 * np.sin(turns)])
    ring[-1] = ring[0]

    def said(places):
        return collection({"type": "Polygon", "coordinates": [places.tolist()]})

    (found,) = read_features(written(tmp_path, said(ring)))
    assert shapely.get_num_coordinates(found.geometry) == 100_000
    more = np.concatenate([ring[:-1], [[11.00999999, 45.99999]], ring[-1:]])
    refused(written(tmp_path, said(more)), "100,001 vertices", "simplify")


def test_other_suffixes_and_layers_of_no_geopackage_are_refused(tmp_path):
    refused(written(tmp_path, "x", "a.shp"), "'.shp'", ".geojson")
    refused(written(tmp_path, point(1, 2)), "only a .gpkg has layers", layer="a")
    refused(tmp_path / "none.kml", "no such file")


@pytest.mark.parametrize("suffix", ["geojson", "gpkg", "kml", "kmz", "gpx"])
def test_mutated_files_are_read_or_refused(tmp_path, suffix):
    shape = shapely.Point(LON, LAT) if suffix == "gpx" else HOLED
    layer = "waypoints" if suffix == "gpx" else None
    whole = write(tmp_path / f"whole.{suffix}", [shape], layer=layer, name=["launch"]).read_bytes()
    rng = random.Random(7)
    refusals = 0
    for _ in range(300):
        data = bytearray(whole)
        for _ in range(rng.choice([1, 2, 8])):
            at = rng.randrange(len(data))
            data[at : at + rng.choice([0, 1, 4, 100])] = rng.choice([b"", b"\xff\xff\xff\xff", b"null", b"\x00", b"<"])
        path = written(tmp_path, bytes(data), f"mutated.{suffix}")
        try:
            read_features(path)
        except DataFormatError:
            refusals += 1
    assert refusals > 50
