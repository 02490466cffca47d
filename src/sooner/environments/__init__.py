"""A search as an environment of Gymnasium and of PettingZoo, and policies as strategies: for those who train them.

`import sooner.environments` makes `gymnasium.make("sooner/UnknownCity-v0")` work, where Gymnasium is installed. What
flies a trained policy needs neither: `PolicyStrategy` is a strategy like any other.
"""

from __future__ import annotations

from importlib import import_module
from importlib.util import find_spec
from typing import TYPE_CHECKING, Any

from sooner.environments.observation import Observation, observed
from sooner.environments.policy import Policy, PolicyStrategy, StrategyPolicy
from sooner.environments.scenes import generated_scenes

if TYPE_CHECKING:
    from sooner.environments.search_env import SearchEnv
    from sooner.environments.search_parallel_env import SearchParallelEnv

__all__ = [
    "Observation",
    "Policy",
    "PolicyStrategy",
    "SearchEnv",
    "SearchParallelEnv",
    "StrategyPolicy",
    "generated_scenes",
    "observed",
]

_OF_THE_EXTRA = {
    "SearchEnv": "sooner.environments.search_env",
    "SearchParallelEnv": "sooner.environments.search_parallel_env",
}


def __getattr__(name: str) -> Any:
    if name in _OF_THE_EXTRA:
        return getattr(import_module(_OF_THE_EXTRA[name]), name)
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")


def _register() -> None:
    import gymnasium

    gymnasium.register("sooner/UnknownCity-v0", "sooner.environments.search_env:SearchEnv")


if find_spec("gymnasium") is not None:
    _register()
