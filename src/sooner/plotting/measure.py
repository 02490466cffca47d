"""What values count, in the words and colours of the pictures."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from sooner.plotting.layers import Layer, poc_layer, there_layer

__all__ = ["BITS", "PROBABILITY", "TARGETS", "Measure"]


@dataclass(frozen=True)
class Measure:
    """A kind of value.

    Parameters
    ----------
    curve : str               title of the curve
    factor : float            of values on the curve
    form : str                of a value in words, as `str.format` takes it with a number of decimals
    done, verb : str          what has been done by collecting it, and to do it
    left : str                title of what is left
    layer : callable          (values, peak) to the layer of what there is to collect
    """

    curve: str
    factor: float
    form: str
    done: str
    verb: str
    left: str
    layer: Callable[[NDArray[np.float64], float], Layer]

    def told(self, value: float) -> str:
        """A value in words.

        >>> PROBABILITY.told(0.25), BITS.told(1234.5)
        ('25.0%', '1,234.5 bits')
        """
        return self.form.format(value, 1 if abs(value) >= 100 else 3)


PROBABILITY = Measure(
    "Probability of having found the person, %", 100.0, "{:.1%}", "found", "find", "Still unseen afterwards", poc_layer
)
BITS = Measure("Learnt, bits", 1.0, "{:,.{}f} bits", "learnt", "learn", "Still to learn", there_layer)
TARGETS = Measure(
    "Targets found, as expected", 1.0, "{:,.{}f} targets", "found", "find", "Still unseen afterwards", there_layer
)
