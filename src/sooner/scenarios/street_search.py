"""A team that maps streets nobody knows, and hunts whoever walks on them: the search of [Wolek2020], as files."""

from __future__ import annotations

from dataclasses import dataclass

from sooner.io import StreetMap, street_map_json
from sooner.scenarios.street_grid import STREET_KINDS, street_grid

__all__ = ["StreetSearch", "street_search"]


@dataclass(frozen=True, eq=False)
class StreetSearch:
    """Streets, one target, four drones, four minutes.

    Parameters
    ----------
    title : str
    streets : StreetMap
    searchers : int
    seconds : int
    """

    title: str
    streets: StreetMap
    searchers: int = 4
    seconds: int = 240

    def files(self) -> dict[str, bytes]:
        """A mission file and its streets, by name; what `sooner scenario` writes."""
        return {"mission.toml": self._mission().encode(), "streets.json": street_map_json(self.streets)}

    def _mission(self) -> str:
        searcher = """
[[searcher]]
moves = "waypoints"
speed_mps = 3.0
accel_mps2 = 2.0
"""
        return f"""\
name = "{self.title}"

[area]
streets = "streets.json"     # the truth; the team does not know it

[target]                     # left out, nobody is there: what is detected then is false
count = 1
rest = 0.5                   # probability that it rests in a second
bias = "none"                # or "evasive": it shies away from drones

[sensor]
radius_m = 12.5              # what is in view, every second
map_sensitivity = 4.0        # standard deviations by which a look at a street stands out
target_sensitivity = 4.0
{searcher * self.searchers}
[budget]
seconds = {self.seconds}
replan_s = 5

[estimator]
detector = "lrdt"            # tracks a target before it is detected; "cbht" tests each cell by itself
prior = "uniform"            # or "kriged": streets foretold from those seen
"""


def street_search(seed: int = 0) -> StreetSearch:
    """200 m x 200 m of streets, as large as those of [Wolek2020]; gridiron, suburb and park by turns.

    >>> sorted(street_search(seed=1).files())
    ['mission.toml', 'streets.json']
    """
    kind = tuple(STREET_KINDS)[seed % len(STREET_KINDS)]
    title = f"Unknown streets, {kind}"
    return StreetSearch(title, StreetMap(street_grid(kind, seed), title))
