"""Gains of looks over evidence: bits of information, and expected detections."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from sooner.belief import Belief, BetaGrid, EvidenceGrid, beta_information, information
from sooner.errors import InvalidProblemError
from sooner.problem.gains import Gains
from sooner.sensors import BinarySensor

__all__ = ["evidence_detection_gains", "glimpse_information_gains", "information_gains"]

LOOKS = 64  # columns kept; with the paper's sensor the 65th look at theta = 0.5 would add 3e-11 bits


def information_gains(
    evidence: EvidenceGrid | BetaGrid, sensor: BinarySensor | None = None, looks: int = LOOKS
) -> Gains:
    """Gains of information: bits that the k-th look at a cell is expected to add, from the evidence so far.

    gain(i, k) = I(k + 1) - I(k), with I of `belief.information`                      [Kuhlman2017, eq. (3), (15)]

    Parameters
    ----------
    evidence : EvidenceGrid    or BetaGrid, (H, W)
    sensor : BinarySensor      of the looks; a BetaGrid takes none, as its rates are those of the hits themselves
    looks : int                L, columns of the table. Later looks count nothing: the gains, and the value of a plan
                               that looks more often, are lower limits, and so is a bound computed from them

    Returns
    -------
    Gains                      table (N, L), ratio 0

    Raises
    ------
    InvalidProblemError        if an EvidenceGrid comes without a sensor, or a BetaGrid with one

    Examples
    --------
    >>> gains = information_gains(EvidenceGrid([[0.5, 0.97]]), BinarySensor(0.85, 0.15))
    >>> gains.of(np.array([0, 0, 1]), np.array([0, 1, 0])).round(3)
    array([0.39 , 0.209, 0.05 ])
    """
    if isinstance(evidence, BetaGrid):
        if sensor is not None:
            raise InvalidProblemError("a sensor came with a BetaGrid, whose cells hold the rate of hits itself")
        return _closed(beta_information(evidence.alpha, evidence.beta, looks))
    if sensor is None:
        raise InvalidProblemError("no sensor came with the evidence; expected a BinarySensor")
    return _closed(information(evidence.theta, looks, sensor.detect, sensor.false_alarm))


def glimpse_information_gains(belief: Belief, glimpse: ArrayLike, looks: int = LOOKS) -> Gains:
    """Gains of information over a POC map: each cell holds the person or not, and a look never errs when it hits.

    gain(i, k) = I(k + 1) - I(k), theta = POC, p_d = glimpse of the cell, p_f = 0         [Kuhlman2017, eq. (15)]

    Parameters
    ----------
    belief : Belief            where the person may be, (H, W)
    glimpse : (H, W) or float  P(detect in one look | there), in [0, 1]
    looks : int                columns of the table; later looks count nothing

    Raises
    ------
    InvalidProblemError        if shapes differ or a glimpse lies outside [0, 1]

    Notes
    -----
    Cells are taken one by one. One person is in one cell at most, so that what looks teach of the whole map is no
    more than this sum: looks are independent given where the person is, and their joint entropy is at most the sum
    of their entropies.

    Examples
    --------
    >>> glimpse_information_gains(Belief.from_weights([[1.0, 1.0]]), 1.0, looks=2).table
    array([[1., 0.],
           [1., 0.]])
    """
    g = np.asarray(glimpse, np.float64)
    if g.ndim and g.shape != belief.shape:
        raise InvalidProblemError(f"glimpse of shape {g.shape} came; the map has {belief.shape}")
    return _closed(information(np.minimum(belief.poc, 1.0), looks, g))


def evidence_detection_gains(evidence: EvidenceGrid, sensor: BinarySensor) -> Gains:
    """Gains of detection over evidence: targets expected to be detected first by the k-th look at their cell.

    gain(i, k) = theta p_d (1 - p_d)^k

    Exact for any number of looks. The total is a number of targets, not a probability; false alarms do not count.

    Examples
    --------
    >>> evidence_detection_gains(EvidenceGrid([[0.5, 1.0]]), BinarySensor(0.8, 0.1)).first
    array([0.4, 0.8])
    """
    return Gains.independent(evidence.theta, np.full(evidence.theta.size, sensor.detect))


def _closed(table: np.ndarray) -> Gains:
    return Gains(table, np.zeros(len(table)))
