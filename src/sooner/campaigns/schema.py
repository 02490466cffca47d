"""What a study file may hold, key by key: `docs/study_file.md` is written from here."""

from __future__ import annotations

from math import isfinite
from pathlib import Path
from typing import Annotated, Any, Literal

from pydantic import BaseModel, BeforeValidator, ConfigDict, Field
from pydantic_core import PydanticCustomError

__all__ = ["MOST_TRIALS", "OURS", "OfCampaign", "OfTrial", "Rule", "StudyFile", "Table"]

FLIGHT = "sooner.experiments.flight:fly"
MOST_TRIALS = 100_000_000  # of each case


def _number(came: Any) -> Any:
    """Finite, and whole where it is: 300 and 300.0 are one budget."""
    if isinstance(came, bool) or not isinstance(came, (int, float)) or not isfinite(came):
        raise PydanticCustomError("number", "a finite number")
    return int(came) if came == int(came) else came


def _pattern(came: Any) -> Any:
    if isinstance(came, str) and (not came or Path(came).is_absolute()):
        raise PydanticCustomError("pattern", "a name or pattern below the folder of the data")
    return came


Number = Annotated[int | float, BeforeValidator(_number)]
Positive = Annotated[float, Field(gt=0, allow_inf_nan=False)]
AtLeast0 = Annotated[float, Field(ge=0, allow_inf_nan=False)]
Name = Annotated[str, Field(min_length=1)]
Pattern = Annotated[str, BeforeValidator(_pattern)]


class _Settings(BaseModel):
    model_config = ConfigDict(extra="forbid", frozen=True, strict=True)


class OfTrial(_Settings):
    """`[limits]`: what one trial may take; past it the trial is ended, flown once more, then set aside."""

    seconds: Positive = Field(default=3600.0, description="on the clock")
    memory_mb: Positive | None = Field(
        default=None, description="resident; left out: nine tenths of the machine's, shared by the workers"
    )


class OfCampaign(_Settings):
    """`[planners]`: name = { ... }; all but these keys is what the trial is told."""

    needs: Name | None = Field(
        default=None, description="a Python package; where it is missing this planner is left out"
    )
    seeds_factor: Annotated[int, Field(ge=1, le=1_000_000)] = Field(
        default=1, description="so many times as many seeds as the others"
    )
    most_trials: Annotated[int, Field(ge=1)] | None = Field(default=None, description="no more seeds than this")


class Table(_Settings):
    """`[[tables]]`: instances x planners x budgets, each a case; tables decide what is flown, left out: everything.

    `row` and `column` name the cells of the table; cells of one name are pooled.
    """

    name: Name = Field(description="of the table; what `sooner reproduce --only` asks for (required)")
    times: Name | None = Field(
        default=None, description="name of a second table, of seconds: `timed_trials` seeds are flown again, alone"
    )
    instances: list[str] = Field(default=["*"], description="names; `*` and `?` allowed")
    planners: list[str] = Field(default=["*"], description="names; `*` and `?` allowed")
    budgets: list[Number] | None = Field(default=None, description="left out: those of the study")
    row: str = Field(default="{planner}", description="made of `{instance}`, `{planner}`, `{budget}`, `{measure}`")
    column: str = Field(
        default="{instance} {budget}", description="made of `{instance}`, `{planner}`, `{budget}`, `{measure}`"
    )
    measure: Name | None = Field(default=None, description="which number of a trial; left out: that of the study")
    measures: dict[Name, Name] = Field(
        default={}, description="several of them: what `{measure}` calls each = which number of a trial"
    )
    statistic: Literal["mean", "median", "deviation", "rate"] = Field(
        default="mean", description="over the seeds; `rate` of a measure that is yes or no"
    )
    versus: Name | None = Field(
        default=None, description="a planner; the cells are then the others' differences from it, seed by seed"
    )


class Rule(_Settings):
    """`[[rules]]`: how numbers are judged against published ones; later rules overrule earlier ones, key by key."""

    table: str = Field(default="*", description="which tables; `*` and `?` allowed")
    row: str = Field(default="*", description="which rows")
    column: str = Field(default="*", description="which columns")
    exact: AtLeast0 = Field(default=0.02, description="the largest difference that is still the same")
    near: AtLeast0 = Field(default=2.5, description="the largest difference that is still near")
    sense: Literal["same", "limit", "time"] = Field(
        default="same", description="`same`: both ways count; `limit`: ours must not be more; `time`: less is faster"
    )
    reason: str = Field(default="", description="why ours differs, or cannot be measured")


class StudyFile(_Settings):
    """At the top: what is flown, how often, and what is told of it."""

    title: Name = Field(description="of the report; the ledger knows the study by it (required)")
    trials: int = Field(default=10, ge=1, le=MOST_TRIALS, description="seeds 0, 1, ... of each case")
    budgets: list[Number] = Field(default=[], description="of each instance; left out: its own")
    measure: Name = Field(default="value", description="the number of a trial that tables and the picture show")
    timed_trials: int = Field(default=3, ge=1, description="seeds that are flown again where a table has `times`")
    trial: Annotated[str, Field(pattern=r"^\w+(\.\w+)*:\w+$")] = Field(
        default=FLIGHT, description="`module:function` that flies one trial"
    )
    data: str = Field(default="", description="folder of maps below `--data` or `SOONER_DATA`")
    data_files: list[Pattern] = Field(
        default=[], description="patterns of files there; results on other files than these are not mixed"
    )
    limits: OfTrial = OfTrial()
    instances: dict[str, dict[str, Any]] = Field(min_length=1)
    planners: dict[str, dict[str, Any]] = Field(min_length=1)
    tables: list[Table] = []
    rules: list[Rule] = []
    paper: dict[str, Any] = {}


OURS = frozenset(OfCampaign.model_fields)
