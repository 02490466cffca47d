"""Each format against a file as others write it, or against the library that does."""

import json
from datetime import UTC, datetime

import numpy as np
import pyogrio
import pytest
from pymavlink import DFReader, mavutil

from sooner.errors import DataFormatError, InvalidProblemError
from sooner.io.tracks import TRACKS, read_tracks
from sooner.io.tracks.read import _READERS
from tests.io.tracks.files import NOON, dataflash, gpx, straight, tlog

MIDDAY = datetime(2024, 5, 3, 12, tzinfo=UTC)


def written(tmp_path, name, content):
    path = tmp_path / name
    path.write_bytes(content if isinstance(content, bytes) else content.encode())
    return path


def test_every_suffix_that_is_told_has_a_reader():
    assert set(TRACKS) == set(_READERS)


# ---------------------------------------------------------------- GPX


def test_gpx_is_read_as_gdal_reads_it(tmp_path):
    path = written(tmp_path, "flown.gpx", gpx(straight(5), straight(4, begin=8.0)))
    [track] = read_tracks(path)
    _, _, points, fields = pyogrio.raw.read(path, layer="track_points", columns=["time", "ele"])
    assert len(points) == len(track.lat) == 9
    np.testing.assert_array_equal(track.altitude_m, fields[1 if fields[0].dtype.kind == "M" else 0])
    assert (track.name, track.started, track.above) == ("Ridge", MIDDAY, "sea")
    np.testing.assert_allclose(track.times_s, [0, 1, 2, 3, 4, 8, 9, 10, 11])
    assert track.gaps.tolist() == [4]
    assert [len(piece) for piece in track.pieces] == [5, 4]
    assert "1 gap without fixes, 4 s in all" in track.notes[0]


def test_what_a_recorder_left_blank_is_not_known(tmp_path):
    blank = gpx(straight(3)).replace("<ele>1001.0</ele>", "<ele/>").replace("<ele>1002.0</ele>", "<ele> </ele>")
    [track] = read_tracks(written(tmp_path, "a.gpx", blank.replace("<time>2024-05-03T12:00:01.000Z</time>", "<time/>")))
    np.testing.assert_array_equal(track.altitude_m, [1000.0, np.nan])
    assert track.times_s.tolist() == [0.0, 2.0]
    assert "no time" in track.notes[0]


def test_a_route_is_no_flight(tmp_path):
    path = written(tmp_path, "plan.gpx", "<gpx><rte><rtept lat='46' lon='9'/></rte></gpx>")
    with pytest.raises(DataFormatError, match=r"1 routes and no track came; expected GPX with a track.*planned"):
        read_tracks(path)


def test_tracks_of_one_file_and_flights_far_apart_in_time_stand_by_themselves(tmp_path):
    [first, second] = read_tracks(written(tmp_path, "a.gpx", gpx(straight(5), straight(4, begin=400.0))))
    assert (len(first.lat), len(second.lat)) == (5, 4)
    assert second.started == datetime(2024, 5, 3, 12, 6, 40, tzinfo=UTC)
    body = gpx(straight(3))
    two = gpx(straight(5)).replace("</gpx>", body[body.index("<trk>") :])
    assert [len(track.lat) for track in read_tracks(written(tmp_path, "b.gpx", two))] == [5, 3]


# ---------------------------------------------------------------- GeoJSON


def line(times=None, where="coordTimes", **more):
    properties = {"title": "Team 4"} | ({where: times} if times else {})
    return {
        "type": "Feature",
        "properties": properties | more,
        "geometry": {"type": "LineString", "coordinates": [[9.0, 46.0, 900], [9.0, 46.001, 910], [9.001, 46.001]]},
    }


ISO = ["2024-05-03T12:00:00Z", "2024-05-03T14:00:10.5+02:00", "2024-05-03T12:00:20"]


@pytest.mark.parametrize(
    "feature",
    [
        line(ISO),
        line(ISO, "times"),
        line([NOON, NOON + 10.5, NOON + 20], "time"),
        line(coordinateProperties={"times": [1000 * NOON, 1000 * NOON + 10_500, 1000 * NOON + 20_000]}),
    ],
    ids=["coordTimes", "times", "seconds", "milliseconds"],
)
def test_geojson_may_hold_times_beside_its_points(tmp_path, feature):
    said = {"type": "FeatureCollection", "features": [{"type": "Feature", "geometry": None}, feature]}
    [track] = read_tracks(written(tmp_path, "a.geojson", json.dumps(said)))
    assert (track.name, track.started) == ("Team 4", MIDDAY)
    np.testing.assert_allclose(track.times_s, [0.0, 10.5, 20.0])
    np.testing.assert_array_equal(track.altitude_m, [900, 910, np.nan])


def test_caltopo_records_times_behind_altitudes(tmp_path):
    points = [[9.0, 46.0 + k * 1e-4, 900, 1000 * (NOON + k)] for k in range(3)]
    [track] = read_tracks(written(tmp_path, "a.json", json.dumps({"type": "LineString", "coordinates": points})))
    assert (track.started, track.times_s.tolist()) == (MIDDAY, [0, 1, 2])


def test_a_line_without_times_has_none_or_is_told_as_flown_at_a_speed(tmp_path):
    path = written(tmp_path, "a.geojson", json.dumps(line()))
    [track] = read_tracks(path)
    assert track.times_s is None
    assert track.duration_s is None
    [flown] = read_tracks(path, speed_mps=10.0)
    assert flown.duration_s == pytest.approx(flown.length_m / 10.0)
    assert flown.started is None
    assert "as if flown at 10 m/s" in flown.notes[0]


def test_lines_of_a_multilinestring_have_gaps_between_them(tmp_path):
    parts = [[[9.0, 46.0], [9.0, 46.1]], [[9.1, 46.0], [9.1, 46.1], [9.2, 46.1]]]
    said = {"type": "MultiLineString", "coordinates": parts}
    [track] = read_tracks(written(tmp_path, "a.geojson", json.dumps(said)))
    assert [len(piece) for piece in track.pieces] == [2, 3]
    timed = {"type": "Feature", "geometry": said, "properties": {"coordTimes": [ISO[:2], ISO]}}
    timed["properties"]["coordTimes"][1] = ["2024-05-03T13:00:00Z", "2024-05-03T13:10:00Z", "2024-05-03T13:30:00Z"]
    assert len(read_tracks(written(tmp_path, "b.geojson", json.dumps(timed)))) == 4


# ---------------------------------------------------------------- KML


def test_kml_tracks_are_read_and_lines_where_there_is_none(tmp_path):
    when = "".join(f"<when>2024-05-03T12:00:0{k}Z</when>" for k in range(3))
    where = "".join(f"<gx:coord>9.0 {46 + k * 1e-4} {k}</gx:coord>" for k in range(2)) + "<gx:coord></gx:coord>"
    both = "<LineString><coordinates>9,46,0 9,46.1</coordinates></LineString>"
    kml = (
        '<kml xmlns="http://www.opengis.net/kml/2.2" xmlns:gx="http://www.google.com/kml/ext/2.2"><Placemark>'
        f"<name>One</name>{{}}{both}</Placemark></kml>"
    )
    track_ = f"<gx:Track><altitudeMode>absolute</altitudeMode>{when}{where}</gx:Track>"
    [track] = read_tracks(written(tmp_path, "a.kml", kml.format(track_)))
    assert (track.name, track.started, track.above, len(track.lat)) == ("One", MIDDAY, "sea", 2)
    [drawn] = read_tracks(written(tmp_path, "b.kml", kml.format("")))
    assert drawn.lat.tolist() == [46.0, 46.1]
    assert drawn.above == ""


# ---------------------------------------------------------------- DJI


OSD = """sep=,
 CUSTOM.date [local],CUSTOM.updateTime [local], OSD.flyTime [s],OSD.latitude,OSD.longitude,OSD.height [ft]
11/25/2025,11:59:58.50 AM,0.1,0.0,0.0,0.0
11/25/2025,11:59:59.50 AM,1.1,46.00000,9.0,100.0
11/25/2025,12:00:00.50 PM,2.1,46.00010,9.0,200.0
11/25/2025,12:00:01.50 PM,3.1,,,
"""
AIRDATA = """time(millisecond),datetime(utc),latitude,longitude,height_above_takeoff(feet),altitude_above_seaLevel(feet)
0,2024-05-03 12:00:00,46.0,9.0,0,900
100,2024-05-03 12:00:00,46.00001,9.0,10,910
200,2024-05-03 12:00:00,46.00002,9.0,20,920
"""


def test_dji_flight_records_are_read_as_tools_decode_them(tmp_path):
    [track] = read_tracks(written(tmp_path, "DJIFlightRecord.csv", OSD))
    assert track.lat.tolist() == [46.0, 46.0001]
    assert track.times_s.tolist() == [0.0, 1.0]
    assert track.started == datetime(2025, 11, 25, 11, 59, 59, 500_000)
    np.testing.assert_allclose(track.altitude_m, [30.48, 60.96])
    assert track.above == "home"
    assert any("no place" in note for note in track.notes)
    assert any("latitude 0, longitude 0" in note for note in track.notes)


def test_log_services_records_count_milliseconds(tmp_path):
    [track] = read_tracks(written(tmp_path, "airdata.csv", b"\xef\xbb\xbf" + AIRDATA.encode()))
    np.testing.assert_allclose(track.times_s, [0.0, 0.1, 0.2], atol=1e-6)
    assert (track.started, track.above) == (MIDDAY, "home")


@pytest.mark.parametrize(
    ("head", "clock", "seconds"),
    [
        ("CUSTOM.updateTime", ("2024/05/03 12:00:00.250", "2024/05/03 12:00:01.250"), 1.0),
        ("OSD.flyTime", ("59.5s", "1m 2.5s"), 3.0),
        ("OSD.flyTime", ("59m 59s", "1h 0m 4.5s"), 5.5),
        ("OSD.flyTime [s]", ("0.5", "2"), 1.5),
        ("datetime(utc)", ("2024-05-03 12:00:00", "2024-05-03 12:00:07"), 7.0),
    ],
)
def test_flight_records_have_other_clocks_too(tmp_path, head, clock, seconds):
    rows = [f"{time},46.000{k},9.0,{k}" for k, time in enumerate(clock)]
    text = "\n".join([f"{head},OSD.latitude,OSD.longitude,OSD.height [m]", *rows])
    [track] = read_tracks(written(tmp_path, "a.csv", text))
    assert track.duration_s == pytest.approx(seconds)
    assert track.altitude_m.tolist() == [0.0, 1.0]


# ---------------------------------------------------------------- MAVLink


@pytest.mark.parametrize("how", [{}, {"first": True}, {"key": b"k" * 32}], ids=["2", "1", "signed"])
def test_telemetry_is_read_as_pymavlink_reads_it(tmp_path, how):
    path = written(tmp_path, "flown.tlog", tlog(straight(20), **how))
    [track] = read_tracks(path)
    log, found = mavutil.mavlink_connection(str(path)), []
    while message := log.recv_match(type="GLOBAL_POSITION_INT"):
        found.append((message.lat / 1e7, message.lon / 1e7, message._timestamp - NOON, message.relative_alt / 1000))
    log.close()
    np.testing.assert_allclose(
        np.column_stack([track.lat, track.lon, track.times_s, track.altitude_m]), found, rtol=0, atol=1e-6
    )
    assert (track.started, track.above) == (MIDDAY, "home")


def test_telemetry_of_two_vehicles_is_two_tracks_and_bytes_between_packets_are_passed_over(tmp_path):
    data = tlog(straight(5)) + b"\0" * 100 + tlog(straight(7), system=2) + tlog(straight(1))[:20]
    first, second = read_tracks(written(tmp_path, "a.tlog", data))
    assert (len(first.lat), len(second.lat)) == (5, 7)
    assert "bytes between packets passed over" in first.notes[0]


def test_a_packet_with_a_wrong_checksum_is_none(tmp_path):
    data = bytearray(tlog(straight(3)))
    data[-6] ^= 0x10
    assert len(read_tracks(written(tmp_path, "a.tlog", bytes(data)))[0].lat) == 2


@pytest.mark.parametrize("kinds", [(1, 2, 3), (2, 3)], ids=["POS", "GPS"])
def test_dataflash_is_read_as_pymavlink_reads_it(tmp_path, kinds):
    path = written(tmp_path, "flown.bin", dataflash(straight(20), kinds))
    [track] = read_tracks(path)
    log, found = DFReader.DFReader_binary(str(path)), []
    while message := log.recv_match(type="POS" if 1 in kinds else "GPS"):
        found.append((message.Lat, message.Lng, message._timestamp - NOON))
    log.filehandle.close()
    np.testing.assert_allclose(np.column_stack([track.lat, track.lon, track.times_s]), found, rtol=0, atol=2e-3)
    np.testing.assert_allclose(np.column_stack([track.lat, track.lon]), np.array(found)[:, :2], rtol=0, atol=1e-9)
    assert (track.started, track.above) == (MIDDAY, "home" if 1 in kinds else "sea")
    assert track.altitude_m[0] == pytest.approx(1000.0 + 900.0 * (1 not in kinds))


def test_dataflash_as_text_is_the_same(tmp_path):
    lines = [
        "FMT, 128, 89, FMT, BBnNZ, Type,Length,Name,Format,Columns",
        "FMT, 2, 30, GPS, QBIHLL, TimeUS,Status,GMS,GWk,Lat,Lng",
        "PARM, 1, SOME, 2",
        *(
            f"GPS, {1000 * k}, {3 if k else 1}, {475_218_000 + k}, 2312, {46 + k * 1e-7:.7f}, 9.0"
            for k in range(0, 5000, 1000)
        ),
    ]
    [track] = read_tracks(written(tmp_path, "flown.log", "\n".join(lines)))
    assert track.started == datetime(2024, 5, 3, 12, 0, 1, tzinfo=UTC)
    assert track.times_s.tolist() == [0, 1, 2, 3]


# ---------------------------------------------------------------- refusals


BOMB = '<!DOCTYPE a [<!ENTITY x "lol"><!ENTITY y "&x;&x;&x;&x;">]>'


@pytest.mark.parametrize(
    ("name", "content", "told"),
    [
        ("a.txt", b"", "the suffix '.txt' came; expected a track named .gpx, .geojson"),
        ("a.gpx", gpx(straight(2), head=BOMB), "a document type came"),
        ("a.gpx", gpx(straight(2), head=BOMB).replace("'1.0'", "'1.0' encoding='UTF-16'").encode("utf-16"), "document"),
        ("a.gpx", "<gpx>" * 200, "more than 64 elements in one another"),
        ("a.gpx", "<gpx><trk>", "it is not XML"),
        ("a.gpx", "<gpx/>", "no fix came that can be true"),
        ("a.gpx", gpx([("NaN", 9.0, 0, 0)]), "'NaN' came; expected a latitude"),
        ("a.gpx", gpx([(91.0, 9.0, 0, 0)]), "latitude 91, longitude 9 came"),
        ("a.gpx", gpx([(46.0, 9.0, 0, "inf")]), "'inf' came; expected metres above the sea"),
        ("a.gpx", gpx([(46.0, 9.0, 0, 0)]).replace("2024-", "soon"), "expected a time such as"),
        ("a.gpx", gpx([(0.0, 0.0, k, 0) for k in range(3)]), "3 of 3 fixes dropped: at latitude 0"),
        ("a.gpx", "<?xml version='1.0' encoding='nobody'?><gpx/>", "it is not XML"),
        ("a.geojson", "[" * 100_000, "it is not JSON"),
        ("a.geojson", "[1]", "something else than an object"),
        ("a.geojson", '{"type": "LineString", "coordinates": [[9, NaN]]}', "NaN came, which is no number"),
        ("a.geojson", '{"type": "LineString", "coordinates": [[9, 1e400]]}', "expected a latitude"),
        ("a.geojson", '{"type": "LineString", "coordinates": [9, 46]}', "9 came for a point"),
        ("a.geojson", '{"type": "LineString", "coordinates": {}}', "expected a list"),
        ("a.geojson", '{"type": "LineString", "coordinates": [[9, ' + "9" * 5000 + "]]}", "it is not JSON"),
        ("a.geojson", json.dumps(line(ISO[:2])), "3 points and 2 times came"),
        ("a.geojson", b"\xff\xfe", "not text"),
        ("a.kml", "<kml><Track><when>2024-05-03T12:00:00Z</when></Track></kml>", "1 times and 0 places"),
        ("a.csv", "a,b\n1,2\n", "the columns a, b came; expected a flight record"),
        ("a.csv", "latitude,longitude\n" + "9" * 200_000 + ",2\n", "it is not CSV"),
        ("a.tlog", b"\xfe" * 50, "without a packet"),
        ("a.tlog", b"\0" * 1_200_000, "more than 1,000,000 bytes that are no packet"),
        ("a.bin", b"MZ" * 50, "does not begin with a format"),
        ("a.bin", dataflash([])[:89] + b"\xa3\x95\x77" * 400_000, "more than 1,000,000 bytes that are no message"),
        ("a.bin", dataflash(straight(1)).replace(b"QLLfff", b"Q?Lfff"), "FMT POS: values of type '?' came"),
        ("a.log", b"hello", "does not begin with a format"),
    ],
)
def test_what_is_no_track_is_refused_with_the_reason(tmp_path, name, content, told):
    with pytest.raises(DataFormatError) as raised:
        read_tracks(written(tmp_path, name, content))
    assert told in str(raised.value)
    assert str(tmp_path) in str(raised.value)


def test_gaps_and_speeds_are_above_zero(tmp_path):
    path = written(tmp_path, "a.gpx", gpx(straight(2)))
    for wrong in ({"gap_s": 0.0}, {"speed_mps": float("nan")}):
        with pytest.raises(InvalidProblemError, match="expected a number above 0"):
            read_tracks(path, **wrong)
