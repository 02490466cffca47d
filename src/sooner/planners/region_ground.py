"""A search over regions as plain arrays; it lives in the room of problems, so that bounds may open it too."""

from sooner.problem.region_ground import RegionGround, single_region_searcher

__all__ = ["RegionGround", "single_region_searcher"]
