"""What every command is given, and the options that several of them share."""

from __future__ import annotations

import math
import os
import tempfile
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any

import typer

from benchmarks.store.atomic import write
from reports.cli.errors import UsageError, choose_claims, choose_engines
from reports.cli.project import TABLE, Project
from reports.results.options import OUT, OWN_FOLDER, Options

if TYPE_CHECKING:
    from reports.results.suite import Suite

Load = Callable[[], "Suite"]


@dataclass(frozen=True)
class Invocation:
    """What a command is given besides its own options.

    load     the suite, imported when called
    command  as typed
    called   the words before the command, such as "galvi"
    project  the project around the current folder
    """

    load: Load
    command: str
    called: str
    project: Project = field(default_factory=Project)

    def kept_folder(self, out: Path | None, below: str = "") -> Path:
        """The output folder: that of --out, or else the project's and what is below it."""
        return out if out is not None else (self.project.out or OUT) / below

    def folder(self, out: Path | None, below: str = "") -> Path:
        """The same, made. Raises typer.BadParameter where nothing can be written in it."""
        return check_folder(self.kept_folder(out, below))

    def options(
        self,
        suite: Suite,
        quick: bool,
        out: Path | None,
        claims: str = "",
        require: str | None = None,
        contenders: Sequence[str] = (),
        anew: bool = False,
        below: str = "",
        fail_under: float = 100.0,
    ) -> Options:
        """The options of a command on the suite. Raises typer.BadParameter for unknown words."""
        from benchmarks.claims.statements import claims_by_place, why_unchecked  # they bring pandas

        ids = [claim.id for claim in suite.claims]
        chosen = choose_claims(claims, ids, lambda: claims_by_place(suite.claims), why_unchecked)
        engines = () if require is None else choose_engines(require, suite.engines())
        return Options(
            quick, chosen, self.folder(out, below), self.command, engines, tuple(contenders), anew,
            self.called, fail_under,
        )  # fmt: skip


def invocation(context: typer.Context) -> Invocation:
    """Of the command that has this context."""
    return context.obj


def typed(context: typer.Context, parameter: str) -> bool:
    """Whether it stands on the command line, not in the project's table."""
    source = context.get_parameter_source(parameter)
    return source is not None and source.name == "COMMANDLINE"


def check_folder(out: Path) -> Path:
    """The output folder, made. Raises typer.BadParameter where nothing can be written in it."""
    if out.is_symlink() and not out.exists():
        raise typer.BadParameter(
            f"--out expects a folder; received {out}, a link to {os.readlink(out)}, which does not "
            "exist."
        )
    if out.exists() and not out.is_dir():
        raise typer.BadParameter(f"--out expects a folder; received the file {out}.")
    try:
        out.mkdir(parents=True, exist_ok=True)
        tempfile.TemporaryFile(dir=out).close()
        if OWN_FOLDER in out.parts[:1] and not (Path(OWN_FOLDER) / ".gitignore").exists():
            write(Path(OWN_FOLDER) / ".gitignore", "*\n")
    except OSError as error:
        raise typer.BadParameter(f"--out expects a folder to write in; {error}.") from None
    return out


def within(least: float, most: float, unit: str) -> Callable[..., float | None]:
    """A check of an option's number: finite, above `least`, up to `most`; `unit` says of what."""

    def check(context: typer.Context, param: typer.CallbackParam, value: float | None) -> Any:
        if value is None or (least < value <= most and math.isfinite(value)):
            return value
        word = param.opts[0]
        where = word if typed(context, str(param.name)) else f"{TABLE}: {word[2:]}"
        up_to = f", up to {most:g}" if math.isfinite(most) else ""
        # not a BadParameter, of which the message begins with the option
        raise UsageError(f"{where} expects {unit} above {least:g}{up_to}; received {value:g}.")

    return check


QUICK = typer.Option(False, "--quick", help="Fewer and shorter runs.")
CLAIMS = typer.Option(
    "", "--claims", metavar="V3,V5",
    help='Only these claims, or those at a place of a paper, as "H fig. 3.5"; "contenders": those '
    "of the external integrators.",
)  # fmt: skip
CONTENDER = typer.Option(
    [],
    "--contender",
    metavar="package.module:Class",
    help="An external integrator to include in the comparison; may be repeated.",
)
TRACKED = typer.Option(
    [],
    "--contender",
    metavar="package.module:Class",
    help="An integrator of the repository around this folder, to track; may be repeated.",
)
TIMEOUT = typer.Option(
    None,
    "--timeout",
    metavar="SECONDS",
    callback=within(0.0, math.inf, "a finite number of seconds"),
    help="Longest time of one run of an external integrator.",
)
FOLDER = typer.Option(None, "--out", metavar="DIR", help=f"Output folder. Default: `{OUT}`.")
