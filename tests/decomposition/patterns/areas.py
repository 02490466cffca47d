"""Random areas: star-shaped, concave, with holes."""

import numpy as np
import shapely


def star(rng, centre, mean, corners, roughness):
    """A polygon about a centre whose corners lie at random distances: concave, never self-crossing."""
    angles = np.sort(rng.uniform(0, 2 * np.pi, corners))
    reach = mean * (1 + roughness * rng.uniform(-1, 1, corners))
    return shapely.Polygon(centre + reach[:, None] * np.stack([np.cos(angles), np.sin(angles)], axis=1)).buffer(0)


def area(seed, size=1000.0, holes=3):
    """A concave area some `size` wide, with holes; at times in several parts."""
    rng = np.random.default_rng(seed)
    out = star(rng, np.zeros(2), size / 2, rng.integers(4, 14), rng.uniform(0, 0.7))
    for _ in range(rng.integers(0, holes + 1)):
        hole = star(rng, rng.uniform(-0.4, 0.4, 2) * size, size * rng.uniform(0.03, 0.15), 6, 0.5)
        out = out - hole
    return out if out.area > 0 else shapely.box(0, 0, size, size)


def length(tracks):
    return float(sum(np.hypot(*np.diff(track, axis=0).T).sum() for track in tracks))


def check_inside(tracks, free):
    """Every leg of every track lies in the ground, but for rounding."""
    roomy = free.buffer(1e-5)
    for track in tracks:
        assert track.shape == (max(len(track), 2), 2)
        assert np.isfinite(track).all()
        assert shapely.covers(roomy, shapely.linestrings(track))
