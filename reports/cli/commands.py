"""The commands of ``galvi``, which are those of ``python -m reports``, and their exit status.

0    nothing worse and nothing unexpected; what is absent and not required, or new, is listed
1    something got worse, a verdict is not as expected, a study failed, a required engine is absent,
     a judged run does not reach its error, or a run has no bound that holds at its end
2    the command could not be carried out, with one sentence why: in CI, a failure;
     `GALVI_TRACEBACK=1` in the environment shows where it was raised
3    likewise, for want of a package that is not installed
130  interrupted
141  nobody reads the output any more, as with `head`
"""

from __future__ import annotations

import platform
import shlex
from collections.abc import Callable, Mapping, Sequence
from importlib import metadata
from pathlib import Path
from typing import Annotated, Any

import typer

from galvi.interop.release import galvi_version
from reports.cli import assess, measure, results
from reports.cli.endings import UsageError, ended
from reports.cli.options import Invocation
from reports.cli.project import defaults

PROGRAM = ("python", "-m", "reports")
GLOBAL_OPTIONS = ("--help", "--version")  # options without a command
COMMANDS: Mapping[str, Callable[..., int]] = {
    "verify": measure.verify_claims,
    "compare": measure.compare_methods,
    "build": measure.build_all,
    "studies": measure.long_studies,
    "export": results.export,
    "track": assess.track_performance,
    "judge": assess.judge_model,
    "versions": assess.compare_versions,
    "tolerance": assess.measure_tolerance,
    "convergence": assess.tabulate_convergence,
    "warm": measure.warm_kernels,
    "merge": results.merge_reports,
    "readme": results.renew_readme,
}


def show_version(requested: bool) -> None:
    """Print the versions of galvi, Python and its main dependencies, and exit, if `requested`."""
    if requested:
        versions = (f"{name} {metadata.version(name)}" for name in ("numpy", "numba"))
        print(f"galvi {galvi_version()}")
        print(", ".join([f"Python {platform.python_version()}", *versions]))
        raise typer.Exit


def everything(
    version: Annotated[
        bool,
        typer.Option(
            "--version", is_eager=True, callback=show_version, help="Show versions and exit."
        ),
    ] = False,
) -> None:
    """Check the papers' claims, compare methods, and write tables, figures and a page.

    Without a command this is `build`, and takes its options.
    """


def application() -> typer.Typer:
    """The typer application.

    Its commands return the exit status, and expect an Invocation as `obj` of their context.
    """
    app = typer.Typer(add_completion=False, rich_markup_mode=None)
    app.callback()(everything)
    for name, command in COMMANDS.items():
        app.command(name)(command)
    return app


def run(load: Callable[[], Any], arguments: Sequence[str], called: Sequence[str] = PROGRAM) -> int:
    """Run the command; returns the exit status. Whatever goes wrong becomes a sentence on stderr.

    Parameters
    ----------
    load
        returns the suite, which it imports
    called
        words before the arguments, as shown in usage messages and in the provenance
    """
    return ended(lambda: _run(load, list(arguments), called))


def _run(load: Callable[[], Any], arguments: list[str], called: Sequence[str]) -> int:
    command = shlex.join([*called, *arguments]).encode(errors="replace").decode()
    invocation = Invocation(load, command, " ".join(called))
    is_build = not arguments or (arguments[0][:1] == "-" and arguments[0] not in GLOBAL_OPTIONS)
    command_line = ["build", *arguments] if is_build else arguments
    default_options = {} if {*GLOBAL_OPTIONS} & {*command_line} else defaults(Path.cwd())
    group = typer.main.get_command(application())
    try:
        with group.make_context(
            invocation.called, command_line, obj=invocation, default_map=default_options
        ) as context:
            return group.invoke(context)
    except typer.Exit as exit_request:
        return exit_request.exit_code
    except UsageError as error:
        names = [word for word in arguments if word in COMMANDS]
        if is_build and names and "unexpected extra argument" in error.message:
            example = f"{invocation.called} {names[0]} {arguments[0]}"
            raise typer.BadParameter(f"Options follow the command, as in: {example}.") from None
        raise
