"""Colours and type, chosen to be told apart by everybody and to print well."""

from __future__ import annotations

from typing import Any

__all__ = [
    "BOUND",
    "END",
    "FLIGHT",
    "GLIMPSE",
    "GREY",
    "INK",
    "LOOKS",
    "NOWHERE",
    "PAPER",
    "POC",
    "ROCK",
    "START",
    "STYLE",
    "VALUE",
]

INK, GREY, PAPER = "#22262b", "#6b7280", "white"
POC = "Greys"  # darker: more likely
FLIGHT = "plasma"  # by time; even in lightness, safe for colour-blind eyes
GLIMPSE = "YlGnBu"
LOOKS = "Blues"
ROCK, NOWHERE = "#a8875f", "#f4f5f7"
START, END = "#0072b2", "#d55e00"  # after Okabe and Ito
VALUE, BOUND = "#0072b2", "#d55e00"

STYLE: dict[str, Any] = {
    "font.family": "DejaVu Sans",
    "text.parse_math": False,  # a name with a dollar sign is a name
    "axes.edgecolor": "#c4c9d0",
    "axes.linewidth": 0.8,
    "axes.labelcolor": INK,
    "text.color": INK,
    "xtick.color": GREY,
    "ytick.color": GREY,
}
