"""`sooner planners` and `sooner cite`."""

from __future__ import annotations

import json

from sooner.bibliography import BIBLIOGRAPHY, bibtex
from sooner.cli.exits import DONE
from sooner.errors import DataFormatError, Fault
from sooner.planners.registry import DEFAULT, PLANNERS

__all__ = ["cite", "planners"]


def planners(as_json: bool) -> int:
    """The list of planners, with when to choose which."""
    if as_json:
        told = [
            {
                "name": name,
                "when": entry.when,
                "moves": list(entry.moves),
                "cites": list(entry.cites),
                "default": name == DEFAULT,
            }
            for name, entry in PLANNERS.items()
        ]
        print(json.dumps({"planners": told}))
        return DONE
    width = max(map(len, PLANNERS))
    for name, entry in PLANNERS.items():
        print(f"{name:{width}}  {entry.when}")
    return DONE


def cite(name: str | None) -> int:
    """BibTeX for a planner or a key of the bibliography."""
    if name is None:
        keys: tuple[str, ...] = ("sooner",)
    elif name in PLANNERS:
        keys = ("sooner", *PLANNERS[name].cites)
    elif name in BIBLIOGRAPHY:
        keys = (name,)
    else:
        names = ", ".join([*PLANNERS, *BIBLIOGRAPHY])
        raise DataFormatError(Fault("cite", "", f"{name!r} came", f"expected a planner or a key: {names}"))
    print("\n\n".join(bibtex(key) for key in keys))
    return DONE
