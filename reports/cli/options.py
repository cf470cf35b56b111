"""Options that several commands share, and the parsers of their texts."""

from __future__ import annotations

import tempfile
from collections.abc import Callable, Collection, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from benchmarks.store.atomic import write
from references.setting import nearest
from reports.cli.project import CONTENDERS_CLAIMS, TABLE
from reports.results.options import CONTENDER_PREFIX, PROJECT_FOLDER, Options

if TYPE_CHECKING:
    from benchmarks.checks.claim import Claim
    from reports.results.suite import Suite

MAX_TIMEOUT = 86_400  # seconds: a day
MAX_LISTED = 20  # largest number of choices that a message lists


@dataclass(frozen=True)
class Invocation:
    """The `obj` of a command's context.

    Attributes
    ----------
    load
        returns the suite, which it imports
    command
        the command line as typed
    called
        the words before the command's name, such as "galvi"
    """

    load: Callable[[], Suite]
    command: str
    called: str


def comma_separated(text: str) -> tuple[str, ...]:
    """The entries of a text, separated by commas. Raises typer.BadParameter if there are none."""
    entries = tuple(" ".join(word.split()) for word in text.split(",") if word.strip())
    if not entries:
        raise typer.BadParameter(f"Expected words, separated by commas; received {text!r}.")
    return entries


Quick = Annotated[bool, typer.Option("--quick", help="Fewer and shorter runs.")]
Claims = Annotated[
    Any,
    typer.Option(
        "--claims",
        metavar="V3,V5",
        parser=comma_separated,
        help='Only these claims, or those about a place in a paper, as "H fig. 3.5"; '
        '"contenders": those of external integrators.',
    ),
]
Require = Annotated[
    Any,
    typer.Option(
        "--require",
        metavar="rebound,mujoco",
        parser=comma_separated,
        help="Engines whose absence is a failure.",
    ),
]
Contenders = Annotated[
    list[str] | None,
    typer.Option(
        "--contender",
        metavar="package.module:Class",
        help="An external integrator to include; may be repeated.",
    ),
]
Timeout = Annotated[
    float | None,
    typer.Option(
        "--timeout",
        metavar="SECONDS",
        min=0.1,
        max=MAX_TIMEOUT,
        help="Time limit for one run of an external integrator.",
    ),
]
Out = Annotated[Path, typer.Option("--out", metavar="DIR", help="Output folder.")]


def is_typed(context: typer.Context, parameter: str) -> bool:
    """Whether the parameter was given on the command line, not by default or by TABLE."""
    source = context.get_parameter_source(parameter)
    return source is not None and source.name == "COMMANDLINE"


def options_of(
    context: typer.Context,
    suite: Suite,
    out: Path,
    claims: Sequence[str] | None = None,
    require: Sequence[str] | None = None,
    **fields: Any,
) -> Options:
    """The options of a command on the suite; `fields` are further fields of Options.

    Makes the output folder. Raises typer.BadParameter for a folder that is not writable, and for
    unknown claims and engines.
    """
    selected_ids = choose_claims(claims or (), suite.claims)
    engines = tuple(dict.fromkeys(require or ()))
    for engine in engines:
        check_known("engine", engine, suite.engines())
    return Options(
        claims=selected_ids,
        require=engines,
        out=output_folder(out),
        command=context.obj.command,
        called=context.obj.called,
        **fields,
    )


def output_folder(out: Path, option: str = "--out") -> Path:
    """Make the folder that an option names, and return it.

    Raises typer.BadParameter if the folder cannot be made or is not writable.
    """
    try:
        out.mkdir(parents=True, exist_ok=True)
        tempfile.TemporaryFile(dir=out).close()
        if (
            out.parts[:1] == (PROJECT_FOLDER,)
            and not (Path(PROJECT_FOLDER) / ".gitignore").exists()
        ):
            write(Path(PROJECT_FOLDER) / ".gitignore", "*\n")
    except OSError as error:
        raise typer.BadParameter(
            f"{option} expects a folder to write in; received {out}: {error.strerror}."
        ) from None
    return out


def check_known(kind: str, name: str, choices: Collection[str]) -> None:
    """Raise typer.BadParameter, with the nearest choice, if `name` is not among the choices."""
    if name not in choices:
        listed_choices = f" among {', '.join(choices)}" if 0 < len(choices) <= MAX_LISTED else ""
        hint = f"did you mean {nearest(name, choices)!r}?" if choices else "there are none here."
        raise typer.BadParameter(f"There is no {kind} {name!r}{listed_choices}; {hint}")


def choose_claims(selection: Sequence[str], claims: Sequence[Claim]) -> tuple[str, ...]:
    """The ids that --claims selects, in the order of the claims; all for an empty selection.

    Parameters
    ----------
    selection
        ids, places in the papers such as "H fig. 3.5", and CONTENDERS_CLAIMS for all claims of
        external integrators; the parts of a single place that has commas are joined again

    Notes
    -----
    Raises typer.BadParameter for an unknown id or place, a place that no claim checks, and claims
    of external integrators where there are none.
    """
    from benchmarks.claims.statements import claims_by_place, why_unchecked  # they bring pandas

    ids = [claim.id for claim in claims]
    contender_ids = {id for id in ids if id.startswith(CONTENDER_PREFIX)}
    names = {id: {id} for id in ids} | {CONTENDERS_CLAIMS: contender_ids}
    if not set(selection) <= set(names):
        names |= claims_by_place(claims)
    joined_selection = ", ".join(selection)
    selected_ids = set[str]()
    for word in [joined_selection] if joined_selection in names else selection:
        if word.startswith((CONTENDER_PREFIX, CONTENDERS_CLAIMS)) and not contender_ids:
            raise typer.BadParameter(
                f"There is no claim {word!r}; such claims belong to an external integrator: add it "
                f"with --contender package.module:Class, or as contenders of {TABLE}."
            )
        check_known("claim or place", word, names)
        if not names[word]:
            raise typer.BadParameter(
                f"No claim checks what is printed at {word!r} ({why_unchecked(word)})."
            )
        selected_ids |= names[word]
    return tuple(id for id in ids if id in selected_ids or not selection)
