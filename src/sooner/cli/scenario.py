"""`sooner scenario`."""

from __future__ import annotations

from pathlib import Path

from sooner.cli.exits import DONE
from sooner.errors import DataFormatError, Fault
from sooner.io import Folder
from sooner.scenarios import SCENARIOS, STREET_SCENARIOS, make_scenario, make_street_scenario

__all__ = ["scenario"]


def scenario(name: str | None, out: Path | None, seed: int | None, force: bool) -> int:
    """Write a scenario, or list them."""
    about = {known: entry.about for known, entry in SCENARIOS.items()}
    about |= {known: entry.about for known, entry in STREET_SCENARIOS.items()}
    if name is None:
        width = max(map(len, about))
        for known, told in about.items():
            print(f"{known:{width}}  {told}")
        return DONE
    if name not in about:
        raise DataFormatError(Fault("scenario", "", f"{name!r} came", f"expected one of {', '.join(about)}"))
    folder = Folder(out or Path(name), force)
    make = make_scenario if name in SCENARIOS else make_street_scenario
    folder.write(make(name, seed).files())
    print(f"mission  {folder.path / 'mission.toml'}")
    return DONE
