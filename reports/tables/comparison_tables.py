"""Tables of comparisons: the fastest for each error, and matched errors."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import pandas as pd

from benchmarks.statistics.paired import TIE, UNRESOLVED
from benchmarks.work_precision.asked import errors_of
from benchmarks.work_precision.dependable import error_is_bound
from benchmarks.work_precision.fronts import (
    NOT_REACHED,
    OURS,
    at_smallest,
    fastest,
    ratios,
    unfounded,
)
from benchmarks.work_precision.labels import label_of
from benchmarks.work_precision.participants import readable_setting
from benchmarks.work_precision.peers import PEERS
from benchmarks.work_precision.problems.rigid_bodies import TEXTBOOK_RK4
from benchmarks.work_precision.targets import Target
from benchmarks.work_precision.targets_met import targets_met
from references.mujoco.steps import MUJOCO_RK4
from reports.tables.number_format import TIMES, is_finite, readable, seconds
from reports.tables.targets_table import readable_targets
from reports.tables.writing import write_table


@dataclass(frozen=True, eq=False)
class ComparisonTables:
    """Empty tables where nothing was compared.

    Attributes
    ----------
    ratios
        times at matched errors
    fastest
        the fastest code for each error, and its run
    smallest
        times at the smallest error of each contender
    targets
        targets with the measured ratios
    """

    ratios: pd.DataFrame
    fastest: pd.DataFrame
    smallest: pd.DataFrame
    targets: pd.DataFrame


def comparison_tables(runs: pd.DataFrame | None, targets: Sequence[Target]) -> ComparisonTables:
    """The tables of the rows of `benchmarks.work_precision.run`; empty ones if `runs` is None.

    Raises
    ------
    ValueError
        For a time that belongs to no run.
    """
    if runs is None or runs.empty:
        return ComparisonTables(*(pd.DataFrame() for _ in range(4)))
    times = matched(runs)
    objections = unfounded(times, runs)
    if objections:
        raise ValueError(" ".join(objections))
    return ComparisonTables(
        times, fastest_per_error(times, runs), smallest(runs), targets_met(runs, targets)
    )


def write_comparison(
    folder: Path, tables: ComparisonTables, origin: Mapping[str, str] | None = None
) -> None:
    """Write the non-empty tables, each as CSV, Markdown and LaTeX."""
    named_tables = (
        ("ratios", tables.ratios),
        ("choices", tables.fastest),
        ("smallest", tables.smallest),
    )
    for name, table in named_tables:
        if len(table):
            write_table(folder, name, table, origin=origin)
    if len(tables.targets):
        shown = readable_targets(tables.targets)[0]
        write_table(folder, "targets", tables.targets, shown, origin)


SMALLEST_HEADING = "its smallest error"
OURS_PREFIX = "galvi"


def is_galvi(contender: str) -> bool:
    """Whether this is one of galvi's own methods."""
    return contender.startswith(OURS_PREFIX)


def matched(table: pd.DataFrame) -> pd.DataFrame:
    """The times and ratios of all problems at their errors, as of
    `benchmarks.work_precision.fronts.ratios`."""
    parts = [ratios(runs, errors_of(runs)) for _, runs in table.groupby("problem", sort=False)]
    return pd.concat(parts, ignore_index=True) if parts else ratios(table, ())


def smallest(table: pd.DataFrame) -> pd.DataFrame:
    """Times at the smallest error of each contender, and whether that is a `bound` alone; see
    `benchmarks.work_precision.fronts.at_smallest`."""
    ends = at_smallest(table)
    return ends.assign(bound=error_is_bound(ends, table))


def compared(table: pd.DataFrame, problem: str) -> pd.DataFrame:
    """The rows of one problem in a table of `ratios`; of galvi's methods only those of OURS."""
    rows = table[table["problem"] == problem]
    return rows[(rows["contender"] == OURS) | ~rows["contender"].map(is_galvi).astype(bool)]


def readable_ratios(
    table: pd.DataFrame, smallest_table: pd.DataFrame, problem: str
) -> pd.DataFrame:
    """A line for galvi's best, for each other contender, and for galvi against itself, and a column
    for each error.

    A cell has the ratio with its interval and the time, or "not reached". It names a tie, and says
    how many times `closer` to the truth than asked the contender's loosest run is. Times of the
    reference run are marked, since its error is unknown. The last column, from `smallest`, is for
    the contender's smallest error, with ≤ if that is a bound.

    Parameters
    ----------
    table
        as of `matched`
    ends
        as of `smallest`
    """
    times, last = (
        _with_cells(compared(table, problem)),
        _with_cells(compared(smallest_table, problem)),
    )
    smallest_errors = times["contender"].map(last.set_index("contender")["error"])
    is_reference = times["seconds"].notna() & ~(smallest_errors <= times["error"])
    times["cell"] = times["cell"].mask(is_reference, "reference: " + times["cell"])
    bound = last["bound"].map({True: "≤ ", False: ""})
    last["cell"] = bound + last["error"].map(two_digits) + ": " + last["cell"]
    noise = times.groupby("heading", sort=False).agg({"noise_low": "min", "noise_high": "max"})
    noise["cell"] = [*map(interval_text, noise["noise_low"], noise["noise_high"])]
    lines = pd.concat(
        [
            times,
            last.assign(heading=SMALLEST_HEADING),
            noise[noise["cell"] != ""].reset_index().assign(contender=NOISE_LABEL),
        ]
    )
    cells = lines.set_index(["contender", "heading"])["cell"].unstack(sort=False).fillna("")
    return cells.rename_axis(columns=None).reset_index()


def _with_cells(rows: pd.DataFrame) -> pd.DataFrame:
    cells = pd.Series([*map(_time_cell, rows.to_dict("records"))], rows.index, dtype=object)
    return rows.assign(heading=rows["error"].map(heading), cell=cells)


NOISE_LABEL = "galvi against itself"


def interval_text(low: float, high: float) -> str:
    """An interval as text, e.g. 0.97 to 1.04; "" if it is unknown."""
    return (
        f"{readable(low, 3)} to {readable(high, 3)}" if is_finite(low) and is_finite(high) else ""
    )


def heading(error: float) -> str:
    """The heading of an error's column, e.g. 10⁻⁶."""
    return readable(error, 1).removeprefix("1·")


def two_digits(number: float) -> str:
    """A number as text with two digits."""
    return readable(number, 2)


def fastest_cells(table: pd.DataFrame, problem: str) -> list[tuple[int, str]]:
    """(line, column) of the smallest time in each column of `readable_ratios`."""
    rows = compared(table, problem)
    lines = list(rows["contender"].unique())
    fastest_rows = rows.loc[rows.dropna(subset="seconds").groupby("error")["seconds"].idxmin()]
    return [
        (lines.index(name), heading(error))
        for name, error in zip(fastest_rows["contender"], fastest_rows["error"], strict=True)
    ]


def _time_cell(row: Mapping[str, Any]) -> str:
    if not is_finite(row["seconds"]):
        return NOT_REACHED
    closeness = f", {readable(row['closer'], 1)}{TIMES} closer" if is_finite(row["closer"]) else ""
    if row["contender"] == OURS:
        return f"{seconds(row['seconds'])}{closeness}"
    if not is_finite(row["ratio"]):
        return f"{seconds(row['seconds'])} ({row['ratio']})"
    tie = f"{TIE if row['low'] <= 1.0 <= row['high'] else UNRESOLVED}, " * (row["outcome"] == TIE)
    interval = interval_text(row["low"], row["high"])
    ratio = f"{readable(row['ratio'], 2)}{TIMES}{', ' * bool(interval)}{interval}"
    return f"{tie}{ratio}{closeness} ({seconds(row['seconds'])})"


RK4_NAME = MUJOCO_RK4.name


def mujoco_overhead(runs: pd.DataFrame) -> str:
    """A sentence that compares the steps of MuJoCo's RK4 and of a textbook's on one problem.

    "" unless both were timed at the same settings. `runs` are the problem's rows of
    `benchmarks.work_precision.run`.
    """
    timed = runs[runs["seconds"] > 0.0].set_index("settings")[["contender", "seconds", "own_error"]]
    mujoco, textbook = (
        timed[timed["contender"] == name].drop(columns="contender")
        for name in (RK4_NAME, TEXTBOOK_RK4)
    )
    times_of_textbook = (mujoco / textbook).dropna()
    if times_of_textbook.empty:
        return ""
    slower = times_of_textbook["seconds"].median()
    error_ratio = (1.0 / times_of_textbook["own_error"]).median()
    return (
        f"A step of {RK4_NAME} takes {two_digits(slower)} times as long as one of {TEXTBOOK_RK4}, "
        f"at an error {_error_ratio_text(error_ratio)} (medians over {len(times_of_textbook)} "
        "step sizes): so "
        "much of MuJoCo's time is generality, for joints, contacts and actuators, which a single "
        "free body does not need."
    )


def _error_ratio_text(error_ratio: float) -> str:
    if 0.9 < error_ratio < 1.1:
        return "as large"
    size = two_digits(max(error_ratio, 1.0 / error_ratio))
    return f"{size} times {'smaller' if error_ratio > 1 else 'larger'}"


NOBODY = "not reached"
ALL, GALVI, ENGINE = "all", "galvi", "MuJoCo"  # groups of contenders
NAME_PREFIXES = {ALL: "", GALVI: OURS_PREFIX, ENGINE: "MuJoCo"}  # of the names in a group
GROUP_TEXTS = {ALL: ALL, GALVI: "galvi's", ENGINE: "MuJoCo's"}
CHOICE_COLUMNS = (
    *("problem", "asked", "of", "contender", "settings", "stops_early", "error", "seconds"),
    "bound",
)


def fastest_per_error(times: pd.DataFrame, runs: pd.DataFrame) -> pd.DataFrame:
    """For each problem and error of `ratios`, the fastest contender of all, of galvi's methods,
    and, if they took part, of MuJoCo's integrators.

    The reference run, whose own error is unknown, counts as reaching every error.

    Columns problem, asked (the error), of ("all", "galvi" or "MuJoCo"), contender, settings,
    stops_early, error, seconds, bound: the fastest run that reaches the error, and whether that
    run's error is a bound.
    """
    cells = times.rename(columns={"error": "asked"})
    cells["line"] = cells.groupby(["problem", "asked"], sort=False).ngroup()
    named = cells[(cells["contender"] != OURS) | cells["seconds"].isna()]
    by_time = named.sort_values("seconds", kind="stable")
    choices = [
        by_time[by_time["contender"].str.startswith(beginning)]
        .drop_duplicates("line")
        .assign(of=of)
        for of, beginning in NAME_PREFIXES.items()
    ]
    run = ["problem", "contender", "settings", "seconds"]
    measured = runs[[*run, "stops_early", "error"]].drop_duplicates(run)
    table = pd.concat(choices).sort_values("line", kind="stable").merge(measured, "left", run)
    table["contender"] = table["contender"].mask(table["seconds"].isna(), NOBODY)
    table["stops_early"] = table["stops_early"].eq(True)
    return table.assign(bound=error_is_bound(table, runs))[list(CHOICE_COLUMNS)]


def fastest_lines(table: pd.DataFrame) -> pd.DataFrame:
    """The rows of `fastest_per_error` as text: for each problem and error, a line for each distinct
    contender, with the groups of which it is the fastest, e.g. "all, galvi's"."""
    choice = [table["problem"], table["asked"], table["contender"]]
    labels = table["problem"].map(label_of)
    truth = table["error"].isna() & table["seconds"].notna()
    lines = pd.DataFrame(
        {
            "problem": [label.title for label in labels],
            "error asked": table["asked"].map(heading),
            "among": table["of"].map(GROUP_TEXTS).groupby(choice).transform(", ".join),
            "contender": table["contender"],
            "time": table["seconds"].map(seconds),
            "setting": [
                re.sub(r"\bstep=\S+", rf"\g<0> {label.time}".rstrip(), text)
                for text, label in zip(table["settings"], labels, strict=True)
            ],
            "its error": table["error"].map(two_digits).mask(truth, "truth"),
        }
    )
    lines["setting"] += table["stops_early"].map({True: " (stopped early)", False: ""})
    lines["its error"] += table["bound"].map({True: " (bound)", False: ""})
    return lines[~table.duplicated(["problem", "asked", "contender"])].reset_index(drop=True)


def of_mujoco(table: pd.DataFrame, problem: str) -> str:
    """A sentence on the fastest of MuJoCo's integrators at each error; empty without them."""
    rows = table[(table["problem"] == problem) & (table["of"] == ENGINE)]
    errors = rows["asked"].map(heading).groupby(rows["contender"], sort=False).agg(", ".join)
    parts = [
        f"none reaches {listed}" if name == NOBODY else f"{name} for {listed}"
        for name, listed in errors.items()
    ]
    return f"Of MuJoCo's integrators, the fastest at an error: {'; '.join(parts)}." if parts else ""


def energies(runs: pd.DataFrame) -> pd.DataFrame:
    """Relative energy errors at the end of runs, as text: a line for each contender, where galvi's
    methods are one, and a column for each error of the comparison.

    A cell is for the contender's fastest run that reaches the error. Empty if no energy was
    measured. `runs` are one problem's rows of `benchmarks.work_precision.run`.
    """
    if "energy" not in runs or not runs["energy"].notna().any():
        return pd.DataFrame()
    names = runs["contender"].map(lambda name: OURS if is_galvi(name) else name)
    lines = [
        {"contender": str(name)}
        | {heading(error): _energy(fastest(rows, error)) for error in errors_of(runs)}
        for name, rows in runs.groupby(names, sort=False)
    ]
    table = pd.DataFrame(lines)
    return table[(table.drop(columns="contender") != NOT_REACHED).any(axis="columns")]


def _energy(row: pd.Series | None) -> str:
    return NOT_REACHED if row is None else two_digits(row["energy"])


def elsewhere(runs: pd.DataFrame, problem: str) -> pd.DataFrame:
    """The table of `readable_ratios` of another machine's rows on one problem."""
    rows = runs[runs["problem"] == problem]
    return readable_ratios(matched(rows), smallest(rows), problem)


def built() -> pd.DataFrame:
    """A line for each code: its fixed and its varied options, how it was compiled, and where that
    is documented."""
    return pd.DataFrame(
        [
            {
                "code": code,
                "closed": readable_setting(peer.closed),
                "open": "; ".join(peer.open),
                "compiled": peer.built,
                "documented": peer.source.removeprefix("https://"),
            }
            for code, peer in PEERS.items()
        ]
    )
