"""Every strategy by name, as files call them."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict, fields, is_dataclass
from importlib import import_module
from typing import Any

from sooner.errors import InvalidProblemError
from sooner.simulation.strategies.strategy import Strategy

__all__ = ["STRATEGIES", "make_strategy", "settings_of"]

STRATEGIES: dict[str, tuple[str, Mapping[str, Any]]] = {
    "random": ("sooner.simulation.strategies.random_waypoints:RandomWaypoints", {}),
    "lawnmower": ("sooner.simulation.strategies.lawnmower:Lawnmower", {}),
    "tuned_lawnmower": (
        "sooner.simulation.strategies.lawnmower:Lawnmower",
        {"reach": 1.0, "capture": 0.5, "inset": 0.5},
    ),
    "information": ("sooner.simulation.strategies.information:Information", {}),
    "swept_information": ("sooner.simulation.strategies.information:Information", {"utility": "swept"}),
    "rollouts": ("sooner.simulation.strategies.rollouts:Rollouts", {}),
    "joint": ("sooner.simulation.strategies.joint:Joint", {}),
}
"""Where the class of each lives, "module:Class", and the settings that make the variant."""


def make_strategy(name: str, **settings: Any) -> Strategy:
    """The strategy of a name, with its own settings and then yours.

    Raises
    ------
    InvalidProblemError      if there is no such strategy or setting

    Examples
    --------
    >>> make_strategy("lawnmower", reach=1.0)
    Lawnmower(reach=1.0, capture=0.1, inset=0.125, afterwards='hover')
    """
    if name not in STRATEGIES:
        raise InvalidProblemError(f"strategy {name!r} came; expected one of {', '.join(sorted(STRATEGIES))}")
    path, own = STRATEGIES[name]
    module, kind = path.split(":")
    maker = getattr(import_module(module), kind)
    unknown = settings.keys() - {each.name for each in fields(maker)}
    if unknown:
        raise InvalidProblemError(f"setting {min(unknown)!r} came; the strategy {name!r} has none of that name")
    try:
        strategy: Strategy = maker(**{**own, **settings})
    except InvalidProblemError:
        raise
    except (TypeError, ValueError) as error:
        raise InvalidProblemError(f"settings came of which the strategy {name!r} can make nothing: {error}") from None
    return strategy


def settings_of(strategy: Strategy) -> tuple[str, dict[str, Any]]:
    """A name that `make_strategy` knows, and all settings; the class's own name for one that is not in the list.

    >>> from sooner.simulation.strategies import TUNED_LAWNMOWER
    >>> settings_of(TUNED_LAWNMOWER)
    ('lawnmower', {'reach': 1.0, 'capture': 0.5, 'inset': 0.5, 'afterwards': 'hover'})
    """
    kind = type(strategy)
    path = f"{kind.__module__}:{kind.__qualname__}"
    settings: dict[str, Any] = asdict(strategy) if is_dataclass(strategy) else {}
    return next((name for name, (known, _) in STRATEGIES.items() if known == path), kind.__qualname__), settings
