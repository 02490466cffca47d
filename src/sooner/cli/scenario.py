"""`sooner scenario`."""

from __future__ import annotations

from pathlib import Path

from sooner.cli.exits import DONE
from sooner.errors import DataFormatError, Fault
from sooner.io import Folder
from sooner.scenarios import SCENARIOS, make_scenario

__all__ = ["scenario"]


def scenario(name: str | None, out: Path | None, seed: int | None, force: bool) -> int:
    """Write a scenario, or list them."""
    if name is None:
        width = max(map(len, SCENARIOS))
        for known, entry in SCENARIOS.items():
            print(f"{known:{width}}  {entry.about}")
        return DONE
    if name not in SCENARIOS:
        raise DataFormatError(Fault("scenario", "", f"{name!r} came", f"expected one of {', '.join(SCENARIOS)}"))
    folder = Folder(out or Path(name), force)
    folder.write(make_scenario(name, seed).files())
    print(f"mission  {folder.path / 'mission.toml'}")
    return DONE
