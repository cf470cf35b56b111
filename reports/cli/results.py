"""The commands on results that earlier ones wrote: export, merge and readme."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial
from pathlib import Path
from typing import Annotated, Any, Literal

import typer

from reports.cli.endings import as_usage_error
from reports.cli.options import Out, check_known, comma_separated, is_typed, output_folder
from reports.results.options import OUT

STDOUT = Path("/dev/stdout")
KIT = "kit"
KIT_PARAMETERS = ("name", "to", "out")


def export(
    context: typer.Context,
    name: Annotated[
        str,
        typer.Argument(
            metavar="NAME",
            help="Such as work_precision, ratios, numbers or fig-3-02; or kit, a folder of "
            "reference solutions and models.",
        ),
    ] = "",
    listed: Annotated[bool, typer.Option("--list", help="List the tables and figures.")] = False,
    export_all: Annotated[
        bool, typer.Option("--all", help="Export all tables, or all figures.")
    ] = False,
    where: Annotated[
        list[str] | None,
        typer.Option(
            metavar="problem=kepler", help="Rows to keep; several conditions narrow them down."
        ),
    ] = None,
    columns: Annotated[
        Any,
        typer.Option(
            metavar="error,seconds", parser=comma_separated, help="Columns to keep, in this order."
        ),
    ] = None,
    form: Annotated[
        Literal["csv", "parquet", "latex", "markdown", "pdf", "svg", "png"],
        typer.Option("--format", help="The last three are for figures, the others for tables."),
    ] = "csv",
    sort: Annotated[
        Any,
        typer.Option(
            metavar="error,-seconds",
            parser=comma_separated,
            help="Columns to sort by; - for descending order.",
        ),
    ] = None,
    to: Annotated[
        Path | None,
        typer.Option(
            metavar="FILE",
            help="Output file, or - for standard output; by default in tables/ or figures/. For "
            "kit, a folder.",
        ),
    ] = None,
    width: Annotated[
        Literal["column", "page"], typer.Option(help="Width of a figure in a paper.")
    ] = "page",
    out: Out = OUT,
) -> int:
    """Write a table or a figure for a paper, or reference solutions for other projects."""
    if name == KIT:
        return _export_kit(context, to, out)
    from reports.cli import export as work

    if to and to.is_dir():
        raise typer.BadParameter(f"--to expects a file; received the folder {str(to)!r}.")
    if bool(name) + listed + export_all != 1:
        raise typer.BadParameter("Expected exactly one of NAME, --list and --all.")
    if export_all and to:
        raise typer.BadParameter("--all does not take --to.")
    is_picture = form in work.PICTURE_FORMATS
    if any((where, columns, sort)) and (is_picture or not name):
        raise typer.BadParameter("--sort, --where and --columns are for one table.")
    to = STDOUT if to == Path("-") else to
    if listed:
        work.list_all(work.tables(out), work.figures(context.obj.load(), out))
    elif is_picture:
        work.export_figures(work.figures(context.obj.load(), out), out, name, form, width, to)
    else:
        names = [name] if name else [*work.tables(out)]
        _check_tables(context, out, names, form)
        for table in names:
            work.export_table(out, table, form, to, where or (), columns or (), sort or ())
    return 0


def _export_kit(context: typer.Context, to: Path | None, out: Path) -> int:
    """Write the kit, and print its folder.

    Raises typer.BadParameter for an option that the kit does not take, and for a folder that has
    other contents or is not writable.
    """
    for parameter in context.command.params:
        if parameter.name not in KIT_PARAMETERS and is_typed(context, parameter.name or ""):
            raise typer.BadParameter(
                f"{KIT} takes only --to and --out; leave out {parameter.opts[0]}."
            )
    if to == Path("-"):
        raise typer.BadParameter("--to expects a folder for kit; received -, the standard output.")
    from reports.cli.handed_over import show_progress
    from reports.tables.kit import is_kit, write_kit

    folder = output_folder(to, "--to") if to else output_folder(out / KIT)
    if any(folder.iterdir()) and not is_kit(folder):
        raise typer.BadParameter(
            f"kit expects a new or empty folder, or an earlier kit; {str(folder)!r} holds other "
            "files. Name another folder with --to."
        )
    print(write_kit(folder, partial(show_progress, KIT)))
    return 0


def _check_tables(context: typer.Context, out: Path, names: Sequence[str], form: str) -> None:
    """Raise typer.BadParameter if `out` has no tables, or none of one of these names."""
    from reports.cli import export as work

    tables = [*work.tables(out)]
    if not tables:
        raise typer.BadParameter(f"{out} holds no table yet; run compare or build first.")
    exportable = [*tables, work.MACROS] if form == "latex" else tables
    for name in names:
        if name not in exportable and name in work.figures(context.obj.load(), out):
            raise typer.BadParameter(f"{name!r} is a figure: add --format pdf, svg or png.")
        check_known("table", name, exportable)


def merge_reports(
    folders: Annotated[
        list[Path],
        typer.Argument(metavar="FOLDER", help="What `compare` or `make bench` wrote."),
    ],
    out: Out = OUT,
) -> int:
    """Add rows and benches of other machines."""
    from reports.results.machines import merge

    with as_usage_error(ValueError, prefix="merge: "):
        print("\n".join(merge(output_folder(out), folders)))
    return 0


def renew_readme(out: Out = OUT) -> int:
    """Update results in README.md and docs/."""
    from reports.tables.readme import renew

    with as_usage_error(ValueError, OSError):
        written = renew(Path(), out)
    if not written:
        raise typer.BadParameter(f"{out} holds no rows of them yet; run build first.")
    print(f"Renewed: {', '.join(written)}.")
    return 0
