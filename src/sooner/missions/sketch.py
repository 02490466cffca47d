"""The vector files of `[area]` as one sketch on the globe: polygon, zones, segments, last known place, points."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any

from sooner.errors import InvalidProblemError, printable
from sooner.missions.drawings import Draft, Drafts, is_drawn, titles
from sooner.missions.faults import Faults
from sooner.missions.settings import Area, LastKnown, NoFlyCircle, Place, Segments, Zones

__all__ = ["Circle", "Sketch", "named_place"]

LEAST_WHOLE = 1.005  # that shares may total, so that rounded percents pass


@dataclass(frozen=True, eq=False)
class Circle:
    """A point or a line of a no-fly zone, and how far around it is one."""

    geometry: Any
    radius_m: float


@dataclass(frozen=True, eq=False)
class Sketch:
    """What is drawn, in longitude and latitude.

    Parameters
    ----------
    polygon : geometry or None          `area.polygon`
    flight_area : geometry or None      `area.flight_area`
    zones : tuple of geometry           polygons of `area.no_fly` and of drawn `area.obstacles`
    circles : tuple of Circle           their points and lines
    segments : tuple                    (title, polygon, POC) of each search segment
    last_known : (lon, lat) or None
    points : mapping                    title -> (lon, lat) of the points that are the only ones of that title
    twice : frozenset of str            titles of several points
    """

    polygon: Any | None
    flight_area: Any | None
    zones: tuple[Any, ...]
    circles: tuple[Circle, ...]
    segments: tuple[tuple[str, Any, float], ...]
    last_known: tuple[float, float] | None
    points: Mapping[str, tuple[float, float]]
    twice: frozenset[str]

    @classmethod
    def read(cls, faults: Faults, area: Area) -> Sketch:
        """Everything that the files hold; what is wrong is added to the faults."""
        drafts = Drafts(faults)
        polygon = drafts.polygons("area.polygon", area.polygon)
        flight_area = drafts.polygons("area.flight_area", area.flight_area)
        zones, circles = _zones(faults, "area.no_fly", drafts.of("area.no_fly", area.no_fly))
        circles += _told_circles(faults, area.no_fly)
        if is_drawn(area.obstacles) and area.obstacles is not None:
            more, around = _zones(faults, "area.obstacles", drafts.of("area.obstacles", area.obstacles))
            zones, circles = zones + more, circles + around
        drafts.of("area.points", area.points)
        segments = () if area.segments is None else tuple(_segments(faults, drafts, area.segments))
        known = drafts.points
        points = {name: places[0] for name, places in known.items() if len(set(places)) == 1}
        twice = frozenset(set(known) - set(points))
        last = None if area.last_known is None else _last_known(faults, area.last_known, points, twice)
        return cls(polygon, flight_area, tuple(zones), tuple(circles), segments, last, points, twice)


def named_place(faults: Faults, key: str, title: str, points: Mapping[str, Any], twice: frozenset[str]) -> Any | None:
    """The point of a title; None, and a fault, where none or several have it."""
    if title in points:
        return points[title]
    told = ", ".join(repr(printable(name[:40])) for name in sorted(points)[:10]) or "none yet (area.points names files)"
    if title in twice:
        faults.add(key, f"{title!r} came, which several points are called", "expected a title that one point has")
    else:
        faults.add(key, f"{title!r} came", f"expected the title of a point in the area's files: {told}")
    return None


def _zones(faults: Faults, key: str, drafts: list[Draft]) -> tuple[list[Any], list[Circle]]:
    """Polygons, and lines and points with a radius; points without one mark places, launches say, and no zone."""
    import shapely

    from sooner.io.vectors import crossing

    zones: list[Any] = []
    circles: list[Circle] = []
    for draft in drafts:
        feature, radius = draft.feature, _radius_m(draft)
        name = f"{draft.said.file}{f', {feature.name[:40]}' if feature.name else ''}"
        if wrong := crossing(feature.geometry):
            faults.once(key, f"{name}: {wrong}", "expected borders that do not cross: draw it again there")
        elif feature.geometry.geom_type.endswith("Polygon"):
            zones += list(shapely.get_parts(feature.geometry))
        elif radius is not None:
            circles.append(Circle(feature.geometry, radius))
        elif not feature.geometry.geom_type.endswith("Point"):
            expected = "expected radius_m, here or as the feature's own; or polygons"
            faults.once(key, f"{name} is a line, and nobody says how far around it is meant", expected)
    if drafts and not (zones or circles) and key not in faults.wrong:
        came = f"{drafts[0].said.file} has no polygon, and no point or line with a radius"
        faults.once(key, came, "expected some, or radius_m")
    return zones, circles


def _told_circles(faults: Faults, said: Zones | None) -> list[Circle]:
    """Circles that the mission file itself tells."""
    import shapely

    found = []
    for each in said if isinstance(said, list) else [said]:
        if not isinstance(each, NoFlyCircle):
            continue
        if each.lat is None or each.lon is None or each.radius_m is None:
            came = ", ".join(sorted(each.model_fields_set)) or "nothing"
            faults.once("area.no_fly", f"a circle of {came} came", "expected { lat, lon, radius_m } together")
        else:
            found.append(Circle(shapely.Point(each.lon, each.lat), each.radius_m))
    return found


def _radius_m(draft: Draft) -> float | None:
    if draft.said.radius_m is not None:
        return draft.said.radius_m
    found = _number(draft.feature.properties.get("radius_m"))
    return found if found is not None and 0.0 < found <= 100_000.0 else None


def _number(said: Any) -> float | None:
    """A number, or text that is one, with a percent sign perhaps; None for others."""
    try:
        found = float(str(said).strip().removesuffix("%")) if not isinstance(said, bool) else None
    except ValueError:
        return None
    return found if found is not None and abs(found) < 1e12 else None


def _segments(faults: Faults, drafts: Drafts, said: str | Segments) -> Iterator[tuple[str, Any, float]]:
    """Title, polygon and POC of each."""
    said = Segments(file=said) if isinstance(said, str) else said
    features = drafts.features("area.segments", said.file, said.layer)
    drawn = [each for each in features if each.geometry.geom_type.endswith("Polygon")]
    if features and not drawn:
        faults.once("area.segments", f"{said.file} has no polygon", "expected one for each segment")
    values = _told(faults, said, drawn)
    if values is None:
        return
    whole = 1.0 if max(values.values(), default=0.0) <= 1.0 else 100.0
    total = sum(values.values()) / whole
    if total > LEAST_WHOLE or not total > 0:
        came = f"POC that total {sum(values.values()):g} came"
        expected = "expected at most 1, or 100 in percent; the rest is outside"
        faults.once("area.segments", came, expected if total else "expected some above 0")
        return
    for name in values:
        polygon = _polygon(
            faults, name, [each for each in drawn if each.name == name or f"#{drawn.index(each) + 1}" == name]
        )
        if polygon is not None:
            yield name, polygon, values[name] / whole / max(total, 1.0)


def _told(faults: Faults, said: Segments, drawn: list[Any]) -> dict[str, float] | None:
    """POC by title; polygons of one title are one segment, those without are numbered."""
    if said.poc is not None:
        unknown = [name for name in said.poc if name not in {each.name for each in drawn}]
        if unknown and drawn:
            faults.once("area.segments.poc", f"{unknown[0]!r} came", f"expected {titles(drawn)}")
        return None if unknown or not drawn else dict(said.poc)
    values: dict[str, float] = {}
    for number, each in enumerate(drawn):
        name = each.name or f"#{number + 1}"
        properties = {str(key).lower(): value for key, value in each.properties.items()}
        found = _number(properties.get(said.attribute.lower()))
        if found is None or found < 0:
            came = f"{said.file}, {name[:40]}: {said.attribute} = {properties.get(said.attribute.lower())!r} came"[:200]
            faults.once("area.segments", came, "expected a number of at least 0, or segments.poc = { title = number }")
            return None
        if values.setdefault(name, found) != found:
            faults.once("area.segments", f"two segments {name[:40]!r} with other POC came", "expected other titles")
            return None
    return values if drawn else None


def _polygon(faults: Faults, name: str, parts: list[Any]) -> Any | None:
    from sooner.io.vectors import polygons_of

    try:
        return polygons_of(parts)
    except InvalidProblemError as error:
        faults.once("area.segments", f"{name[:40]}: {error}", "expected borders that do not cross: draw it again there")
        return None


def _last_known(
    faults: Faults, said: LastKnown, points: Mapping[str, tuple[float, float]], twice: frozenset[str]
) -> tuple[float, float] | None:
    key = "area.last_known"
    for name in ("place", "rings_m", "quantiles"):
        if getattr(said, name) in (None, []) and not {key, f"{key}.{name}"} & faults.wrong:
            faults.add(f"{key}.{name}", "nothing came", "expected place, rings_m and quantiles together")
    if isinstance(said.place, str):
        found: tuple[float, float] | None = named_place(faults, f"{key}.place", said.place, points, twice)
        return found
    if isinstance(said.place, Place):
        if said.place.model_fields_set != {"lat", "lon"} or abs(said.place.lat) > 89.9:
            expected = "expected { lat, lon } in degrees, away from the poles"
            faults.add(f"{key}.place", f"lat {said.place.lat:g}, lon {said.place.lon:g} came", expected)
            return None
        return said.place.lon, said.place.lat
    return None
