"""Vector files: what a command post drew, as features in longitude and latitude.

GeoJSON (CalTopo's conventions understood), GeoPackage, KML, KMZ and GPX are read with Python's own parsers of JSON, XML
and SQLite, within limits: nothing that a file names is opened or fetched, nothing in it is run, nothing is written.
"""

from sooner.io.vectors.coverage import cover
from sooner.io.vectors.feature import Feature
from sooner.io.vectors.files import SUFFIXES, read_features
from sooner.io.vectors.polygons import crossing, polygons_of

__all__ = ["SUFFIXES", "Feature", "cover", "crossing", "polygons_of", "read_features"]
