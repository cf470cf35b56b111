"""The command that tabulates errors and orders: CSV, Markdown, LaTeX and a figure."""

from __future__ import annotations

import json
from collections.abc import Mapping
from functools import partial
from pathlib import Path
from typing import Any

import typer

import galvi
from benchmarks.applications.convergence.methods import opened, with_settings
from benchmarks.applications.convergence.table import FAILED, order_table, remarks
from benchmarks.applications.convergence.truth import truth_of_request
from benchmarks.applications.external.integrator import LIMIT
from benchmarks.applications.external.loading import ContenderError, object_at
from benchmarks.applications.external.own_problems import load_problem
from benchmarks.statistics.orders import RULE
from benchmarks.store.atomic import write
from benchmarks.store.foreign_texts import visible
from benchmarks.store.provenance import provenance
from benchmarks.work_precision.galvi_methods import gauss_collocation
from benchmarks.work_precision.problem import galvi_label
from galvi.interop.convergence import ConvergenceRequest, counts_and_sizes
from reports.cli.handed_over import handed_over, show_progress
from reports.cli.option_groups import Convergence
from reports.figures.picture import WIDTHS, sized
from reports.figures.plots.convergence import orders
from reports.figures.style.layout import NoData
from reports.results.section import Figure
from reports.tables.latex import escape
from reports.tables.orders import OrderTable, caption, sentences, write_orders

COMMAND = "convergence"
PICTURES = ("pdf", "svg", "png")
GAUSS = "gauss:"  # before the degree of galvi's Gauss collocation, as --method
progress = partial(show_progress, COMMAND)


def request_of(asked: Convergence, quick: bool) -> ConvergenceRequest:
    """The request that options ask for. Raises ContenderError and ValueError for what is none."""
    problem, duration = load_problem(asked.problem, asked.duration)
    counts, sizes = counts_and_sizes(_steps(asked.steps))
    methods = [*map(_method, asked.method), *(("", path) for path in asked.contender)]
    return ConvergenceRequest(
        problem, tuple(methods), duration, counts, sizes, asked.truth or None, quick,
        with_all=not asked.method,
    )  # fmt: skip


def _steps(text: str) -> list[Any] | None:
    words = text.replace(",", " ").split()
    try:
        return [float(word) if not word.isdigit() else int(word) for word in words] or None
    except ValueError:
        raise ValueError(
            f"--steps expects whole numbers of steps, or sizes, separated by commas; received "
            f"{text!r}."
        ) from None


def _method(word: str) -> tuple[str, Any]:
    """The name, "" for the code's own, and the method of a word of --method."""
    if word.startswith(GAUSS):
        degree = word.removeprefix(GAUSS)
        if not degree.isdigit():
            raise ValueError(f"--method gauss:DEGREE expects a whole number; received {word!r}.")
        return galvi_label(int(degree)), gauss_collocation(int(degree)).method
    if ":" not in word:
        return "", word
    method = object_at(word, "method", "name")
    if not isinstance(method, galvi.Galerkin):
        raise ValueError(
            f"--method {word} must name a galvi.Galerkin; received a {type(method).__name__}. "
            "Integrators of your own are named by --contender."
        )
    return word.partition(":")[2], method


def convergence_command(
    asked: Convergence | Path, quick: bool, timeout: float | None, out: Path, command: str
) -> int:
    """0, or 1 when a run failed.

    asked  or the file of a request that `galvi.convergence` hands over: the rows go back as JSON
    """
    try:
        request: ConvergenceRequest = (
            handed_over(asked, "galvi.convergence")
            if isinstance(asked, Path)
            else request_of(asked, quick)
        )
        table = _table(request, LIMIT if timeout is None else timeout, command)
    except ContenderError as error:
        raise typer.BadParameter(visible(f"{str(error).rstrip('.')}.")) from None
    except (ValueError, TypeError, ModuleNotFoundError) as error:
        raise typer.BadParameter(visible(str(error))) from None
    progress("")
    if isinstance(asked, Path):
        write(out / f"{COMMAND}.json", json.dumps(as_data(table)) + "\n")
        return 0
    files = [*write_orders(table, out), *_draw(table, out)]
    for sentence in sentences(table):
        print(visible(sentence))
    print(f"Tables and figures: {', '.join(str(file) for file in files)}.")
    return int((table.frame["outcome"] == FAILED).any() or bool(table.faults))


def _table(request: ConvergenceRequest, timeout: float, command: str) -> OrderTable:
    with opened(request, timeout) as methods:
        truth = truth_of_request(request, methods, progress)
        participants = with_settings(methods, request, truth)
        frame = order_table(
            request.problem, request.duration, participants, truth, request.quick, progress
        )
        faults = [fault for one in methods.values() for fault in getattr(one, "faults", ())]
    return OrderTable(frame, request.problem, request.duration, truth, faults, provenance(command))


def as_data(table: OrderTable) -> Mapping[str, Any]:
    """What Python gets: the columns, and `attrs` of the frame."""
    return {
        "problem": table.problem.name, "duration": table.duration,
        "truth": table.truth.description, "truth_error": table.truth.error, "rule": RULE,
        "remarks": remarks(table.frame), "faults": table.faults,
        "table": table.frame.to_dict("list"),
    }  # fmt: skip


def _draw(table: OrderTable, folder: Path) -> list[Path]:
    """The figure in the width of a page and of a column, each with its caption; none where no run
    has an error."""
    title = caption(table, "Errors of methods")
    options = {"ylabel": "error of the state at the end"}
    figure = Figure(COMMAND, title, orders, options=options, size=(6.9, 3.4))
    files: list[Path] = []
    for width, inches in WIDTHS.items():
        for form in PICTURES:
            try:
                picture = sized(figure, table.frame, form, inches)
            except NoData:
                return files
            name = COMMAND if width == "page" else f"{COMMAND}-{width}"
            files.append(write(folder / f"{name}.{form}", picture))
    said = f"{title} Filled points are in the fit of the order, or resolved by the truth."
    label = f"\\label{{fig:{COMMAND}}}"
    write(folder / f"{COMMAND}-caption.tex", f"\\caption{{{escape(said)}}}{label}\n")
    return files
