"""`export`: a table as CSV, Parquet, LaTeX or Markdown; a figure as PDF, SVG or PNG."""

from __future__ import annotations

import io
import sys
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import pandas as pd
import typer

from benchmarks.store.atomic import write
from benchmarks.store.cells import as_csv, read_csv
from galvi.whole_files import open_descriptor
from references.setting import nearest
from reports.build.kept import kept_claims, kept_comparison, kept_sections
from reports.cli.option_groups import Selection
from reports.figures.drawing import drawable
from reports.figures.picture import WIDTHS, sized
from reports.figures.style.layout import NoData
from reports.results.origins import read_origins
from reports.results.section import Figure
from reports.results.suite import Suite
from reports.tables.latex import as_latex, caption_of, escape
from reports.tables.macros import CLAIMS, numbers
from reports.tables.writing import as_markdown

FORMATS = {"csv": ".csv", "parquet": ".parquet", "latex": ".tex", "markdown": ".md"}
PICTURES = ("pdf", "svg", "png")
NUMBERS = "numbers"  # the name of the macros
STDOUT = Path("-")  # as `--to`
WITHOUT_PARQUET = (
    "Parquet needs pyarrow: pip install pyarrow, or make install EXTRAS=suite,dev,parquet"
)


@dataclass(frozen=True)
class Choice:
    """What of a table is exported.

    sort     columns, most significant first; "-seconds" sorts in descending order
    columns  those to take, in this order; () for all
    where    "column=value": rows to take, which have the value, a text or a number
    """

    sort: tuple[str, ...] = ()
    columns: tuple[str, ...] = ()
    where: tuple[str, ...] = ()


def exported(
    load: Callable[[], Suite], out: Path, selection: Selection, form: str, width: str,
    to: Path | None, choice: Choice,
) -> Iterator[str | Path]:  # fmt: skip
    """Lines of a list, or the paths of files written: one table or figure, or all of them.

    to  of one table or figure: the output file, or STDOUT, which then holds nothing else

    Raises typer.BadParameter as `export` and `export_figure`, and without a name.
    """
    _check_form(form)
    name = selection.name
    if (bool(name) + selection.listed + selection.every) != 1:
        raise typer.BadParameter("export expects a NAME, --list or --all, and one of these.")
    if choice != Choice() and (not name or form in PICTURES):
        raise typer.BadParameter("--sort, --where and --columns are for one table.")
    if form not in PICTURES and name in (*tables(out), NUMBERS):
        yield from export(out, name, form, choice, to)
        return
    suite = load()
    figures = _figures(suite, out)
    if selection.listed:
        yield from (f"{table}  table" for table in tables(out))
        yield from (f"{one}  figure: {figure.title}" for one, (figure, _) in figures.items())
    elif selection.every:
        if to is not None:
            raise typer.BadParameter("--all does not take --to.")
        yield from _all(suite, out, form, width, figures)
    elif form in PICTURES:
        yield from export_figure(suite, out, name, form, width, to)
    elif name in figures:
        raise typer.BadParameter(
            f"{name!r} is a figure, in the formats {', '.join(PICTURES)}; received --format {form}."
        )
    else:
        yield from export(out, name, form, choice, to)


def _all(
    suite: Suite, out: Path, form: str, width: str, figures: Mapping[str, Any]
) -> Iterator[str | Path]:
    """Write all tables, or all figures whose rows are kept; says which cannot be drawn, and why."""
    if form in PICTURES:
        kept = [name for name, (_, frame) in figures.items() if frame is not None]
        if not kept:
            raise typer.BadParameter(f"the rows of no figure are kept in {out}; run build first.")
        for name in kept:
            try:
                yield from export_figure(suite, out, name, form, width, None)
            except NotDrawn as error:
                yield error.message
        return
    if not tables(out):
        raise typer.BadParameter(f"{out} holds no table yet; run compare or build first.")
    for name in tables(out):
        yield from export(out, name, form, Choice(), None)


class NotDrawn(typer.BadParameter):
    """The rows of a figure are there, and show nothing, or it is too narrow."""


def _check_form(form: str) -> None:
    if form not in (*FORMATS, *PICTURES):
        raise typer.BadParameter(
            f"--format expects {', '.join((*FORMATS, *PICTURES))}; received {form!r}; "
            f"did you mean {nearest(form, (*FORMATS, *PICTURES))!r}?"
        )


def export(out: Path, name: str, form: str, choice: Choice, to: Path | None) -> Sequence[Path]:
    """Write the table `name` of the report in `out`; returns the path of the file, as `_exported`.

    name    a table, or NUMBERS for the numbers of the report as LaTeX macros
    form    one of FORMATS
    choice  of rows and columns
    to      the output file; None for tables/NAME.SUFFIX in `out`, which a build overwrites

    Numbers have all digits in CSV and Parquet, few in LaTeX and Markdown. Missing values sort last.
    Raises typer.BadParameter for an unknown table, column or format.
    """
    path = to or out / "tables" / f"{name}{FORMATS[form]}"
    if path.is_dir():
        raise typer.BadParameter(f"--to expects a file; received the folder {path}.")
    if name == NUMBERS and form == "latex":
        if not (out / CLAIMS).is_file():
            raise typer.BadParameter(f"{out} holds no {CLAIMS} yet; run verify or build first.")
        return _exported(path, numbers(out))
    table = chosen(_read(out, name), choice)
    origin = read_origins(out)
    known = origin.get(f"{name}.csv") or origin.get("work_precision.csv") or {}
    return _exported(path, _written(table, form, name, caption_of(name, known)))


def export_figure(
    suite: Suite, out: Path, name: str, form: str, width: str, to: Path | None
) -> Sequence[Path]:
    """Draw the figure `name` from kept rows, in the width of a column or a page, fonts embedded.

    to  the output file; None for figures/NAME-WIDTH.FORM in `out`

    Returns its path, as `_exported`; its caption lies beside it where it is a file.

    Raises typer.BadParameter for an unknown figure or width, and where its rows are not kept.
    """
    if width not in WIDTHS:
        raise typer.BadParameter(f"--width expects {' or '.join(WIDTHS)}; received {width!r}.")
    known = _figures(suite, out)
    if name not in known:
        raise typer.BadParameter(
            f"there is no figure {name!r}; did you mean {nearest(name, known)!r}?"
        )
    figure, frame = known[name]
    path = to or out / "figures" / f"{name}-{width}.{form}"
    if path.is_dir():
        raise typer.BadParameter(f"--to expects a file; received the folder {path}.")
    if frame is None:
        raise typer.BadParameter(f"the rows of {name!r} are not kept in {out}; run build first.")
    try:
        picture = sized(figure, frame, form, WIDTHS[width])
    except NoData as error:
        raise NotDrawn(f"{name!r} cannot be drawn: {error}") from None
    written = _exported(path, picture)
    if not (written and path.is_file()):
        return written
    said = f"{figure.title}. {figure.caption}".strip()
    beside = path.with_name(f"{path.stem}-caption")
    write(beside.with_suffix(".txt"), f"{said}\n")
    write(beside.with_suffix(".tex"), f"\\caption{{{escape(said)}}}\\label{{fig:{name}}}\n")
    return written


def _exported(path: Path, content: str | bytes) -> Sequence[Path]:
    """Write what is exported; returns its path, and nothing where it is in standard output.

    Raises typer.BadParameter where it cannot be written.
    """
    if path == STDOUT:
        if sys.stdout is None:  # as Python has it where the command was started with `>&-`
            raise typer.BadParameter("--to -: standard output is closed.")
        sys.stdout.flush()
        sys.stdout.buffer.write(content.encode() if isinstance(content, str) else content)
        sys.stdout.flush()
        return ()
    try:
        write(path, content)
    except BrokenPipeError:  # whoever reads has seen enough
        raise
    except OSError as error:
        raise typer.BadParameter(f"--to expects a file that can be written; {error}.") from None
    return () if open_descriptor(path) == 1 else (path,)


def _figures(suite: Suite, out: Path) -> dict[str, tuple[Figure, pd.DataFrame | None]]:
    """All figures of a report by name, each with its rows, None where these are not kept."""
    kept = kept_claims(out, suite.claims), kept_comparison(out), kept_sections(out, suite.sections)
    return {figure.name: (figure, frame) for figure, frame in drawable(*kept)}


def tables(out: Path) -> dict[str, Path]:
    """Paths of a report's tables by name: those beside its page, then those in tables/."""
    beside = {path.stem: path for path in sorted(out.glob("*.csv"))}
    return {path.stem: path for path in sorted((out / "tables").glob("*.csv"))} | beside


def chosen(table: pd.DataFrame, choice: Choice) -> pd.DataFrame:
    """The rows and columns of a choice; BadParameter for a column or a value that is not there."""
    for condition in choice.where:
        column, equals, value = condition.partition("=")
        _known_columns(table, [column])
        text = [str(cell) for cell in table[column]]
        same = pd.Series([one == value for one in text], index=table.index, dtype=bool)
        with suppress(ValueError):
            same |= pd.to_numeric(table[column], errors="coerce") == float(value)
        if not equals or not same.any():
            near = f"; did you mean {column}={nearest(value, sorted(set(text)))}?" if text else "."
            raise typer.BadParameter(
                f"--where expects COLUMN=VALUE with a value of the table; received "
                f"{condition!r}{near}"
            )
        table = table[same]
    _known_columns(table, choice.columns)
    table = ordered(table, choice.sort)
    return table[list(choice.columns)] if choice.columns else table


def ordered(table: pd.DataFrame, sort: Sequence[str]) -> pd.DataFrame:
    """The rows sorted by these columns, numbers by value; a stable sort."""
    falling = [word.startswith("-") for word in sort]
    columns = [word.removeprefix("-") for word in sort]
    _known_columns(table, columns)
    if not columns:
        return table
    return table.sort_values(
        columns, ascending=[not down for down in falling], kind="stable", na_position="last",
        ignore_index=True,
    )  # fmt: skip


def _known_columns(table: pd.DataFrame, columns: Sequence[str]) -> None:
    for column in columns:
        if column not in table:
            raise typer.BadParameter(
                f"the table has no column {column!r}; did you mean "
                f"{nearest(column, table.columns)!r} (it has {', '.join(table.columns)})?"
            )


def _read(out: Path, name: str) -> pd.DataFrame:
    known = tables(out)
    if not known:
        raise typer.BadParameter(f"{out} holds no table yet; run compare or build first.")
    if name not in known:
        raise typer.BadParameter(
            f"there is no table {name!r}; did you mean {nearest(name, known)!r} "
            f"(known: {', '.join(known)})?"
        )
    try:
        return read_csv(known[name])
    except (OSError, ValueError) as error:  # pandas' own errors are ValueErrors
        why = " ".join(str(error).split())
        raise typer.BadParameter(f"{known[name]} cannot be read: {why}.") from None


def _written(table: pd.DataFrame, form: str, name: str, caption: str) -> str | bytes:
    if form == "csv":
        return as_csv(table)
    if form in ("latex", "markdown"):
        numbers = table.apply(pd.to_numeric, errors="coerce").astype(object)
        table = numbers.where(numbers.notna(), table)  # also beside texts, as "not reached"
        return as_latex(table, caption, f"tab:{name}") if form == "latex" else as_markdown(table)
    into = io.BytesIO()
    try:
        table.to_parquet(into, engine="pyarrow", index=False)
    except ImportError:
        raise typer.BadParameter(f"{WITHOUT_PARQUET}.") from None
    return into.getvalue()
