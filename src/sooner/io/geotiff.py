"""Writing GeoTIFF: numbers over the cells of a raster, at their place on the globe."""

from __future__ import annotations

import warnings
from collections.abc import Mapping

import numpy as np
from numpy.typing import ArrayLike

from sooner.io.georeference import Georeference

__all__ = ["geotiff"]


def geotiff(values: ArrayLike, ground: Georeference, about: str = "", tags: Mapping[str, str] | None = None) -> bytes:
    """One band of numbers as a compressed GeoTIFF; the same bytes for the same numbers.

    Parameters
    ----------
    values : (H, W) float       row 0 is north; kept to seven digits
    ground : Georeference       of these cells
    about : str                 what the numbers are, told beside the band
    tags : mapping              more of the kind, of the whole file
    """
    from rasterio import Affine
    from rasterio.crs import CRS
    from rasterio.io import MemoryFile

    band, (west, top) = np.asarray(values, np.float32), ground.corner
    profile = {
        "driver": "GTiff",
        "height": band.shape[0],
        "width": band.shape[1],
        "count": 1,
        "dtype": "float32",
        "crs": CRS.from_string(ground.crs),
        "transform": Affine(ground.side, 0.0, west, 0.0, -ground.side, top),
        "compress": "deflate",
        "predictor": 3,
    }
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", PendingDeprecationWarning)  # within rasterio: it multiplies matrices with *
        with MemoryFile() as memory:
            with memory.open(**profile) as file:
                file.write(band, 1)
                if about:
                    file.set_band_description(1, about)
                file.update_tags(**dict(tags or {}))
            return bytes(memory.read())
