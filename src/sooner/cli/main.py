"""`sooner`: what can be asked of it on a command line. Heavy libraries are imported by the command that needs them."""

from __future__ import annotations

import sys
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Annotated, Any

import typer

from sooner import __version__
from sooner.cli.exits import ending

__all__ = ["app", "main", "run"]

app = typer.Typer(
    name="sooner",
    help="Plans where drones look, so that a lost person is found sooner.",
    no_args_is_help=True,
    add_completion=False,
    pretty_exceptions_enable=False,
    rich_markup_mode=None,
)

MissionFile = Annotated[Path, typer.Argument(metavar="MISSION.toml", help="The mission file.")]
Json = Annotated[bool, typer.Option("--json", help="Print exactly one JSON object.")]
Quiet = Annotated[bool, typer.Option("--quiet", "-q", help="No progress.")]
Force = Annotated[bool, typer.Option("--force", help="Replace files even where sooner did not write them.")]
Seed = Annotated[int, typer.Option(help="Of the random numbers; the same seed gives the same.", min=0)]
Workers = Annotated[int | None, typer.Option(help="Processes that work at once.", min=1)]


def main() -> None:
    """The console script."""
    sys.exit(run(sys.argv[1:]))


def run(arguments: Sequence[str]) -> int:
    """Run the command line; answers the exit status."""
    return ending(lambda: _parsed(arguments))


def _parsed(arguments: Sequence[str]) -> int:
    try:
        status: Any = app(list(arguments), prog_name="sooner", standalone_mode=False)
    except typer.Exit as stop:
        return stop.exit_code
    except typer.Abort:
        raise KeyboardInterrupt from None
    except Exception as error:
        show: Callable[[], None] | None = getattr(error, "show", None)
        if show is None:
            raise
        show()  # what typer says of a wrong command line
        return int(getattr(error, "exit_code", 2))
    return status if isinstance(status, int) else 0


def _tell_version(asked: bool) -> None:
    if asked:
        print(f"sooner {__version__}")
        raise typer.Exit


@app.callback()
def sooner(
    version: Annotated[
        bool, typer.Option("--version", help="Print the version.", callback=_tell_version, is_eager=True)
    ] = False,
) -> None:
    """Plans where drones look, so that a lost person is found sooner."""


@app.command()
def plan(
    mission: MissionFile,
    planner: Annotated[str | None, typer.Option(help="A name that `sooner planners` lists.")] = None,
    seconds: Annotated[float, typer.Option(help="Planning time.")] = 10.0,
    seed: Seed = 0,
    out: Annotated[Path | None, typer.Option(help="Folder for plan, picture and result.")] = None,
    file_format: Annotated[str, typer.Option("--format", help="Of the plan file: csv.")] = "csv",
    json: Json = False,
    quiet: Quiet = False,
    force: Force = False,
) -> int:
    """Plan a mission: a flight, its value, a bound that no flight passes, and a picture.

    Writes plan.csv, plan.json and plan.png to --out (left out: a folder MISSION-plan beside the mission file).
    Ctrl-C ends the planning; the best plan so far is written.
    """
    from sooner.cli.plan import plan as work

    return work(mission, planner, seconds, seed, out, file_format, json, quiet, force)


@app.command()
def evaluate(
    mission: MissionFile,
    plan: Annotated[Path, typer.Argument(metavar="PLAN", help="searcher,step,row,col lines, or bare row,col.")],
    json: Json = False,
) -> int:
    """Score any plan, ours or not, by the judge; an illegal plan is refused with the reason."""
    from sooner.cli.evaluate import evaluate as work

    return work(mission, plan, json)


@app.command()
def planners(json: Json = False) -> int:
    """List the planners, with when to choose which."""
    from sooner.cli.lists import planners as work

    return work(json)


@app.command()
def scenario(
    name: Annotated[str | None, typer.Argument(help="One of the list; left out: print the list.")] = None,
    out: Annotated[Path | None, typer.Option(help="Folder for the mission and its rasters.")] = None,
    seed: Annotated[int | None, typer.Option(help="Another search of the same kind.", min=0)] = None,
    force: Force = False,
) -> int:
    """Write a ready-made mission with its rasters."""
    from sooner.cli.scenario import scenario as work

    return work(name, out, seed, force)


@app.command()
def warmup(quiet: Quiet = False) -> int:
    """Compile everything ahead, so that the first plan does not wait for it."""
    from sooner.cli.warmup import warmup as work

    return work(quiet)


@app.command()
def cite(
    name: Annotated[str | None, typer.Argument(help="A planner, or a key such as Lin2014; left out: sooner.")] = None,
) -> int:
    """Print what to cite for a planner, as BibTeX."""
    from sooner.cli.lists import cite as work

    return work(name)


@app.command()
def reproduce(
    paper: Annotated[str, typer.Argument(help="kuhlman2017, lin2014 or wolek2020.")],
    data: Annotated[Path | None, typer.Option(help="Folder of the papers' maps; left out: $SOONER_DATA.")] = None,
    trials: Annotated[int | None, typer.Option(help="Seeds of each case.", min=1)] = None,
    workers: Workers = None,
    out: Annotated[Path | None, typer.Option(help="Folder for reproduced.csv.")] = None,
) -> int:
    """Run a paper's study again and write its tables."""
    from sooner.cli.reproduce import reproduce as work

    return work(paper, data, trials, workers, out)
