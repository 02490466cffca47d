import numpy as np
import pytest
import shapely

from sooner.errors import InvalidProblemError
from sooner.io.vectors import Feature, polygons_of
from tests.io.vectors.drawn import square


def test_polygons_are_joined_and_their_holes_kept():
    holed = square(holes=[square(46.104, 11.204, 0.002)])
    found = polygons_of(
        [Feature("", "", holed), Feature("", "", square(46.1, 11.21)), Feature("", "", shapely.Point(0, 0))]
    )
    assert found.area == pytest.approx(2e-4 - 4e-6)
    assert sum(len(part.interiors) for part in shapely.get_parts(found)) == 1


def test_a_border_that_crosses_itself_is_named_with_its_place():
    bow = shapely.Polygon([(11, 46), (12, 47), (12, 46), (11, 47)])
    with pytest.raises(InvalidProblemError, match=r"Bow: .*crosses itself at longitude 11\.5, latitude 46\.5"):
        polygons_of([Feature("Bow", "", bow)])


def test_closed_lines_are_borders_only_where_there_is_no_polygon():
    line = shapely.LineString(square().exterior.coords)
    assert polygons_of([Feature("", "track", line)]).equals(square())
    other = square(46.2)
    assert polygons_of([Feature("", "track", line), Feature("", "", other)]).equals(other)
    assert polygons_of([Feature("", "", shapely.LineString([(0, 0), (1, 1)]))]).is_empty


def test_a_polygon_with_a_hole_beyond_its_border_is_refused():
    with pytest.raises(InvalidProblemError, match="hole"):
        polygons_of([Feature("", "", shapely.Polygon(square().exterior, [square(47.0).exterior]))])
    assert np.isclose(polygons_of([Feature("", "", square())]).area, 1e-4)
