"""`export`: write a table of a report as CSV, Parquet, LaTeX or Markdown, optionally sorted."""

from __future__ import annotations

import io
from collections.abc import Sequence
from pathlib import Path

import pandas as pd
import typer

from benchmarks.store.atomic import write
from references.setting import nearest
from reports.tables.writing import as_csv, as_latex, as_markdown

FORMATS = {"csv": ".csv", "parquet": ".parquet", "latex": ".tex", "markdown": ".md"}
WITHOUT_PARQUET = (
    "Parquet needs pyarrow: pip install pyarrow, or make install EXTRAS=suite,dev,parquet"
)


def export(out: Path, name: str, form: str, sort: Sequence[str], to: Path | None) -> Path:
    """Write the table `name` of the report in `out`; returns the path of the file.

    form  one of FORMATS
    sort  columns, most significant first; "-seconds" sorts in descending order
    to    the output file; None for tables/NAME.SUFFIX in `out`, which a build overwrites

    Numbers have all digits in CSV and Parquet, few in LaTeX and Markdown. Missing values sort last.
    Raises typer.BadParameter for an unknown table, column or format.
    """
    if form not in FORMATS:
        raise typer.BadParameter(
            f"--format expects {', '.join(FORMATS)}; received {form!r}; "
            f"did you mean {nearest(form, FORMATS)!r}?"
        )
    table = ordered(_read(out, name), sort)
    path = to or out / "tables" / f"{name}{FORMATS[form]}"
    if path.is_dir():
        raise typer.BadParameter(f"--to expects a file; received the folder {path}.")
    return write(path, _written(table, form))


def tables(out: Path) -> dict[str, Path]:
    """Paths of a report's tables by name: those beside its page, then those in tables/."""
    beside = {path.stem: path for path in sorted(out.glob("*.csv"))}
    return {path.stem: path for path in sorted((out / "tables").glob("*.csv"))} | beside


def ordered(table: pd.DataFrame, sort: Sequence[str]) -> pd.DataFrame:
    """The rows sorted by these columns, numbers by value; a stable sort."""
    falling = [word.startswith("-") for word in sort]
    columns = [word.removeprefix("-") for word in sort]
    for column in columns:
        if column not in table:
            raise typer.BadParameter(
                f"the table has no column {column!r}; did you mean "
                f"{nearest(column, table.columns)!r} (it has {', '.join(table.columns)})?"
            )
    if not columns:
        return table
    return table.sort_values(
        columns, ascending=[not down for down in falling], kind="stable", na_position="last",
        ignore_index=True,
    )  # fmt: skip


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
        return pd.read_csv(known[name])
    except (OSError, ValueError) as error:  # pandas' own errors are ValueErrors
        why = " ".join(str(error).split())
        raise typer.BadParameter(f"{known[name]} cannot be read: {why}.") from None


def _written(table: pd.DataFrame, form: str) -> str | bytes:
    if form == "csv":
        return as_csv(table)
    if form in ("latex", "markdown"):
        numbers = table.map(_number_or_text)
        return as_latex(numbers) if form == "latex" else as_markdown(numbers)
    into = io.BytesIO()
    try:
        table.to_parquet(into, engine="pyarrow", index=False)
    except ImportError:
        raise typer.BadParameter(f"{WITHOUT_PARQUET}.") from None
    return into.getvalue()


def _number_or_text(cell: object) -> object:
    """Convert a number in a column with texts, such as "not reached", which was read as text."""
    if not isinstance(cell, str):
        return cell
    try:
        return float(cell)
    except ValueError:
        return cell
