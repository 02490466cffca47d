"""`sooner simulate`."""

from __future__ import annotations

import io
import json
import sys
import tempfile
import time
from collections.abc import Generator, Iterable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any, TypeVar

from sooner.cli.exits import DONE, INTERRUPTED, say, uninterrupted
from sooner.errors import DataFormatError, Fault
from sooner.io import Folder
from sooner.missions.over_waypoints import StreetMission, is_over_waypoints, read_street_mission

__all__ = ["simulate"]

MOST_TRIALS = 1_000_000
TELL_S = 5.0
MOST_TOLD = 10  # targets

T = TypeVar("T")


@dataclass(frozen=True)
class Asked:
    """What the command line says of the flights."""

    trials: int
    seed: int
    workers: int
    strategy: str | None
    planner: str | None
    seconds: float | None
    replan: float | None
    plan: Path | None
    animate: bool

    @property
    def seeds(self) -> range:
        """One for each trial."""
        return range(self.seed, self.seed + self.trials)


def simulate(
    mission_file: Path, asked: tuple[Any, ...], out: Path | None, as_json: bool, quiet: bool, force: bool
) -> int:
    """Fly, write, tell; answers the exit status."""
    wishes = Asked(*asked)
    if wishes.trials > MOST_TRIALS:
        raise DataFormatError(Fault("--trials", "", f"{wishes.trials} came", f"expected at most {MOST_TRIALS:,}"))
    folder = Folder(out or mission_file.parent / f"{mission_file.stem}-simulation", force)
    if is_over_waypoints(mission_file):
        _refuse("--planner", wishes.planner, "--strategy")
        _refuse("--seconds", wishes.seconds, "nothing: budget.replan_s says how often a team plans")
        _refuse("--replan", wishes.replan, "nothing: budget.replan_s says how often a team plans")
        _refuse("--plan", None if wishes.plan is None else str(wishes.plan), "nothing: a team plans while it flies")
        return _streets(read_street_mission(mission_file), wishes, folder, as_json, quiet)
    _refuse("--strategy", wishes.strategy, '--planner, or searcher.moves = "waypoints"')
    from sooner.cli.simulate_plan import simulate_plan

    return simulate_plan(mission_file, wishes, folder, as_json, quiet)


def _refuse(option: str, came: Any, instead: str) -> None:
    if came is not None:
        raise DataFormatError(Fault(option, "", f"{came!r} came, which these moves do not know", f"expected {instead}"))


def _streets(mission: StreetMission, asked: Asked, folder: Folder, as_json: bool, quiet: bool) -> int:
    from sooner.missions.street_trials import COLUMNS, StreetTrials, episode_of, fly_streets, strategy_named
    from sooner.simulation.episodes import animation_of, picture_of, save_episode

    name, strategy = strategy_named(asked.strategy)
    folder.check("trials.csv", "simulation.json", *episode_files(asked))
    if not quiet:
        say(f"flying {asked.trials:,} times by {name}")
    flown, status = gathered(fly_streets(mission, strategy, asked.seeds, asked.workers), asked.trials, quiet)
    trials = StreetTrials(mission, name, flown)
    result = trials.result() | {"attribution": mission.attribution, "interrupted": status != DONE}
    result["files"] = str(folder.path)
    with uninterrupted():
        episode = episode_of(mission, strategy, asked.seed)
        files = {
            "trials.csv": csv_of(COLUMNS, (trial.row() for trial in flown)),
            "simulation.json": (json.dumps(result, allow_nan=False) + "\n").encode(),
            "episode.npz": _bytes_of(episode, save_episode),
            "episode.png": picture_of(episode),
        }
        if asked.animate:
            files["episode.gif"] = animation_of(episode)
        folder.write(files)
    if as_json:
        print(json.dumps(result, allow_nan=False))
    else:
        _tell(trials, folder, asked.animate)
    tell_end(status, len(flown), asked.trials)
    return status


def _tell(trials: Any, folder: Folder, animated: bool) -> None:
    """What the trials say, with standard errors."""
    mission, means = trials.mission, trials.means()
    scene = mission.scene
    count = len(trials.trials)
    print(
        f"{mission.name}: {len(scene.agents)} drones, {scene.seconds} s, flown {count:,} "
        f"time{'s' if count > 1 else ''} by {trials.strategy}"
    )
    if trials.n_targets:
        print(f"  E                                   {means['e'].told(4)}")
        print(f"    of it for targets                 {means['e_targets'].told(4)}")
    print(f"    of it for streets                 {means['e_nodes'].told(4)}")
    print(f"  streets detected by the end         {means['nodes_detected'].told(4)}")
    if trials.n_targets:
        print(f"  targets detected by the end         {means['targets_detected'].told(4)}")
        print(f"  these after                         {means['detected_after_s'].told(1, ' s')}")
    if trials.n_targets > 1:
        _tell_each(trials)
    print(f"  false detections of a target        {means['false_detections'].told(4)} a flight")
    print(f"  false detections of streets         {means['false_nodes'].told(4)} a flight")
    if mission.attribution:
        print(f"map      {mission.attribution}")
    for name in ("trials.csv", "episode.npz"):
        print(f"{name.split('.')[0]:8} {folder.path / name}")
    print(f"picture  {folder.path / 'episode.png'}{', episode.gif' if animated else ''}")


def episode_files(asked: Asked) -> list[str]:
    """What is written of the first flight."""
    return ["episode.npz", "episode.png", *(["episode.gif"] if asked.animate else [])]


def gathered(trials: Iterator[T], count: int, quiet: bool) -> tuple[tuple[T, ...], int]:
    """The trials that come, and the exit status: Ctrl-C ends them, and those that have been flown are kept.

    Raises
    ------
    KeyboardInterrupt        where none has been flown
    """
    flown: list[T] = []
    try:
        for trial in told(trials, count, quiet):
            flown.append(trial)
    except KeyboardInterrupt:
        if not flown:
            raise
        return tuple(flown), INTERRUPTED
    finally:
        if isinstance(trials, Generator):
            with uninterrupted():
                trials.close()
    return tuple(flown), DONE


def tell_end(status: int, flown: int, count: int) -> None:
    """How many trials there are, where they are not all."""
    if status == INTERRUPTED:
        say(f"sooner: interrupted; {flown:,} of {count:,} flights are written")


def _tell_each(trials: Any) -> None:
    """What the trials say of several targets."""
    means = trials.means()
    for number, (share, after) in enumerate(trials.by_target()[:MOST_TOLD], 1):
        print(f"    target {number:<4} {'':21} {share.told(4)}, after {after.told(1, ' s')}")
    print(f"  all of them by the end              {means['all_targets_detected'].told(4)}")
    print(f"  the last of them, if all, after     {means['all_detected_after_s'].told(1, ' s')}")
    print(f"  repeated detections of a target     {means['repeated_detections'].told(4)} a flight")


def told(trials: Iterable[T], count: int, quiet: bool) -> Iterator[T]:
    """The trials as they come, and now and then on stderr how many have come."""
    last = time.perf_counter()
    for number, trial in enumerate(trials, 1):
        yield trial
        if not quiet and time.perf_counter() - last > TELL_S and number < count:
            last = time.perf_counter()
            print(f"{number:,} of {count:,} flown", file=sys.stderr, flush=True)


def csv_of(columns: Iterable[str], rows: Iterable[list[str]]) -> bytes:
    """A table as CSV."""
    text = io.StringIO()
    for row in ([*columns], *rows):
        text.write(",".join(row) + "\n")
    return text.getvalue().encode()


def _bytes_of(episode: Any, save: Any) -> bytes:
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "episode.npz"
        save(episode, path)
        return path.read_bytes()
