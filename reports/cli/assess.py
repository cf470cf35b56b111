"""The commands that assess a user's code: track, judge, versions, tolerance and convergence."""

from __future__ import annotations

from contextlib import suppress
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from reports.cli.endings import as_usage_error
from reports.cli.options import (
    Contenders,
    Out,
    Quick,
    Timeout,
    comma_separated,
    is_typed,
    options_of,
    output_folder,
)
from reports.results.options import OUT, Options

if TYPE_CHECKING:
    from reports.results.suite import Suite


def parse_number_or_text(text: str) -> Any:
    """The text as an int, else as a float, else unchanged."""
    for convert in (int, float):
        with suppress(ValueError):
            return convert(text)
    return text


def parse_numbers(text: str) -> list[Any]:
    """The numbers of a list with commas: "1,0.5" gives [1, 0.5].

    Raises typer.BadParameter if an entry is not a number."""
    parsed = [parse_number_or_text(word) for word in comma_separated(text)]
    if any(isinstance(entry, str) for entry in parsed):
        raise typer.BadParameter(f"Expected numbers, separated by commas; received {text!r}.")
    return parsed


def parse_setting(text: str) -> dict[str, Any]:
    """The mapping of a list of name=value: "integrator=whfast,dt=0.1" gives
    {"integrator": "whfast", "dt": 0.1}.

    Values that are numbers, true or false are converted. Raises typer.BadParameter for a part that
    is not name=value."""
    settings: dict[str, Any] = {}
    for part in comma_separated(text):
        name, _, value = (word.strip() for word in part.partition("="))
        if not (name and value):
            raise typer.BadParameter(f"Expected name=value, not {part!r}, separated by commas.")
        flag = {"true": True, "false": False}.get(value.lower())
        settings[name] = parse_number_or_text(value) if flag is None else flag
    return settings


ModelFile = Annotated[
    Path,
    typer.Argument(metavar="FILE", help="A REBOUND file, or a MuJoCo model (.xml, .mjb, .urdf)."),
]
Duration = Annotated[
    float | None,
    typer.Option(
        metavar="T",
        help="In the model's time; by default 100 revolutions of the fastest body, or 10 s.",
    ),
]
OwnSetting = Annotated[
    Any,
    typer.Option(
        "--own",
        metavar="integrator=whfast,dt=0.1",
        parser=parse_setting,
        help="Integrator, step and options of your run, where they differ from the file.",
    ),
]
Snapshot = Annotated[
    int, typer.Option("--snapshot", metavar="N", help="Snapshot of an archive; -1 is the last.")
]
Request = Annotated[  # of galvi.judge and galvi.convergence
    Path | None, typer.Option("--request", hidden=True)
]
Key = Annotated[
    Any,
    typer.Option(
        "--key",
        metavar="NAME|N",
        parser=parse_number_or_text,
        help="Keyframe of a model to start from.",
    ),
]
Ignore = Annotated[
    Any,
    typer.Option(
        "--ignore",
        metavar="contacts,limits",
        parser=comma_separated,
        help="Parts of a model to leave out.",
    ),
]
Positions = Annotated[
    Any,
    typer.Option(
        "--qpos", metavar="1,0.5", parser=parse_numbers, help="Initial positions of a model."
    ),
]
Velocities = Annotated[
    Any,
    typer.Option(
        "--qvel", metavar="0,0.1", parser=parse_numbers, help="Initial velocities of a model."
    ),
]
Controls = Annotated[
    Any,
    typer.Option(
        "--ctrl",
        metavar="0,0.1",
        parser=parse_numbers,
        help="Constant controls of a model's actuators.",
    ),
]


def track_performance(
    context: typer.Context,
    against: Annotated[
        str | None, typer.Option(metavar="REV", help="Commit or branch to compare with.")
    ] = None,
    only: Annotated[
        list[str] | None,
        typer.Option(
            metavar="TEXT", help="Only benchmarks with this in their names; may be repeated."
        ),
    ] = None,
    isolate: Annotated[
        bool, typer.Option("--isolate", help="Give each side an environment of its own (minutes).")
    ] = False,
    contender: Annotated[
        list[str] | None,
        typer.Option(
            metavar="package.module:Class",
            help="An integrator of the repository around this folder; may be repeated.",
        ),
    ] = None,
    timeout: Timeout = None,
    slower: Annotated[
        float,
        typer.Option(
            metavar="PERCENT",
            min=0,
            help="Larger median time of a contender that counts as worse.",
        ),
    ] = 10.0,
    less_accurate: Annotated[
        float,
        typer.Option(
            metavar="PERCENT", min=0, help="Larger error of a contender that counts as worse."
        ),
    ] = 1.0,
    quick: Quick = False,
    out: Out = OUT,
) -> int:
    """Show the benchmark history. With --against, compare with a revision."""
    from benchmarks.timings.case import Thresholds
    from reports.cli.track import track_command

    suite = context.obj.load()
    if against is None:
        # contenders of the project's table take part in comparisons
        if only or isolate or (contender and is_typed(context, "contender")):
            raise typer.BadParameter("--only, --isolate and --contender require --against REV.")
        return _show_history(suite, options_of(context, suite, out))
    folder, provenance = output_folder(out), suite.provenance(context.obj.command)
    return track_command(
        folder,
        provenance,
        against,
        only or [],
        quick,
        isolate,
        contender or [],
        timeout,
        Thresholds(slower / 100.0, less_accurate / 100.0),
    )


def _show_history(suite: Suite, options: Options) -> int:
    from reports.build.build import publish
    from reports.tracking.record import track

    track(options.out)
    publish(suite, options)
    return 0


def judge_model(
    context: typer.Context,
    file: ModelFile,
    duration: Duration = None,
    error: Annotated[
        float | None,
        typer.Option(metavar="E", help="Largest acceptable error; exit 1 if your run exceeds it."),
    ] = None,
    own_setting: OwnSetting = None,
    snapshot: Snapshot = -1,
    key: Key = None,
    ignore: Ignore = None,
    qpos: Positions = None,
    qvel: Velocities = None,
    ctrl: Controls = None,
    quick: Annotated[
        bool,
        typer.Option("--quick", help="Spend less time on other sources and integrators."),
    ] = False,
    extras: Annotated[
        str,
        typer.Option(
            metavar="FILE", help="REBOUNDx forces of a simulation, as written by rebx.save(FILE)."
        ),
    ] = "",
    request: Request = None,
    out: Out = OUT / "judge",
) -> int:
    """Judge a model's own run. Says how wrong it is, and what reaches an error cheapest."""
    from galvi.interop.judge import JudgeRequest
    from reports.cli.judge import REFUSALS, judgement_of, report_judgement

    judge_request = JudgeRequest(
        duration,
        error,
        own_setting or {},
        snapshot,
        ignore or (),
        key,
        qpos,
        qvel,
        ctrl,
        quick,
        extras=extras,
    )
    if request is not None:
        judge_request = JudgeRequest.from_json(request.read_text(encoding="utf-8"))
    command, called = context.obj.command, context.obj.called
    folder = output_folder(out)
    with as_usage_error(*REFUSALS):
        judgement = judgement_of(file, judge_request)
    return report_judgement(judgement, file, judge_request.error, folder, command, called)


def compare_versions(
    context: typer.Context,
    file: ModelFile,
    releases: Annotated[
        Any,
        typer.Option(
            metavar="3.17.0,4.0.1",
            parser=comma_separated,
            help="Releases of the engine; 3.6.0..4.0.1 finds the change between them.",
        ),
    ] = None,
    duration: Duration = None,
    own_setting: OwnSetting = None,
    snapshot: Snapshot = -1,
    key: Key = None,
    qpos: Positions = None,
    qvel: Velocities = None,
    ctrl: Controls = None,
    out: Out = OUT / "versions",
) -> int:
    """Say between which releases of its engine a model's own run changed, and what of it."""
    from galvi.interop.judge import JudgeRequest
    from reports.cli.versions import REFUSALS, report_versions, versions_of

    start = {"snapshot": snapshot, "key": key, "qpos": qpos, "qvel": qvel, "ctrl": ctrl}
    folder = output_folder(out)
    with as_usage_error(*REFUSALS):
        request = JudgeRequest(duration, own=own_setting or {}, **start)
        versions = versions_of(file, request, releases or (), folder)
    return report_versions(versions, file.name, folder, context.obj.command)


def measure_tolerance(
    context: typer.Context,
    file: ModelFile,
    releases: Annotated[
        Any,
        typer.Option(
            metavar="3.17.0,4.0.1",
            parser=comma_separated,
            help="Releases of the engine that the test must pass with.",
        ),
    ] = None,
    duration: Duration = None,
    own_setting: OwnSetting = None,
    snapshot: Snapshot = -1,
    key: Key = None,
    qpos: Positions = None,
    qvel: Velocities = None,
    ctrl: Controls = None,
    out: Out = OUT / "tolerance",
) -> int:
    """Say what bound a regression test of a model's own run should have, by measured rounding."""
    from galvi.interop.judge import JudgeRequest
    from reports.cli.tolerance import REFUSALS, report_tolerance, tolerance_of

    start = {"snapshot": snapshot, "key": key, "qpos": qpos, "qvel": qvel, "ctrl": ctrl}
    folder = output_folder(out)
    with as_usage_error(*REFUSALS):
        request = JudgeRequest(duration, own=own_setting or {}, **start)
        tolerance = tolerance_of(file, request, releases or (), folder)
    return report_tolerance(tolerance, file.name, folder, context.obj.command)


def tabulate_convergence(
    context: typer.Context,
    problem: Annotated[
        str,
        typer.Option(
            metavar="package.module:function",
            help="A function that returns a galvi.Problem and its duration.",
        ),
    ] = "",
    method: Annotated[
        list[str] | None,
        typer.Option(
            metavar="rebound.whfast",
            help="A code by name, gauss:DEGREE, or package.module:name of a galvi.Galerkin; may be "
            "repeated. By default all.",
        ),
    ] = None,
    contender: Contenders = None,
    steps: Annotated[
        Any,
        typer.Option(
            metavar="50,100,200",
            parser=parse_numbers,
            help="Numbers of equal steps, or step sizes; by default found by trial.",
        ),
    ] = None,
    duration: Annotated[
        float | None, typer.Option(metavar="T", help="Duration, in place of the problem's.")
    ] = None,
    truth: Annotated[
        str | None,
        typer.Option(metavar="scipy.dop853", help="The code whose run is taken as the truth."),
    ] = None,
    timeout: Timeout = None,
    quick: Annotated[bool, typer.Option("--quick", help="Shorter timings.")] = False,
    request: Request = None,
    out: Out = OUT / "convergence",
) -> int:
    """Tabulate and draw orders of methods."""
    from reports.cli.convergence import REFUSALS, order_table, request_of, write_json, write_results
    from reports.cli.handed_over import handed_over

    if not problem and request is None:
        raise typer.BadParameter("Expected --problem package.module:function.")
    folder = output_folder(out)
    with as_usage_error(*REFUSALS):
        convergence_request = (
            request_of(problem, method or (), contender or (), steps, duration, truth, quick)
            if request is None
            else handed_over(request, "galvi.convergence")
        )
        table = order_table(convergence_request, timeout, context.obj.command)
    if request is not None:
        return write_json(table, folder)
    return write_results(table, folder)
