import pytest

from sooner.errors import DataFormatError
from sooner.io.vectors.buildings import buildings

pytest.importorskip("osmium")

NODES = "".join(
    f'<node id="{number + 1}" lat="{lat}" lon="{lon}"/>'
    for number, (lat, lon) in enumerate([(46, 11), (46, 11.001), (46.001, 11.001), (46.001, 11)])
)


def extract(folder, *ways):
    said = ""
    for number, (key, refs) in enumerate(ways):
        nodes = "".join(f'<nd ref="{ref}"/>' for ref in refs)
        said += f'<way id="{number + 1}">{nodes}<tag k="{key}" v="yes"/></way>'
    path = folder / "town.osm"
    path.write_text(f'<osm version="0.6">{NODES}{said}</osm>')
    return path


def test_closed_ways_that_are_buildings_are_polygons(tmp_path):
    path = extract(tmp_path, ("building", (1, 2, 3, 4, 1)), ("highway", (1, 3)), ("leisure", (1, 2, 3, 1)))
    (found,) = buildings(path)
    assert found.geometry.bounds == pytest.approx((11.0, 46.0, 11.001, 46.001))
    assert found.kind == "building"


def test_extracts_without_buildings_and_garbage_are_refused(tmp_path):
    with pytest.raises(DataFormatError, match="without buildings"):
        buildings(extract(tmp_path, ("highway", (1, 3))))
    for content in ("", "<osm>", "no extract"):
        (tmp_path / "bad.osm").write_text(content)
        with pytest.raises(DataFormatError, match=r"bad\.osm"):
            buildings(tmp_path / "bad.osm")
    with pytest.raises(DataFormatError, match="no such file"):
        buildings(tmp_path / "none.osm")
