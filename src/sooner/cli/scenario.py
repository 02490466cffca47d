"""`sooner scenario`."""

from __future__ import annotations

from pathlib import Path

from sooner.cli.exits import DONE
from sooner.errors import DataFormatError, Fault
from sooner.io import Folder
from sooner.scenarios import (
    AREA_SCENARIOS,
    SCENARIOS,
    STREET_SCENARIOS,
    make_area_scenario,
    make_scenario,
    make_street_scenario,
)

__all__ = ["scenario"]


def scenario(name: str | None, out: Path | None, seed: int | None, force: bool) -> int:
    """Write a scenario, or list them."""
    about = {known: entry.about for known, entry in SCENARIOS.items()}
    about |= {known: entry.about for known, entry in AREA_SCENARIOS.items()}
    about |= {known: entry.about for known, entry in STREET_SCENARIOS.items()}
    if name is None:
        width = max(map(len, about))
        for known, told in about.items():
            print(f"{known:{width}}  {told}")
        return DONE
    if name not in about:
        raise DataFormatError(Fault("scenario", "", f"{name!r} came", f"expected one of {', '.join(about)}"))
    folder = Folder(out or Path(name), force)
    if name in SCENARIOS:
        files = make_scenario(name, seed).files()
    elif name in AREA_SCENARIOS:
        files = make_area_scenario(name, seed).files()
    else:
        files = make_street_scenario(name, seed).files()
    folder.write(files)
    print(f"mission  {folder.path / 'mission.toml'}")
    return DONE
