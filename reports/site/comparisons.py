"""Texts and tables of the pages of comparisons and results, from the rows of a comparison."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import pandas as pd

from benchmarks.checks.bounds import NOT_RUN
from benchmarks.checks.claim import Row
from benchmarks.work_precision.fronts import fastest
from benchmarks.work_precision.labels import label_of
from references.mujoco.steps import DEFAULT_STEP, MUJOCO_RK4
from reports.figures.work_precision import at_step
from reports.results.summary import count_of
from reports.tables.comparison_tables import GROUP_TEXTS, fastest_lines, heading, is_galvi
from reports.tables.number_format import TIMES, readable, seconds

ENGINES = {
    "rebound": "REBOUND",
    "mujoco-core": "MuJoCo",
    "scipy": "SciPy",
    "heyoka": "heyoka",
}
NOT_INSTALLED = "not installed"
FILTER_COLUMNS = (
    "problem",
    "error asked",
    "among",
)  # columns with a filter
GROUP_LIMITS = 1e-9, 1e-6  # errors between the groups of problems at MuJoCo's default step


@dataclass(frozen=True)
class AbsentEngine:
    """An engine that was not installed.

    Attributes
    ----------
    text
        a sentence on the missing rows
    reason
        the status of its runs, with the remedy; "" if no such run was requested
    """

    name: str
    text: str
    reason: str


def installed_engines(origin: Mapping[str, str]) -> str:
    """The names of the ENGINES that were installed, e.g. "REBOUND, MuJoCo and SciPy"."""
    *first, last = [name for key, name in ENGINES.items() if origin.get(key) != NOT_INSTALLED]
    return f"{', '.join(first)} and {last}" if first else last


def absent_engines(
    origin: Mapping[str, str],
    runs: pd.DataFrame | None,
    targets: pd.DataFrame,
    rows: Sequence[Row],
) -> tuple[AbsentEngine, ...]:
    """The ENGINES that were not installed, by the versions in the origin of the comparisons."""
    return tuple(
        _absent_engine(package, name, runs, targets, rows)
        for package, name in ENGINES.items()
        if origin.get(package) == NOT_INSTALLED
    )


def is_run_by(engine: str, contender: str) -> bool:
    """Whether a contender's name begins with the name of this engine."""
    return contender.split(",")[0].split(" ")[0] == engine


def _absent_engine(
    package: str, name: str, runs: pd.DataFrame | None, targets: pd.DataFrame, rows: Sequence[Row]
) -> AbsentEngine:
    missing = ["its times"]
    if len(targets):
        of_engine = targets[[is_run_by(name, contender) for contender in targets["against"]]]
        unmet = int((of_engine["verdict"] == NOT_RUN).sum())
        missing += [count_of(unmet, "target")] if unmet else []
    ids = dict.fromkeys(row.id for row in rows if row.verdict == NOT_RUN and row.absent == package)
    missing += [f"rows of {', '.join(ids)}"] if ids else []
    listed = " and ".join(filter(None, (", ".join(missing[:-1]), missing[-1])))
    reasons = (
        []
        if runs is None
        else [
            status
            for contender, status in zip(runs["contender"], runs["status"], strict=True)
            if is_run_by(name, contender) and status
        ]
    )
    text = (
        f"{name} was not installed for this build: {listed} are missing, and "
        f"rankings exclude {name}."
    )
    return AbsentEngine(name, text, reasons[0] if reasons else "")


def filters(choices: pd.DataFrame) -> list[tuple[int, str, list[str]]]:
    """(column, heading, values) of each filter of `fastest_lines`; errors from large to small."""
    table = fastest_lines(choices)
    values = (
        list(dict.fromkeys(table["problem"])),
        [heading(error) for error in sorted(set(choices["asked"]), reverse=True)],
        [text for name, text in GROUP_TEXTS.items() if (choices["of"] == name).any()],
    )
    return [
        (list(table).index(name), name, texts)
        for name, texts in zip(FILTER_COLUMNS, values, strict=True)
    ]


@dataclass(frozen=True, eq=False)
class DefaultStep:
    """MuJoCo's RK4 at its default step: sentences on its errors, and a line for each problem."""

    text: str
    table: pd.DataFrame


def default_step(runs: pd.DataFrame | None) -> DefaultStep | None:
    """The errors of MuJoCo's RK4 at its default step; None if there are no runs at that step."""
    errors, lines = {}, []
    for problem, rows in runs.groupby("problem", sort=False) if runs is not None else ():
        reached = at_step(rows, MUJOCO_RK4.name, DEFAULT_STEP)
        if reached is None:
            continue
        error, time = reached
        galvi_run = fastest(rows[rows["contender"].map(is_galvi)], error)
        best = float("nan") if galvi_run is None else float(galvi_run["seconds"])
        title = label_of(str(problem)).title
        errors[title] = error
        lines.append(
            {
                "problem": title,
                "error": readable(error, 2),
                "quantity": str(rows["quantity"].iloc[0]),
                "time of MuJoCo's RK4": seconds(time),
                "galvi's time": seconds(best) or "not reached",
                "galvi is faster by": f"{readable(time / best, 2)}{TIMES}" if best == best else "",
            }
        )
    if not lines:
        return None
    text = (
        f"Its error at a step of {DEFAULT_STEP:g}. {_errors_by_size(errors)} Errors are those at "
        "the end "
        "of the comparison's run."
    )
    return DefaultStep(text, pd.DataFrame(lines))


def _errors_by_size(errors: Mapping[str, float]) -> str:
    """Sentences that list the problems and their errors, grouped by GROUP_LIMITS."""
    small, large = map(heading, GROUP_LIMITS)
    groups: dict[str, list[str]] = {
        f"Below {small}": [],
        f"Between {small} and {large}": [],
        f"Above {large}": [],
    }
    for name, error in errors.items():
        group = sum(error >= limit for limit in GROUP_LIMITS)
        list(groups.values())[group].append(f"{name} ({readable(error, 2)})")
    return " ".join(f"{title}: {'; '.join(names)}." for title, names in groups.items() if names)
