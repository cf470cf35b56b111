"""The commands on results that earlier ones wrote: export, merge and readme."""

from __future__ import annotations

from pathlib import Path

import typer

from reports.cli.errors import words
from reports.cli.invocation import FOLDER, invocation
from reports.cli.merge import merge_command
from reports.cli.option_groups import Selection


def export_table(
    context: typer.Context,
    *,
    selection: Selection,
    where: list[str] = typer.Option(
        [], "--where", metavar="problem=kepler", help="Rows to take; several narrow it down."
    ),
    columns: str = typer.Option("", "--columns", metavar="error,seconds", help="Columns to take."),
    form: str = typer.Option(
        "csv",
        "--format",
        metavar="parquet|latex|csv|markdown|pdf|svg|png",
        help="Of a table, or one of the last three of a figure.",
    ),
    sort: str = typer.Option("", "--sort", metavar="error,-seconds", help="Columns to sort by."),
    to: Path = typer.Option(
        None, "--to", metavar="FILE", help="Output file; default in tables/ or figures/."
    ),
    width: str = typer.Option(
        "page", "--width", metavar="column|page", help="Of a figure for a paper."
    ),
    out: Path = FOLDER,
) -> int:
    """Write a table as CSV, Parquet, LaTeX or Markdown, or a figure for a paper."""
    from reports.cli.export import Choice, exported

    given = invocation(context)
    choice = Choice(words(sort), words(columns), tuple(where))
    folder = given.kept_folder(out)
    for line in exported(given.load, folder, selection, form, width, to, choice):
        print(line)
    return 0


def merge_reports(
    context: typer.Context,
    folders: list[Path] = typer.Argument(
        ..., metavar="FOLDER...", help="What `compare` or `make bench` wrote."
    ),
    out: Path = FOLDER,
) -> int:
    """Bring in kept rows and benches of other machines' reports."""
    return merge_command(invocation(context).folder(out), folders)


def renew_readme(context: typer.Context, out: Path = FOLDER) -> int:
    """Update the tables and pictures of README.md and docs/."""
    from reports.tables.readme import renew

    folder = invocation(context).kept_folder(out)
    try:
        written = renew(Path(), folder)
    except ValueError as error:
        raise typer.BadParameter(str(error)) from None
    if not written:
        raise typer.BadParameter(f"{folder} holds no rows of them yet; run build first.")
    print(f"Renewed: {', '.join(written)}.")
    return 0
