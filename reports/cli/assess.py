"""The commands that assess what is a user's: track, judge and convergence."""

from __future__ import annotations

import math
from pathlib import Path

import typer

from reports.cli.invocation import (
    FOLDER,
    QUICK,
    TIMEOUT,
    TRACKED,
    invocation,
    typed,
    within,
)
from reports.cli.option_groups import Convergence, ModelStart
from reports.results.options import OUT

JUDGE, CONVERGENCE = "judge", "convergence"  # folders in the output folder


def track_performance(
    context: typer.Context,
    against: str = typer.Option(None, "--against", metavar="REV", help="A commit or a branch."),
    only: list[str] = typer.Option(
        [], "--only", metavar="TEXT", help="Benchmarks with this in their names."
    ),
    isolate: bool = typer.Option(
        False, "--isolate", help="Give each side its own environment (minutes)."
    ),
    contender: list[str] = TRACKED,
    timeout: float = TIMEOUT,
    slower: float = typer.Option(
        None,
        "--slower",
        metavar="PERCENT",
        callback=within(0.0, math.inf, "a finite percentage"),
        help="Growth of a contender's median time that is worse. Default: `10`.",
    ),
    less_accurate: float = typer.Option(
        None,
        "--less-accurate",
        metavar="PERCENT",
        callback=within(0.0, math.inf, "a finite percentage"),
        help="Growth of a contender's error that is worse. Default: `1`.",
    ),
    quick: bool = QUICK,
    out: Path = FOLDER,
) -> int:
    """Show the benchmark history; with --against, compare with a revision."""
    from benchmarks.timings.case import Thresholds
    from reports.cli.track import THRESHOLDS, track_command

    given = invocation(context)
    if against is None and not typed(context, "contender"):
        contender = []  # those of the project's table take part in comparisons
    thresholds = Thresholds(
        THRESHOLDS.slower if slower is None else slower / 100.0,
        THRESHOLDS.less_accurate if less_accurate is None else less_accurate / 100.0,
    )
    return track_command(
        given.folder(out), given.load().provenance(given.command), against, only, quick, isolate,
        contender, timeout, thresholds,
    )  # fmt: skip


def judge_model(
    context: typer.Context,
    *,
    file: Path = typer.Argument(
        ...,
        metavar="FILE",
        help="A file of REBOUND's, or a model of MuJoCo's (.xml, .mjb, .urdf).",
    ),
    duration: float = typer.Option(
        None,
        "--duration",
        metavar="T",
        help="In the model's time; without it 100 revolutions of the fastest body, or 10 s.",
    ),
    error: float = typer.Option(
        None,
        "--error",
        metavar="E",
        help="Largest error allowed; exit 1 when your run is worse.",
    ),
    own: str = typer.Option(
        "",
        "--own",
        metavar="integrator=whfast,dt=0.1",
        help="Integrator, step and options of the run to judge, where not as in the file.",
    ),
    start: ModelStart,
    quick: bool = typer.Option(
        False, "--quick", help="Shorter looks at other sources and integrators."
    ),
    extras: str = typer.Option(
        "",
        "--extras",
        metavar="FILE",
        help="Forces of REBOUNDx in a simulation, as rebx.save(FILE) writes.",
    ),
    request: Path = typer.Option(None, "--request", hidden=True),  # of galvi.judge
    out: Path = typer.Option(
        None, "--out", metavar="DIR", help=f"Output folder. Default: `{OUT / JUDGE}`."
    ),
) -> int:
    """How wrong a model's own run is, and what reaches an error cheapest."""
    from galvi.interop.judge import JudgeRequest
    from reports.cli.judge import judge_command, request_of

    given = invocation(context)
    folder = given.folder(out, JUDGE)
    asked = (
        request_of(start, duration, error, own, quick, extras)
        if request is None
        else JudgeRequest.from_json(request.read_text(encoding="utf-8"))
    )
    return judge_command(file, asked, folder, given.command, given.called)


def tabulate_convergence(
    context: typer.Context,
    *,
    asked: Convergence,
    timeout: float = TIMEOUT,
    quick: bool = typer.Option(False, "--quick", help="Shorter timings."),
    request: Path = typer.Option(None, "--request", hidden=True),  # of galvi.convergence
    out: Path = typer.Option(
        None, "--out", metavar="DIR", help=f"Output folder. Default: `{OUT / CONVERGENCE}`."
    ),
) -> int:
    """Errors and orders of methods on a problem: tables and a figure."""
    from reports.cli.convergence import convergence_command

    given = invocation(context)
    if not asked.problem and request is None:
        raise typer.BadParameter("convergence expects --problem package.module:function.")
    folder = given.folder(out, CONVERGENCE)
    return convergence_command(request or asked, quick, timeout, folder, given.command)
