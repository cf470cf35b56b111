"""The commands of ``galvi``, which are those of ``python -m reports``, and their exit status.

0    nothing worse and nothing unexpected; absent engines that were not required, new integrators,
     and benchmarks that neither side can run are listed, and are no failure
1    something got worse, a verdict is not as expected, a study failed, a required engine is absent,
     or a judged run does not reach its error
2    the command could not be carried out, for whatever reason, as that no benchmark runs on both
     sides, with one sentence why: in CI, treat it as a failure
3    likewise, for want of a package that is not installed
130  interrupted
141  nobody reads the output any more, as with `head`
"""

from __future__ import annotations

import platform
import shlex
import sys
from collections.abc import Callable, Mapping, Sequence
from importlib import metadata
from pathlib import Path
from typing import Any

import typer

from galvi.command import CANNOT
from galvi.interop.release import galvi_version
from reports.cli import assess, kept_results, measure
from reports.cli.endings import ended
from reports.cli.errors import UsageError, sentence
from reports.cli.invocation import (
    CLAIMS,
    CONTENDER,
    FOLDER,
    QUICK,
    Invocation,
    Load,
    invocation,
    typed,
)
from reports.cli.option_groups import Checking, spread
from reports.cli.project import Project, read_project

PROGRAM = ("python", "-m", "reports")
WITHOUT_PROJECT = ("--help", "--version")  # answered whatever a project's table says
COMMANDS: Mapping[str, Callable[..., int]] = {
    "verify": measure.verify_claims,
    "compare": measure.compare_methods,
    "build": measure.build_all,
    "studies": measure.long_studies,
    "export": kept_results.export_table,
    "track": assess.track_performance,
    "judge": assess.judge_model,
    "convergence": assess.tabulate_convergence,
    "warm": measure.warm_kernels,
    "merge": kept_results.merge_reports,
    "readme": kept_results.renew_readme,
}


def show_version(asked: bool) -> None:
    """Print the versions that results depend on, and end."""
    if asked:
        others = (f"{name} {metadata.version(name)}" for name in ("numpy", "numba"))
        print(f"galvi {galvi_version()}")
        print(", ".join([f"Python {platform.python_version()}", *others]))
        raise typer.Exit


def everything(
    context: typer.Context,
    quick: bool = QUICK,
    claims: str = CLAIMS,
    contender: list[str] = CONTENDER,
    anew: bool = measure.ANEW,
    out: Path = FOLDER,
    version: bool = typer.Option(
        False, "--version", is_eager=True, callback=show_version, help="Show versions, and exit."
    ),
) -> int:
    """Check the papers' claims, compare methods, and write tables, figures and a page."""
    if context.invoked_subcommand is None:
        project = invocation(context).project
        require, timeout = project.default("require"), project.default("timeout")
        return measure.build_all(
            context, quick=quick, checking=Checking(claims, require, contender, timeout), anew=anew,
            kept=False, single=False, out=out,
        )  # fmt: skip
    names = ("quick", "claims", "contender", "anew", "out")
    before = [f"--{name}" for name in names if typed(context, name)]
    if before:
        raise typer.BadParameter(
            f"{' and '.join(before)} must follow the command, "
            f"as in: {context.invoked_subcommand} {before[0]}."
        )
    return 0


def application() -> typer.Typer:
    """The typer application; its commands return the exit status, and expect an Invocation as
    their context's `obj`."""
    app = typer.Typer(add_completion=False, rich_markup_mode=None)
    app.callback(invoke_without_command=True)(everything)
    for name, command in COMMANDS.items():
        app.command(name)(spread(command))
    return app


def run(load: Load, arguments: Sequence[str], called: Sequence[str] = PROGRAM) -> int:
    """Run the command; returns the exit status. Whatever goes wrong becomes a sentence on stderr.

    load    the suite, imported when called
    called  the words before the arguments, as usage and provenance name the command
    """
    return ended(lambda: _run(load, arguments, called))


def _run(load: Load, arguments: Sequence[str], called: Sequence[str]) -> int:
    group: Any = typer.main.get_command(application())
    command = shlex.join([*called, *arguments]).encode(errors="replace").decode()
    try:
        any_project = not set(WITHOUT_PROJECT) & set(arguments)
        project = read_project(Path.cwd()) if any_project else Project()
        given = Invocation(load, command, " ".join(called), project)
        with group.make_context(
            given.called, list(arguments), obj=given, default_map=_defaults(group, project)
        ) as context:
            status = group.invoke(context)
    except UsageError as error:
        print(sentence(error, COMMANDS), file=sys.stderr)
        return CANNOT
    except typer.Exit as ended_early:
        status = ended_early.exit_code
    return int(status or 0)


def _defaults(group: Any, project: Project) -> dict[str, Any]:
    """The project's defaults, by command; on top those of `build`, which no command means."""
    parameters = {
        name: {one.name for one in command.params} for name, command in group.commands.items()
    }
    defaults = project.defaults(parameters)
    return {**defaults["build"], **defaults}
