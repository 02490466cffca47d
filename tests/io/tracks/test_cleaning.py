"""Fixes that cannot be true do not cost those that can."""

import itertools
from contextlib import suppress

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from sooner.errors import DataFormatError
from sooner.io.georeference import ground_m
from sooner.io.tracks import read_tracks
from sooner.io.tracks.cleaning import FASTEST_MPS, _rising, cleaned, flights_of
from sooner.io.tracks.fixes import Recorded
from sooner.io.tracks.read import _READERS
from tests.io.tracks.files import dataflash, gpx, straight, tlog


def recorded(rows, **more) -> Recorded:
    lat, lon, seconds, up = np.array(rows, float).reshape(-1, 4).T
    return Recorded("", lat, lon, seconds, up, **more)


def test_one_wrong_fix_costs_itself_alone():
    rows = straight(20)
    for which, wrong in itertools.product(
        (0, 7, 19), ((47.0, 9.0, None, 0.0), (0.0, 0.0, None, 0.0), (np.nan, 9.0, None, 0.0))
    ):
        spoilt = list(rows)
        spoilt.insert(which, (*wrong[:2], rows[which][2] - 0.5, wrong[3]))
        found = cleaned(recorded(spoilt))
        np.testing.assert_allclose(found.lat, [row[0] for row in rows])
        assert found.notes[0].startswith("1 of 21 fixes dropped")


def test_one_wrong_clock_costs_itself_alone():
    rows = straight(20)
    rows[5] = (*rows[5][:2], 1e6, 0.0)
    found = cleaned(recorded(rows))
    assert len(found.lat) == 19
    assert found.notes == ("1 of 20 fixes dropped: their times stand still or go back",)


def test_a_track_that_leaps_all_the_time_is_none():
    rows = [(46.0 + k % 2, 9.0, float(k), 0.0) for k in range(5000)]
    assert len(cleaned(recorded(rows)).lat) == 0


def test_a_flight_over_the_date_line_goes_on():
    rows = [(10.0, 179.9995, 0.0, 0.0), (10.0, 179.9999, 5.0, 0.0), (10.0, -179.9997, 10.0, 0.0)]
    [track] = flights_of(cleaned(recorded(rows)), "", 15.0, None)
    np.testing.assert_allclose(track.lon, [179.9995, 179.9999, 180.0003])
    assert track.length_m < 100.0


def test_a_segment_begins_where_its_first_fix_is_dropped():
    rows = straight(6)
    rows[3] = (0.0, 0.0, *rows[3][2:])
    [track] = flights_of(cleaned(recorded(rows, begins=[3])), "", 15.0, None)
    assert track.gaps.tolist() == [2]


def brute_longest(times):
    for n in range(len(times), 0, -1):
        if any(all(a < b for a, b in itertools.pairwise(each)) for each in itertools.combinations(times, n)):
            return n
    return 0


@given(st.lists(st.integers(0, 6), min_size=1, max_size=8))
def test_as_many_rising_times_are_kept_as_there_can_be(times):
    keep = _rising(np.array(times, float))
    assert (np.diff(np.array(times)[keep]) > 0).all()
    assert keep.sum() == brute_longest(times)


FIXES = st.lists(
    st.tuples(st.floats(45.99, 46.01) | st.just(np.nan), st.floats(8.99, 9.01), st.floats(0, 900), st.just(0.0)),
    min_size=1,
    max_size=40,
)


@given(FIXES, st.floats(1.0, 60.0))
def test_what_is_left_can_be_true_and_cleaning_it_again_changes_nothing(rows, gap_s):
    once = cleaned(recorded(rows))
    again = cleaned(once)
    np.testing.assert_array_equal(once.lat, again.lat)
    assert once.notes == again.notes
    if len(once.lat) == 0:
        return
    flights = flights_of(once, "", gap_s, None)
    assert sum(len(track.lat) for track in flights) == len(once.lat)
    for track in flights:
        steps = np.diff(track.times_s)
        assert (ground_m(track.places) <= FASTEST_MPS * steps + 10.0 + 1e-6).all()
        assert set(np.flatnonzero(steps > gap_s)) == set(track.gaps)
        assert sum(map(len, track.pieces)) == len(track.lat)


SEEDS = {
    ".gpx": gpx(straight(4)).encode(),
    ".geojson": b'{"type": "LineString", "coordinates": [[9, 46], [9, 46.1]]}',
    ".kml": b"<kml><Placemark><LineString><coordinates>9,46 9,46.1</coordinates></LineString></Placemark></kml>",
    ".csv": b"OSD.flyTime [s],OSD.latitude,OSD.longitude\n1,46,9\n2,46.0001,9\n",
    ".tlog": tlog(straight(4)),
    ".bin": dataflash(straight(4)),
    ".log": b"FMT, 1, 9, POS, QLL, TimeUS,Lat,Lng\nPOS, 1, 46, 9\nPOS, 2, 46, 9\n",
}


@pytest.mark.parametrize("suffix", sorted(SEEDS))
def test_files_with_bytes_turned_are_read_or_refused(tmp_path, suffix):
    assert set(_READERS) - {".json"} == set(SEEDS)
    rng, path = np.random.default_rng(5), tmp_path / f"a{suffix}"
    for _ in range(150):
        data = bytearray(SEEDS[suffix])
        for _ in range(rng.integers(1, 6)):
            where = rng.integers(len(data))
            if rng.random() < 0.3:
                del data[where : where + rng.integers(1, 20)]
                data = data or bytearray(b" ")
            else:
                data[where] = rng.integers(256)
        path.write_bytes(bytes(data))
        with suppress(DataFormatError):
            for track in read_tracks(path):
                assert np.isfinite(track.places).all()
