"""`sooner`: what can be asked of it on a command line. Heavy libraries are imported by the command that needs them."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import partial
from importlib import import_module
from pathlib import Path
from typing import Annotated, Any

import typer

from sooner import __version__
from sooner.cli.exits import ending

__all__ = ["app", "run"]

app = typer.Typer(
    name="sooner",
    help="Plans where drones look, so that a lost person is found sooner.",
    no_args_is_help=True,
    add_completion=False,
    pretty_exceptions_enable=False,
    rich_markup_mode=None,
)


def _folder(help: str) -> Any:
    """An option that names a folder."""

    def named(text: str) -> Path:
        if not text:
            raise typer.BadParameter("an empty name came; expected a folder, as . for this one")
        return Path(text)

    return typer.Option(metavar="PATH", parser=named, help=help)


MissionFile = Annotated[Path, typer.Argument(metavar="MISSION.toml", help="The mission file.")]
Json = Annotated[bool, typer.Option("--json", help="Print exactly one JSON object.")]
Quiet = Annotated[bool, typer.Option("--quiet", "-q", help="No progress.")]
Force = Annotated[bool, typer.Option("--force", help="Replace files even where sooner did not write them.")]
Seed = Annotated[
    int, typer.Option(help="Of the random numbers; how far a run gets in its time still depends on the machine.", min=0)
]
Workers = Annotated[int | None, typer.Option(help="Processes that work at once.", min=1)]


Work = Callable[[], int]
"""What a command line asks for, done once typer has let go of it: so that Ctrl-C is ours to answer."""


def run(arguments: Sequence[str]) -> int:
    """Run the command line; answers the exit status."""
    return ending(lambda: _asked(arguments)())


def _asked(arguments: Sequence[str]) -> Work:
    try:
        work: Any = app(list(arguments), prog_name="sooner", standalone_mode=False)
    except Exception as error:
        show: Callable[[], None] | None = getattr(error, "show", None)
        if show is None:
            raise
        show()  # what typer says of a wrong command line
        work = int(getattr(error, "exit_code", 2))
    return work if callable(work) else lambda: work if isinstance(work, int) else 0


def _run(module: str, name: str, *arguments: Any) -> int:
    status: int = getattr(import_module(f"sooner.cli.{module}"), name)(*arguments)
    return status


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
    out: Annotated[Path | None, _folder("Folder for plan, picture and result.")] = None,
    formats: Annotated[
        list[str] | None,
        typer.Option("--format", metavar="F[,F]", help="Files to fly beside plan.csv, as `sooner export` writes."),
    ] = None,
    json: Json = False,
    quiet: Quiet = False,
    force: Force = False,
) -> Work:
    """Plan a mission: a flight, its value, a bound that no flight passes, and a picture.

    Writes plan.csv, plan.json and plan.png to --out (left out: a folder MISSION-plan beside the mission file).
    Ctrl-C ends the planning; the best plan so far is written.
    """
    return partial(_run, "plan", "plan", mission, planner, seconds, seed, out, formats or [], json, quiet, force)


@app.command()
def evaluate(
    mission: MissionFile,
    plan: Annotated[
        Path,
        typer.Argument(
            metavar="PLAN",
            help="searcher,step,row,col lines, or bare row,col; "
            "over regions searcher,action,kind,region,row,col,time_s.",
        ),
    ],
    json: Json = False,
) -> Work:
    """Score any plan, ours or not, by the judge; an illegal plan is refused with the reason."""
    return partial(_run, "evaluate", "evaluate", mission, plan, json)


@app.command(name="export")
def export_plan(
    mission: MissionFile,
    plan: Annotated[Path, typer.Argument(metavar="PLAN.csv", help="What `sooner plan` wrote, or a plan of your own.")],
    formats: Annotated[
        list[str] | None,
        typer.Option(
            "--format",
            metavar="F[,F]",
            help="qgc (QGroundControl), waypoints (Mission Planner), dji (Pilot 2), kml, gpx, caltopo, "
            "cot (ATAK), geotiff (POC before and after, POD).",
        ),
    ] = None,
    out: Annotated[Path | None, _folder("Folder for the files; left out: the plan's.")] = None,
    autopilot: Annotated[
        str | None, typer.Option(help="For qgc: ardupilot or px4; left out: the vehicle file's, or ardupilot.")
    ] = None,
    dji: Annotated[
        str | None,
        typer.Option(
            help="For dji: m300, m350, m30, m30t, m3e, m3t, m3d or m3td; left out: the vehicle file's, or m30t."
        ),
    ] = None,
    json: Json = False,
    force: Force = False,
) -> Work:
    """Write a plan as files that aircraft fly and maps show; one for each drone where a file holds one flight.

    The mission needs a georeferenced raster. Drones fly searcher.altitude_m above where they take off, else as high
    as sensor.camera says, else 60 m. What a flight does beyond its plan is told, as the way home.
    """
    return partial(_run, "export", "export_plan", mission, plan, formats or [], out, autopilot, dji, json, force)


@app.command(name="report")
def report_plan(
    mission: MissionFile,
    plan: Annotated[Path, typer.Argument(metavar="PLAN.csv", help="What `sooner plan` wrote, or a plan of your own.")],
    out: Annotated[
        Path | None,
        typer.Option(metavar="FILE.html", help="The file to write; left out: report.html beside the plan."),
    ] = None,
    seconds: Annotated[
        float, typer.Option(help="For the bound, and for the search patterns that the plan is compared with.")
    ] = 10.0,
    json: Json = False,
    force: Force = False,
) -> Work:
    """Write a plan as one page for the command post and a sheet for each pilot, to read or to print.

    One HTML file that needs no network: map, CDP curve, what remains and where, assumptions, bound, along legs the
    classic patterns beside the plan; then for each flight its legs, times, reserve, and blanks to fill by hand.
    """
    return partial(_run, "report", "report_plan", mission, plan, out, seconds, json, force)


@app.command(name="upload")
def upload_plan(
    mission: MissionFile,
    plan: Annotated[Path, typer.Argument(metavar="PLAN.csv", help="What `sooner plan` wrote, or a plan of your own.")],
    connect: Annotated[
        str,
        typer.Option(
            metavar="ADDRESS",
            help="udp:HOST:PORT waits at that port of this machine for a vehicle, as ground stations do; "
            "udpout:HOST:PORT sends first; tcp:HOST:PORT; serial:DEVICE:BAUD.",
        ),
    ],
    searcher: Annotated[
        int | None, typer.Option(help="Whose flight; needed where the plan has several.", min=0)
    ] = None,
    autopilot: Annotated[str | None, typer.Option(help="ardupilot or px4; left out: what its heartbeat says.")] = None,
    system: Annotated[
        int | None, typer.Option(help="Which vehicle, by its number, where several are heard.", min=1, max=255)
    ] = None,
    wait: Annotated[float, typer.Option(help="Seconds to wait for a heartbeat.")] = 20.0,
    json: Json = False,
    quiet: Quiet = False,
    force: Annotated[bool, typer.Option("--force", help="Replace the mission of an armed vehicle.")] = False,
) -> Work:
    """Send a flight to a vehicle over MAVLink: fence, rally points and mission, read back and compared.

    It arms nothing, starts nothing and switches no fence on. A fence or rally points that the vehicle holds and the
    flight does not have are cleared, and told. Ends with status 0 where the vehicle holds what it was sent.
    Needs pymavlink: pip install 'sooner[aircraft]'.
    """
    wishes = (connect, searcher, autopilot, system, wait, json, quiet, force)
    return partial(_run, "upload", "upload_plan", mission, plan, *wishes)


@app.command(name="debrief")
def debrief_tracks(
    mission: MissionFile,
    tracks: Annotated[
        list[Path],
        typer.Argument(
            metavar="TRACK...",
            help="What was flown: .gpx, .geojson, .kml, a DJI flight record .csv, .tlog, .bin or .log.",
        ),
    ],
    plan: Annotated[
        Path | None, typer.Option(metavar="PLAN.csv", help="What was to be flown: gaps are told, and how far off.")
    ] = None,
    out: Annotated[Path | None, _folder("Folder for the maps, the picture and the next mission.")] = None,
    gap: Annotated[
        float, typer.Option(metavar="S", help="Between fixes more than so many seconds apart nothing counts as flown.")
    ] = 15.0,
    json: Json = False,
    force: Force = False,
) -> Work:
    """Judge flown tracks on which nobody was found: POD by cell, POS so far, gaps, and the next mission.

    Writes debrief.json, debrief.png, pod.tif, poc-after.tif, gaps.geojson (with --plan), and next/mission.toml, whose
    first map is where the person may be now, to --out (left out: a folder MISSION-debrief beside the mission file).
    """
    return partial(_run, "debrief", "debrief_tracks", mission, tracks, plan, out, gap, json, force)


@app.command()
def simulate(
    mission: MissionFile,
    trials: Annotated[int, typer.Option(help="Flights, by the seeds SEED, SEED + 1, ...", min=1)] = 100,
    seed: Annotated[int, typer.Option(help="Of the first flight.", min=0)] = 0,
    workers: Annotated[int, typer.Option(help="Processes that fly at once; the answer is the same.", min=1)] = 1,
    strategy: Annotated[
        str | None,
        typer.Option(
            help="Over waypoints, how the team flies: random, lawnmower, tuned_lawnmower, information, "
            "swept_information, rollouts, or joint, which it is if left out."
        ),
    ] = None,
    planner: Annotated[str | None, typer.Option(help="Else: a name that `sooner planners` lists.")] = None,
    seconds: Annotated[
        float | None,
        typer.Option(
            help="Else: planning time, 10 if left out; the plan, and so the answer, depends on it and on the machine."
        ),
    ] = None,
    plan: Annotated[
        Path | None,
        typer.Option(metavar="PLAN.csv", help="Else: fly this plan, which `sooner evaluate` takes, and make none."),
    ] = None,
    replan: Annotated[
        float | None,
        typer.Option(help="Else, where answers teach: plan anew so often, seconds (steps if nobody says speed)."),
    ] = None,
    animate: Annotated[bool, typer.Option("--animate", help="Of the first flight, episode.gif as well.")] = False,
    out: Annotated[Path | None, _folder("Folder for the trials, an episode and its picture.")] = None,
    json: Json = False,
    quiet: Quiet = False,
    force: Force = False,
) -> Work:
    """Fly a mission many times against what is hidden from it, and tell what was found, when, and what was wrong.

    Over waypoints a strategy plans while it flies. Else a plan is made as by `sooner plan` and flown against people
    drawn from the map: what it finds stands beside what it promised. With --replan what looks have answered counts.
    How good the first plan is depends on the time it is given, so that one seed is one answer only with --plan.
    Writes trials.csv, simulation.json, and the first flight as episode.npz and episode.png, to --out (left out: a
    folder MISSION-simulation). Ctrl-C ends the trials; those that have been flown are written.
    """
    asked = (trials, seed, workers, strategy, planner, seconds, replan, plan, animate)
    return partial(_run, "simulate", "simulate", mission, asked, out, json, quiet, force)


@app.command()
def planners(json: Json = False) -> Work:
    """List the planners, with when to choose which."""
    return partial(_run, "lists", "planners", json)


@app.command()
def scenario(
    name: Annotated[str | None, typer.Argument(help="One of the list; left out: print the list.")] = None,
    out: Annotated[Path | None, _folder("Folder for the mission and its rasters.")] = None,
    seed: Annotated[int | None, typer.Option(help="Another search of the same kind.", min=0)] = None,
    force: Force = False,
) -> Work:
    """Write a ready-made mission with its rasters."""
    return partial(_run, "scenario", "scenario", name, out, seed, force)


@app.command()
def warmup(quiet: Quiet = False) -> Work:
    """Compile everything ahead, so that the first plan does not wait for it."""
    return partial(_run, "warmup", "warmup", quiet)


@app.command()
def cite(
    name: Annotated[str | None, typer.Argument(help="A planner, or a key such as Lin2014; left out: sooner.")] = None,
) -> Work:
    """Print what to cite for a planner, as BibTeX."""
    return partial(_run, "lists", "cite", name)


Trials = Annotated[int | None, typer.Option(help="Seeds 0, 1, ... of each case; left out: as the study says.", min=1)]
Data = Annotated[Path | None, typer.Option(help="Folder of the papers' maps; left out: $SOONER_DATA.")]
Scheduler = Annotated[
    str | None, typer.Option(metavar="ADDRESS", help="A Dask scheduler, tcp://HOST:PORT; left out: this machine.")
]
Earlier = Annotated[
    str,
    typer.Option(
        metavar="ask|keep|redo",
        help="Results of other code or maps in the ledger: ask stops and says so, keep counts them, "
        "redo puts that ledger aside and begins anew.",
    ),
]
Retry = Annotated[bool, typer.Option("--retry", help="Fly trials again that were set aside.")]
Report = Annotated[bool, typer.Option("--report", help="Fly nothing; write the report of what the ledger has.")]


@app.command()
def study(
    file: Annotated[Path, typer.Argument(metavar="STUDY.toml", help="Instances, planners, budgets, seeds.")],
    data: Data = None,
    trials: Trials = None,
    workers: Workers = None,
    out: Annotated[Path | None, _folder("Folder for the ledger and the report.")] = None,
    scheduler: Scheduler = None,
    earlier: Earlier = "ask",
    retry: Retry = False,
    report: Report = False,
    json: Json = False,
    quiet: Quiet = False,
    force: Force = False,
) -> Work:
    """Compare planners over many seeds: every trial is kept, and the same command goes on where it was stopped.

    Writes trials.sqlite (the ledger), summary.md with summary.png, summary.csv, paired.csv, overall.csv and trials.csv
    to --out (left out: a folder STUDY-results beside the study file); tables.md and tables.csv where it has tables.
    Ends with status 0 where every trial has its answer, with 2 where some have none.
    """
    wishes = (data, trials, workers, out, scheduler, earlier, retry, report, json, quiet, force)
    return partial(_campaign, "study", file, wishes)


@app.command()
def reproduce(
    paper: Annotated[str, typer.Argument(help="kuhlman2017, lin2014 or wolek2020.")],
    data: Data = None,
    trials: Trials = None,
    workers: Workers = None,
    out: Annotated[Path | None, _folder("Folder for reproduced.csv and the rest.")] = None,
    only: Annotated[list[str] | None, typer.Option(metavar="TABLE", help="Tables to fly, * and ? allowed.")] = None,
    scheduler: Scheduler = None,
    earlier: Earlier = "ask",
    retry: Retry = False,
    report: Report = False,
    json: Json = False,
    quiet: Quiet = False,
    force: Force = False,
) -> Work:
    """Run a paper's study again and set its tables beside the printed ones.

    What an earlier run has flown is not flown again: a run that was stopped goes on with the same command.
    Ends with status 0 where every trial has its answer, with 2 where some have none.
    """
    wishes = (data, trials, workers, out, scheduler, earlier, retry, report, json, quiet, force)
    return partial(_campaign, "reproduce", paper, wishes, only or [])


def _campaign(name: str, what: Path | str, wishes: tuple[Any, ...], *more: Any) -> int:
    module = import_module("sooner.cli.study")
    status: int = getattr(module, name)(what, *more, module.Wishes(*wishes))
    return status
