"""Sight: what is known of where targets are, what a look sees of them, and what that pays."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from sooner.belief import Belief, BetaGrid, EvidenceGrid, beta_information, information
from sooner.belief.evidence import binary_entropy
from sooner.missions.faults import Faults
from sooner.missions.layers import Layers
from sooner.missions.settings import Settings
from sooner.problem import Gains, Objective, detection_gains
from sooner.problem.gains import effort_gains
from sooner.sensors import glimpse_from_difficulty
from sooner.simulation.answers import AnswerModel

__all__ = ["LOOKS", "Sight"]

Floats = NDArray[np.float64]

LOOKS = 64  # looks at a cell whose information is worked out; later ones count nothing
CHUNK = 1 << 14  # cells whose gains are in memory at once


@dataclass(frozen=True, eq=False)
class Sight:
    """Where targets may be, one look at them, and what is good: together they say what looks at cells pay.

    Parameters
    ----------
    known : Belief             where the one person may be; or EvidenceGrid or BetaGrid, of each cell by itself
    detect : float or (H, W)   P(a look says yes | a target is there)
    objective : Objective
    false_alarm : float        P(a look says yes | none is there)
    correlation : float        of two looks at one place
    by_effort : bool           looks are worth units of effort, as along legs, and `detect` is in those units already
    """

    known: Belief | EvidenceGrid | BetaGrid
    detect: float | Floats
    objective: Objective = Objective()
    false_alarm: float = 0.0
    correlation: float = 0.0
    by_effort: bool = False

    @property
    def unit(self) -> str:
        """What values count: "probability" of having found the person, "bits", or "targets" expected to be found."""
        if self.objective.kind == "information":
            return "bits"
        return "probability" if isinstance(self.known, Belief) else "targets"

    @property
    def glimpse(self) -> Floats:
        """(H, W) float: P(detect in one look | there)."""
        return np.array(np.broadcast_to(self.detect, self.theta.shape))

    @property
    def theta(self) -> Floats:
        """(H, W) float: P(a target is in this cell), or P(a look at it would say yes) where targets come and go."""
        if isinstance(self.known, BetaGrid):
            return self.known.mean
        return np.minimum(self.known.poc, 1.0) if isinstance(self.known, Belief) else self.known.theta

    @property
    def answers(self) -> AnswerModel:
        """How looks answer, and what that teaches."""
        return AnswerModel(self.known, self.glimpse.ravel(), self.false_alarm, self.correlation)

    @property
    def there(self) -> Floats:
        """(H, W) float: all that there is to find or to learn; of a Beta law, as much as all our looks teach."""
        if self.objective.kind == "detection":
            return self.theta
        if isinstance(self.known, BetaGrid):
            return np.asarray(self.rows(np.arange(self.theta.size)).sum(axis=1).reshape(self.theta.shape))
        return binary_entropy(self.theta)

    @property
    def first_look(self) -> Floats:
        """(N,) float: what the first look at each cell pays."""
        if self.objective.kind == "detection":
            return self.gains.first
        cells = np.arange(self.theta.size)
        parts = [self.rows(cells[first : first + CHUNK])[:, 0] for first in range(0, cells.size, CHUNK)]
        return np.concatenate(parts)

    @cached_property
    def gains(self) -> Gains:
        """What the k-th look at each cell pays, (N, L)."""
        if self.by_effort:
            return effort_gains(self.theta)
        if self.objective.kind == "information":
            table = self.rows(np.arange(self.theta.size))
            return Gains(table, np.zeros(len(table)))
        if isinstance(self.known, Belief):
            return detection_gains(self.known, self.detect, self.correlation)
        return Gains.independent(self.theta, np.broadcast_to(self.detect, self.theta.shape))

    def rows(self, cells: NDArray[np.int64]) -> Floats:
        """(n, L) float: what the first L looks at each of these cells pay."""
        if self.objective.kind == "detection":
            return self.gains.of(cells[:, None], np.arange(max(LOOKS, self.gains.table.shape[1])))
        if isinstance(self.known, BetaGrid):
            alpha, beta = np.ravel(self.known.alpha)[cells], np.ravel(self.known.beta)[cells]
            return beta_information(alpha, beta, LOOKS)
        detect = self.detect if isinstance(self.detect, float) else np.ravel(self.detect)[cells]
        return information(np.ravel(self.theta)[cells], LOOKS, detect, self.false_alarm)

    def worth(self, looks: NDArray[Any]) -> Floats:
        """(N,) float: what so many looks at each cell, or so much effort on it, pay, cell by cell."""
        if self.by_effort:
            return self.gains.total(np.arange(self.theta.size), looks)
        paid = np.zeros(self.theta.size)
        seen = np.flatnonzero(looks)
        for first in range(0, len(seen), CHUNK):
            cells = seen[first : first + CHUNK]
            sums = np.cumsum(self.rows(cells), axis=1)
            paid[cells] = sums[np.arange(len(cells)), np.minimum(looks[cells], sums.shape[1]) - 1]
        return paid

    @classmethod
    def read(cls, faults: Faults, settings: Settings, layers: Layers) -> Sight | None:
        """What the file and its rasters say; None where that is not all right."""
        _check(faults, settings)
        known, detect = _known(faults, settings, layers), _detect(faults, settings, layers)
        if known is None or detect is None or faults.found:
            return None
        sensor, wish = settings.sensor, settings.objective
        target = wish.detection_target if wish.kind == "detection" else None
        alarms = sensor.false_alarm or 0.0
        return cls(known, detect, Objective(wish.kind, target), alarms, sensor.correlation, settings.over_legs)


def _known(faults: Faults, settings: Settings, layers: Layers) -> Belief | EvidenceGrid | BetaGrid | None:
    if layers.weights is not None:
        return Belief.from_weights(layers.weights, layers.outside)
    if layers.theta is None:
        return None
    if settings.sensor.model == "binary":
        return EvidenceGrid(layers.theta)
    if not ((layers.theta > 0) & (layers.theta < 1)).all():
        row, col = np.argwhere((layers.theta <= 0) | (layers.theta >= 1))[0]
        came = f'{layers.theta[row, col]:g} came at [{row}, {col}], and model = "beta"'
        faults.add("area.evidence", came, "expected means of a Beta law: above 0 and below 1")
        return None
    looks = settings.sensor.prior_looks
    return BetaGrid(looks * layers.theta, looks * (1.0 - layers.theta))


def _detect(faults: Faults, settings: Settings, layers: Layers) -> float | Floats | None:
    """P(a look says yes, if a target is there), whichever way the file gives it."""
    sensor = settings.sensor
    if isinstance(sensor.glimpse, float):
        if not 0.0 <= sensor.glimpse <= 1.0:
            expected = "expected a probability in [0, 1], or the name of a raster"
            faults.add("sensor.glimpse", f"{sensor.glimpse} came", expected)
            return None
        return sensor.glimpse
    if isinstance(sensor.glimpse, str) or layers.glimpse is not None:
        return layers.glimpse
    if sensor.difficulty is not None:
        return None if layers.difficulty is None else glimpse_from_difficulty(layers.difficulty)
    return 1.0 if sensor.detect is None else sensor.detect


def _check(faults: Faults, settings: Settings) -> None:
    """Which keys go together."""
    area, sensor, wish = settings.area, settings.sensor, settings.objective
    over_evidence = area.evidence is not None and area.poc is None
    given = [key for key in ("difficulty", "glimpse", "land_cover", "detect") if getattr(sensor, key) is not None]
    if len(given) > 1:
        faults.add("sensor", f"{' and '.join(given)} came", "expected one of them")
    if sensor.false_alarm is not None and sensor.detect is None and not faults.among("sensor.detect"):
        faults.add(
            "sensor.detect", "nothing came beside false_alarm", "expected P(a look says yes, if a target is there)"
        )
    elif sensor.detect is not None and sensor.detect <= (sensor.false_alarm or 0.0):
        came = f"{sensor.detect:g} came, and false_alarm = {sensor.false_alarm or 0.0:g}"
        faults.add(
            "sensor.detect", came, "expected more than false_alarm: such a look teaches nothing, or says yes for no"
        )
    if over_evidence and area.outside:
        came = f"{area.outside:g} came, and area.evidence"
        faults.add("area.outside", came, "expected it left out: evidence is of each cell by itself")
    if over_evidence and wish.detection_target is not None:
        came = f"{wish.detection_target:g} came, and area.evidence"
        faults.add("objective.detection_target", came, "expected it left out, or area.poc: evidence does not total one")
    if wish.kind == "information" and wish.detection_target is not None and not over_evidence:
        came = f'{wish.detection_target:g} came, and kind = "information"'
        faults.add("objective.detection_target", came, 'expected it left out, or kind = "detection"')
    if sensor.correlation and (over_evidence or wish.kind == "information"):
        came = f"{sensor.correlation:g} came"
        faults.add(
            "sensor.correlation", came, "expected it left out: only detection over area.poc knows correlated looks"
        )
    elif sensor.correlation and sensor.false_alarm:
        came = f"{sensor.correlation:g} came beside false_alarm"
        faults.add("sensor.correlation", came, "expected one of them: false alarms are of each look by itself")
    if sensor.model == "beta":
        _check_beta(faults, settings, given)


def _check_beta(faults: Faults, settings: Settings, given: list[str]) -> None:
    if settings.area.evidence is None:
        faults.add(
            "sensor.model", "'beta' came without area.evidence", "expected the mean of each cell's Beta law there"
        )
    if settings.objective.kind == "detection":
        expected = 'expected kind = "information": where targets come and go, a yes is no find'
        faults.add("objective.kind", "'detection' came, and sensor.model = \"beta\"", expected)
    for key in (*given, *(["false_alarm"] if settings.sensor.false_alarm is not None else [])):
        faults.add(
            f"sensor.{key}", 'it came, and model = "beta"', "expected it left out: the rate of hits is what is learnt"
        )
