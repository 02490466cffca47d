"""The picture of a debrief: the flights over what was there to find, how well they looked, and what remains."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from sooner.missions.debrief import Debrief

__all__ = ["debrief_picture"]


def debrief_picture(debrief: Debrief) -> bytes:
    """PNG: POC before with the tracks and the plan, POD, and POC after with gaps."""
    from sooner.plotting.debrief_picture import Maps, draw_debrief

    mission, compared = debrief.mission, debrief.compared
    count = len(debrief.tracks)
    told = [f"{count} flight{'s' * (count != 1)}"]
    if mission.belief is not None:
        told.append(f"POS {debrief.found:.1%}, {debrief.so_far.pos:.1%} so far")
    else:
        told.append(f"{debrief.found:.3g} targets found, as expected")
    if compared is not None and compared.share_flown is not None:
        told.append(f"{compared.share_flown:.0%} of the plan's line flown")
    maps = Maps(
        before=np.ravel(mission.sight.theta),
        pod=debrief.pod,
        after=debrief.after.ravel(),
        missed=None if compared is None else compared.missed,
    )
    flown = [piece for each in debrief.tracks for piece in each.pieces]
    planned = [] if compared is None else list(compared.lines)
    return draw_debrief(mission.problem.grid, maps, flown, planned, mission.name, ", ".join(told))
