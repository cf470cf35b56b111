"""`export`: a table as CSV, Parquet, LaTeX or Markdown; a figure as PDF, SVG or PNG."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path

import pandas as pd
import typer

from benchmarks.store.atomic import write
from benchmarks.store.cells import as_csv, read_csv
from galvi.whole_files import open_descriptor
from reports.build.kept import kept_claims, kept_comparison, kept_sections
from reports.cli.endings import as_usage_error
from reports.cli.options import check_known
from reports.figures.drawing import drawable
from reports.figures.picture import WIDTHS, printed_figure
from reports.figures.style.layout import NoData
from reports.results.origins import read_origins
from reports.results.section import Figure
from reports.results.suite import Suite
from reports.tables.latex import as_latex, caption_of, escape
from reports.tables.macros import CLAIMS, numbers
from reports.tables.writing import as_markdown

SUFFIXES = {"csv": ".csv", "parquet": ".parquet", "latex": ".tex", "markdown": ".md"}
PICTURE_FORMATS = ("pdf", "svg", "png")
MACROS = "numbers"  # the name of the macros
Figures = Mapping[str, tuple[Figure, pd.DataFrame | None]]


def list_all(known_tables: Iterable[str], known_figures: Figures) -> None:
    """Print the names of the tables, and the names and titles of the figures."""
    for name in known_tables:
        print(f"{name}  table")
    for name, (figure, _) in known_figures.items():
        print(f"{name}  figure: {figure.title}")


def tables(out: Path) -> dict[str, Path]:
    """Name -> path of each table of a report; one beside its page precedes one in tables/."""
    beside_page = {path.stem: path for path in sorted(out.glob("*.csv"))}
    return {path.stem: path for path in sorted((out / "tables").glob("*.csv"))} | beside_page


def figures(suite: Suite, out: Path) -> Figures:
    """Name -> (figure, rows) of all figures of a report; the rows are None if none are stored."""
    stored_results = (
        kept_claims(out, suite.claims),
        kept_comparison(out),
        kept_sections(out, suite.sections),
    )
    return {figure.name: (figure, table) for figure, table in drawable(*stored_results)}


def export_figures(
    catalogue: Figures, out: Path, name: str, form: str, width: str, to: Path | None
) -> None:
    """Draw the figure `name` in the width of a column or a page, and print its path.

    For "" every figure whose rows are stored is drawn; one that cannot be drawn is named on stdout.

    Parameters
    ----------
    to
        the file of one figure; None for figures/NAME-WIDTH.FORM in `out`

    Notes
    -----
    Raises typer.BadParameter for the name of a table, for an unknown figure, for one whose rows are
    not stored or cannot be drawn, and for "" where no rows are stored.
    """
    if name in tables(out):
        raise typer.BadParameter(
            f"{name!r} is a table: add --format csv, latex, markdown or parquet."
        )
    if name:
        check_known("figure", name, catalogue)
    with_rows = {
        key: (figure, table) for key, (figure, table) in catalogue.items() if table is not None
    }
    if not with_rows or (name and name not in with_rows):
        raise typer.BadParameter(
            f"The rows of {repr(name) if name else 'the figures'} are not kept in {out}; run build "
            "first."
        )
    for key in [name] if name else with_rows:
        path = to or out / "figures" / f"{key}-{width}.{form}"
        try:
            write_figure(*with_rows[key], path, form, width)
        except NoData as error:
            if name:
                raise typer.BadParameter(f"{name!r} cannot be drawn: {error}") from None
            print(f"{key!r} cannot be drawn: {error}")
        else:
            print_path(path)


def write_figure(figure: Figure, table: pd.DataFrame, path: Path, form: str, width: str) -> Path:
    """Draw a figure into a file, fonts embedded; returns its path.

    Its caption goes to files beside it, as text and as LaTeX, unless `path` is a pipe or standard
    output. Raises NoData if there is nothing to draw.
    """
    write(path, printed_figure(figure, table, form, WIDTHS[width]))
    if path.is_file() and open_descriptor(path) is None:  # else a pipe, or standard output
        caption = f"{figure.title.rstrip('.')}. {figure.caption}".strip()
        label = f"\\label{{fig:{figure.name}}}"
        write(path.with_name(f"{path.stem}-caption.txt"), f"{caption}\n")
        latex = f"\\caption{{{escape(caption)}}}{label}\n"
        write(path.with_name(f"{path.stem}-caption.tex"), latex)
    return path


def print_path(path: Path) -> None:
    """Print the path of a written file; nothing for standard output."""
    if open_descriptor(path) != 1:
        print(path)


def export_table(
    out: Path,
    name: str,
    form: str,
    to: Path | None = None,
    where: Sequence[str] = (),
    columns: Sequence[str] = (),
    sort: Sequence[str] = (),
) -> None:
    """Write the table `name` of the report in `out`, and print the path.

    For MACROS and "latex", the report's numbers are written as LaTeX macros.

    Parameters
    ----------
    to
        the output file; None for tables/NAME.SUFFIX in `out`, which a build overwrites
    where
        "column=value" with a text or a number: only rows that meet every condition are written
    columns
        columns to write, in this order; () for all
    sort
        columns, most significant first; "-seconds" sorts in descending order

    Notes
    -----
    Numbers have all digits in CSV and Parquet, few in LaTeX and Markdown. Missing values sort last.
    Raises typer.BadParameter for a table that cannot be read, for a malformed condition, and for an
    unknown column or value.
    """
    path = to or out / "tables" / f"{name}{SUFFIXES[form]}"
    if name == MACROS and form == "latex":
        if not (out / CLAIMS).is_file():
            raise typer.BadParameter(f"{out} holds no {CLAIMS} yet; run verify or build first.")
        content: str | bytes = numbers(out)
    else:
        with as_usage_error(OSError, ValueError, prefix=f"{name}.csv cannot be read: "):
            table = read_csv(tables(out)[name])  # pandas' own errors are ValueErrors
        table = selected(table, where, with_bounds(table, columns), sort)
        origins = read_origins(out)
        origin = origins.get(f"{name}.csv") or origins.get("work_precision.csv") or {}
        caption = caption_of(name, origin, where)
        content = _formatted(table, form, path.stem if to else name, caption)
    write(path, content)
    print_path(path)


def with_bounds(table: pd.DataFrame, columns: Sequence[str]) -> Sequence[str]:
    """The columns, with "error_is_bound" appended if they have errors, some of which are bounds."""
    if "error" not in columns or "error_is_bound" in columns or "error_is_bound" not in table:
        return columns
    return [*columns, *(["error_is_bound"] * bool(table["error_is_bound"].any()))]


def selected(
    table: pd.DataFrame, where: Sequence[str], columns: Sequence[str], sort: Sequence[str]
) -> pd.DataFrame:
    """The rows and columns that `export_table` writes."""
    for condition in where:
        column, equals, value = condition.partition("=")
        if not equals:
            raise typer.BadParameter(f"--where expects column=value; received {condition!r}.")
        check_known("column", column, list(table))
        text = table[column].astype(str)
        matches = text == value
        matches |= pd.to_numeric(table[column], errors="coerce") == pd.to_numeric(value, "coerce")
        if not matches.any():
            check_known(column, value, text.dropna().unique().tolist())
        table = table[matches]
    sort_columns = [word.removeprefix("-") for word in sort]
    for column in (*columns, *sort_columns):
        check_known("column", column, list(table))
    ascending = [not word.startswith("-") for word in sort]
    table = table.sort_values(sort_columns, ascending=ascending, kind="stable", ignore_index=True)
    return table[list(columns)] if columns else table


def _formatted(table: pd.DataFrame, form: str, name: str, caption: str) -> str | bytes:
    """The content of a file: csv, parquet, latex or markdown; name and caption are for LaTeX."""
    if form == "csv":
        return as_csv(table)
    if form == "parquet":
        with as_usage_error(ImportError, prefix="Parquet needs pyarrow (pip install pyarrow): "):
            return table.to_parquet(engine="pyarrow", index=False)
    numbers = table.apply(pd.to_numeric, errors="coerce").astype(object)
    mixed = numbers.where(numbers.notna(), table)  # also beside texts, as "not reached"
    return as_latex(mixed, caption, f"tab:{name}") if form == "latex" else as_markdown(mixed)
