"""`convergence`: errors and orders of methods as CSV, Markdown, LaTeX and a figure."""

from __future__ import annotations

import json
from collections.abc import Sequence
from contextlib import suppress
from functools import partial
from pathlib import Path
from typing import Any

import galvi
from benchmarks.applications.convergence import table as rows
from benchmarks.applications.convergence.methods import opened, with_settings
from benchmarks.applications.convergence.truth import truth_of_request
from benchmarks.applications.external.integrator import TIME_LIMIT
from benchmarks.applications.external.loading import ContenderError, object_at
from benchmarks.applications.external.own_problems import load_problem
from benchmarks.statistics.orders import RULE
from benchmarks.store.atomic import write
from benchmarks.store.foreign_texts import visible
from benchmarks.store.provenance import provenance
from benchmarks.work_precision.galvi_methods import gauss_collocation
from benchmarks.work_precision.problem import galvi_label
from galvi.interop.convergence import ConvergenceRequest, counts_and_sizes
from reports.cli.export import PICTURE_FORMATS, write_figure
from reports.cli.handed_over import show_progress
from reports.figures.plots.convergence import orders
from reports.figures.style.layout import NoData
from reports.results.section import Figure
from reports.tables.orders import OrderTable, caption, sentences, write_orders

COMMAND = "convergence"
GAUSS_PREFIX = "gauss:"  # before the degree of galvi's Gauss collocation, as --method
REFUSALS = (ContenderError, ValueError, TypeError, ModuleNotFoundError)
progress = partial(show_progress, COMMAND)


def request_of(
    problem: str,
    methods: Sequence[str],
    contenders: Sequence[str],
    steps: Sequence[int | float] | None,
    duration: float | None,
    truth: str | None,
    quick: bool,
) -> ConvergenceRequest:
    """The request that options ask for.

    Raises
    ------
    ContenderError, ValueError
        For texts that name no method, problem or steps.
    """
    loaded_problem, loaded_duration = load_problem(problem, duration)
    counts, sizes = counts_and_sizes(steps)
    named_methods = [*map(_parse_method, methods), *(("", path) for path in contenders)]
    return ConvergenceRequest(
        loaded_problem,
        tuple(named_methods),
        loaded_duration,
        counts,
        sizes,
        truth,
        quick,
        with_all=not methods,
    )


def _parse_method(word: str) -> tuple[str, Any]:
    """(name, method) of a word of --method; the name is "" where the method has its own.

    Raises
    ------
    ValueError
        For a degree that is no whole number, and for a path to another object than a
        galvi.Galerkin.
    ContenderError
        For a path that cannot be loaded.
    """
    if word.startswith(GAUSS_PREFIX):
        degree = word.removeprefix(GAUSS_PREFIX)
        if not degree.isdigit():
            raise ValueError(f"--method gauss:DEGREE expects a whole number; received {word!r}.")
        return galvi_label(int(degree)), gauss_collocation(int(degree)).method
    if ":" not in word:
        return "", word
    method = object_at(word, "method", "name")
    if not isinstance(method, galvi.Galerkin):
        raise ValueError(
            f"--method {word} must name a galvi.Galerkin; received a {type(method).__name__}. "
            "Name an integrator of your own with --contender."
        )
    return word.partition(":")[2], method


def order_table(request: ConvergenceRequest, timeout: float | None, command: str) -> OrderTable:
    """The order table of a request. Progress goes to stderr. Raises REFUSALS if it cannot run."""
    with opened(request, timeout or TIME_LIMIT) as methods:
        truth = truth_of_request(request, methods, progress)
        participants = with_settings(methods, request, truth)
        table = rows.order_table(
            request.problem, request.duration, participants, truth, request.quick, progress
        )
        faults = [fault for method in methods.values() for fault in getattr(method, "faults", ())]
    progress("")
    return OrderTable(table, request.problem, request.duration, truth, faults, provenance(command))


def write_json(table: OrderTable, out: Path) -> int:
    """Write the JSON from which `galvi.convergence` makes a table with `attrs`; returns 0."""
    document = {
        "problem": table.problem.name,
        "duration": table.duration,
        "truth": table.truth.description,
        "truth_error": table.truth.error,
        "rule": RULE,
        "remarks": rows.remarks(table.rows),
        "faults": table.faults,
        "table": table.rows.to_dict("list"),
    }
    write(out / f"{COMMAND}.json", json.dumps(document) + "\n")
    return 0


def write_results(table: OrderTable, out: Path) -> int:
    """Write tables and figures, and print the orders; returns 1 if a run failed, else 0."""
    files = [*write_orders(table, out), *_figures(table, out)]
    for sentence in sentences(table):
        print(visible(sentence))
    print(f"Tables and figures: {', '.join(map(str, files))}.")
    return int((table.rows["outcome"] == rows.FAILED).any() or bool(table.faults))


def _figures(table: OrderTable, folder: Path) -> list[Path]:
    """Write the figure in the width of a page and of a column; returns the paths, an empty list
    where no run has an error."""
    figure = Figure(
        COMMAND,
        caption(table, "Errors of methods"),
        orders,
        options={"ylabel": "error of the state at the end"},
        size=(6.9, 3.4),
        caption="Filled points are in the fit of the order, or resolved by the truth.",
    )
    files: list[Path] = []
    for name, width in ((COMMAND, "page"), (f"{COMMAND}-column", "column")):
        for file_format in PICTURE_FORMATS:
            with suppress(NoData):
                path = folder / f"{name}.{file_format}"
                files.append(write_figure(figure, table.rows, path, file_format, width))
    return files
