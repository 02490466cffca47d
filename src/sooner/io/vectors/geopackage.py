"""GeoPackage [OGC 12-128]: a layer of a SQLite database, which is read as a table and in no other way."""

from __future__ import annotations

import sqlite3
from collections.abc import Iterator
from contextlib import closing, contextmanager
from pathlib import Path
from typing import Any
from urllib.parse import quote

from sooner.errors import printable
from sooner.io.reading import opened
from sooner.io.vectors.feature import MOST_FEATURES, Drawn, refusal
from sooner.io.vectors.geojson import title
from sooner.io.vectors.wkb import wkb

__all__ = ["geopackage"]

MOST_BYTES = 500_000_000
MOST_BYTES_OF_VALUE = 20_000_000
MOST_STEPS = 20_000_000  # of SQLite's machine; a feature takes some hundred
EXPECTED = "expected a GeoPackage with a layer of features"
_ENVELOPES = (0, 32, 48, 48, 64)  # bytes, by the flag that says which
_ALLOWED = {sqlite3.SQLITE_SELECT, sqlite3.SQLITE_READ, sqlite3.SQLITE_FUNCTION}


def geopackage(path: Path, layer: str | None) -> tuple[list[Drawn], str]:
    """The features of a layer, and its projection: "" for longitude and latitude, else EPSG and a number or WKT.

    Views are not read and triggers do not fire: nothing but ordinary tables is asked, and nothing is written.
    """
    with opened(path) as file:
        head, size = file.read(16), file.seek(0, 2)
    if head != b"SQLite format 3\0":
        raise refusal(path, "", "something that is no SQLite database came", EXPECTED)
    if size > MOST_BYTES:
        raise refusal(path, "", "a file of more than 500 MB came", "expected a cut of the search area")
    journal = path.with_name(path.name + "-wal")
    if journal.exists() and journal.stat().st_size:
        expected = "expected a file that no other program has open: close it there first"
        raise refusal(path, "", f"{journal.name} lies beside it, with changes not yet in it", expected)
    try:
        with _tables(path) as database:
            table, column, number = _layer(path, database, layer)
            return list(_features(path, database, table, column)), _crs(path, database, number)
    except (sqlite3.Error, UnicodeError, OverflowError) as error:
        raise refusal(path, "", f"it cannot be read ({error})"[:200], EXPECTED) from None


@contextmanager
def _tables(path: Path) -> Iterator[sqlite3.Connection]:
    """A database that answers questions about its tables, within limits, and does nothing else."""
    with closing(sqlite3.connect(f"file:{quote(str(path.absolute()))}?mode=ro&immutable=1", uri=True)) as database:
        database.execute("PRAGMA trusted_schema = OFF")
        database.execute("PRAGMA cell_size_check = ON")
        database.setlimit(sqlite3.SQLITE_LIMIT_LENGTH, MOST_BYTES_OF_VALUE)
        database.set_authorizer(lambda what, *_: sqlite3.SQLITE_OK if what in _ALLOWED else sqlite3.SQLITE_DENY)
        left = iter(range(MOST_STEPS // 10_000))
        database.set_progress_handler(lambda: int(next(left, None) is None), 10_000)
        yield database


def _quoted(name: str) -> str:
    return '"' + name.replace('"', '""') + '"'


def _layer(path: Path, database: sqlite3.Connection, layer: str | None) -> tuple[str, str, int]:
    """Table, column of geometry, and number of the projection, of the layer asked for or of the only one."""
    plain = database.execute(
        "SELECT name FROM sqlite_master WHERE type = 'table' AND sql NOT LIKE 'CREATE VIRTUAL%' LIMIT 10000"
    )
    tables = {str(name).lower() for (name,) in plain}
    if not {"gpkg_geometry_columns", "gpkg_spatial_ref_sys"} <= tables:
        raise refusal(path, "", "a database without the tables of a GeoPackage came", EXPECTED)
    found = {
        str(table): (str(table), str(column), int(number))
        for table, column, number in database.execute(
            "SELECT table_name, column_name, srs_id FROM gpkg_geometry_columns LIMIT 1000"
        )
        if str(table).lower() in tables
    }
    if layer is not None and layer in found:
        return found[layer]
    names = ", ".join(printable(name)[:40] for name in list(found)[:10]) or "none"
    if layer is not None:
        raise refusal(path, "", f"layer {layer!r} was asked for", f"expected one of its layers: {names}")
    if len(found) != 1:
        raise refusal(path, "", f"{len(found)} layers came ({names})", "expected one, or layer = its name")
    return next(iter(found.values()))


def _crs(path: Path, database: sqlite3.Connection, number: int) -> str:
    row = database.execute(
        "SELECT organization, organization_coordsys_id, definition FROM gpkg_spatial_ref_sys WHERE srs_id = ?",
        (number,),
    ).fetchone()
    if row is None or number in (-1, 0):
        expected = "expected a layer that says its projection: set it (QGIS: Layer, Set Layer CRS) and save again"
        raise refusal(path, "", "a layer without a coordinate reference system came", expected)
    organization, code, definition = row
    if str(organization).upper() == "EPSG":
        return "" if int(code) == 4326 else f"EPSG:{int(code)}"
    return str(definition)


def _features(path: Path, database: sqlite3.Connection, table: str, column: str) -> Iterator[Drawn]:
    rows = database.execute(f"SELECT * FROM {_quoted(table)} LIMIT {MOST_FEATURES + 1}")
    names = [str(each[0]) for each in rows.description]
    which = [name.lower() for name in names].index(column.lower()) if column.lower() in map(str.lower, names) else -1
    if which < 0:
        raise refusal(path, table[:40], "a layer without its column of geometry came", EXPECTED)
    for number, row in enumerate(rows):
        properties = {
            name: value for name, value in zip(names, row, strict=True) if name != names[which] and value is not None
        }
        name = title(properties)
        key = f"{table[:40]}, row {number + 1}" + (f" ({name[:40]})" if name else "")
        try:
            geometry = _geometry(row[which])
        except ValueError as error:
            raise refusal(path, key, str(error), EXPECTED) from None
        if geometry is not None:
            yield Drawn(key, name, str(properties.get("class", "")), geometry, properties)


def _geometry(said: Any) -> Any | None:
    if said is None:
        return None
    if not isinstance(said, bytes) or said[:2] != b"GP" or len(said) < 8 or (said[3] >> 1) & 7 >= len(_ENVELOPES):
        raise ValueError("something that is no geometry of a GeoPackage came")
    if said[3] & 0x10:  # it says that it is empty
        return None
    return wkb(said[8 + _ENVELOPES[(said[3] >> 1) & 7] :])
