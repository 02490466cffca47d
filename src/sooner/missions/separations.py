"""What a mission file says of how near drones in the air at once may come to each other."""

from __future__ import annotations

from typing import Annotated

from pydantic import BaseModel, ConfigDict, Field

__all__ = ["SeparationSettings"]

_Metres = Annotated[float, Field(gt=0, le=10_000, allow_inf_nan=False)]


class SeparationSettings(BaseModel):
    """`[separation]`: along legs, between drones in the air at once; left out: as if it stood there empty.

    Flights are kept apart where files are made of them: whoever would come nearer, in both ways at once, waits and
    takes off later.
    """

    model_config = ConfigDict(extra="forbid", frozen=True)

    horizontal_m: _Metres = Field(default=30.0, description="between two drones, unless they are apart in height")
    vertical_m: _Metres = Field(default=10.0, description="in height, unless they are apart on the map")
    wait_s: float | None = Field(
        default=None,
        ge=0,
        allow_inf_nan=False,
        description="the longest that a take-off may be put off for it; else the plan is refused. Left out: any time",
    )
