"""Tables of comparisons: the fastest for each error, and matched errors."""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import pandas as pd

from benchmarks.statistics.paired import TIE
from benchmarks.work_precision.asked import errors_of
from benchmarks.work_precision.dependable import bounds, dependable
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
from reports.tables.number_format import TIMES, known, readable, seconds
from reports.tables.targets_table import readable_targets
from reports.tables.writing import write_table


@dataclass(frozen=True, eq=False)
class ComparisonTables:
    """Empty frames where nothing was compared.

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
    """The tables of the rows of `benchmarks.work_precision.run`; `runs` is None if that raised.

    Raises
    ------
    ValueError
        For a cell whose setting was not run.
    """
    if runs is None or runs.empty:
        return ComparisonTables(*(pd.DataFrame() for _ in range(4)))
    runs = dependable(runs)
    times = matched(runs)
    invented = unfounded(times, runs)
    if invented:
        raise ValueError(" ".join(invented))
    return ComparisonTables(
        times, fastest_per_error(runs), smallest(runs), targets_met(runs, targets)
    )


def write_comparison(
    folder: Path, tables: ComparisonTables, origin: Mapping[str, str] | None = None
) -> None:
    """Write the non-empty tables, each as CSV, Markdown and LaTeX."""
    named = (("ratios", tables.ratios), ("choices", tables.fastest), ("smallest", tables.smallest))
    for name, table in named:
        if len(table):
            write_table(folder, name, table, origin=origin)
    if len(tables.targets):
        shown = readable_targets(tables.targets)[0]
        write_table(folder, "targets", tables.targets, shown, origin)


SMALLEST = "its smallest error"
OURS_BEGIN = "galvi"


def is_ours(contender: str) -> bool:
    """Whether this is one of galvi's own methods."""
    return contender.startswith(OURS_BEGIN)


def matched(frame: pd.DataFrame) -> pd.DataFrame:
    """problem, contender, error, seconds, ratio; see `benchmarks.work_precision.fronts.ratios`."""
    found = [ratios(runs, errors_of(runs)) for _, runs in frame.groupby("problem", sort=False)]
    return pd.concat(found, ignore_index=True) if found else ratios(frame, ())


def smallest(frame: pd.DataFrame) -> pd.DataFrame:
    """The same at the smallest error of each contender, and whether that is a `bound` alone; see
    `benchmarks.work_precision.fronts.at_smallest`."""
    ends = at_smallest(frame)
    return ends.assign(bound=bounds(ends, frame))


def readable_ratios(table: pd.DataFrame, ends: pd.DataFrame, problem: str) -> pd.DataFrame:
    """A line for galvi's best, for each other contender, and for galvi against itself, a column for
    each error: ratio with its interval and time, or "not reached"; a tie is called one, and it is
    said how much `closer` than asked its runs are.

    A time of the run that is the reference is marked, as its error is unknown. The last column,
    from `smallest`, is at the contender's own smallest error, with ≤ where that is a bound.
    """
    rows = table[table["problem"] == problem]
    own = ends[ends["problem"] == problem].set_index("contender") if len(ends) else ends
    lines = []
    for contender in compared(rows):
        times = rows[rows["contender"] == contender]
        line = {"contender": contender}
        end = own.loc[contender] if contender in own.index else None
        for _, seen in times.iterrows():
            unknown = known(seen["seconds"]) and (end is None or end["error"] > seen["error"])
            said = _cell(seen, str(contender))
            line[heading(seen["error"])] = f"reference: {said}" if unknown else said
        if end is not None:
            error = f"{'≤ ' * bool(end['bound'])}{readable(end['error'], 2)}"
            line[SMALLEST] = f"{error}: {_cell(end, str(contender))}"
        lines.append(line)
    noise = {
        heading(error): interval_text(here["noise_low"].min(), here["noise_high"].max())
        for error, here in rows.groupby("error", sort=False)
    }
    lines += [{"contender": NOISE, **noise}] if any(noise.values()) else []
    return pd.DataFrame(lines).fillna("")


NOISE = "galvi against itself"


def compared(rows: pd.DataFrame) -> list[str]:
    """The contenders in the rows of `ratios` but galvi's methods, of which the best stands for
    all."""
    names = rows["contender"].drop_duplicates()
    return [str(name) for name in names if name == OURS or not is_ours(str(name))]


def interval_text(low: float, high: float) -> str:
    """E.g. 0.97 to 1.04; "" where unknown."""
    return f"{readable(low, 3)} to {readable(high, 3)}" if known(low) and known(high) else ""


def heading(error: float) -> str:
    """The heading of an error's column, e.g. 10⁻⁶."""
    return readable(error, 1).removeprefix("1·")


def fastest_cells(table: pd.DataFrame, problem: str) -> list[tuple[int, str]]:
    """(line, column) of the least time in each column of `readable_ratios`."""
    rows = table[table["problem"] == problem]
    lines = compared(rows)
    times = rows[rows["contender"].isin(lines) & rows["seconds"].notna()]
    least = times.loc[times.groupby("error")["seconds"].idxmin()]
    return [(lines.index(row["contender"]), heading(row["error"])) for _, row in least.iterrows()]


def _cell(row: pd.Series, contender: str) -> str:
    if not known(row["seconds"]):
        return NOT_REACHED
    close = f", {readable(row['closer'], 1)}{TIMES} closer" if known(row["closer"]) else ""
    if contender == OURS:
        return f"{seconds(row['seconds'])}{close}"
    if not known(row["ratio"]):
        return f"{seconds(row['seconds'])} ({row['ratio']})"
    tie = f"{TIE}, " if row["outcome"] == TIE else ""
    bounds_text = interval_text(row["low"], row["high"])
    said = f"{tie}{readable(row['ratio'], 2)}{TIMES}{f', {bounds_text}' if bounds_text else ''}"
    return f"{said}{close} ({seconds(row['seconds'])})"


OF_RK4 = MUJOCO_RK4.name


def mujoco_overhead(runs: pd.DataFrame) -> str:
    """A sentence from one problem's rows of `benchmarks.work_precision.run`; empty unless both
    codes took part."""
    runs = runs.assign(error=runs.get("own_error", runs["error"]))
    both = runs[runs["contender"].isin((OF_RK4, TEXTBOOK_RK4)) & (runs["seconds"] > 0.0)]
    pairs = both.pivot(index="settings", columns="contender", values=["seconds", "error"]).dropna()
    if pairs.empty or not {OF_RK4, TEXTBOOK_RK4} <= set(both["contender"]):
        return ""
    slower, better = (
        (pairs[what, over] / pairs[what, under]).median()
        for what, over, under in (
            ("seconds", OF_RK4, TEXTBOOK_RK4),
            ("error", TEXTBOOK_RK4, OF_RK4),
        )
    )
    return (
        f"A step of {OF_RK4} takes {readable(slower, 2)} times as long as one of {TEXTBOOK_RK4}, "
        f"at an error {_compared(better)} (medians over {len(pairs)} step sizes): so much of "
        "MuJoCo's time is generality, for joints, contacts and actuators, which a single free body "
        "does not need."
    )


def _compared(better: float) -> str:
    if 0.9 < better < 1.1:
        return "as large"
    return f"{readable(max(better, 1.0 / better), 2)} times {'smaller' if better > 1 else 'larger'}"


NOBODY = "not reached"
ALL, GALVI, ENGINE = "all", "galvi", "MuJoCo"  # groups of contenders
CHOICE = ("contender", "settings", "stops_early", "error", "seconds")
AMONG = {ALL: ALL, GALVI: "galvi's", ENGINE: "MuJoCo's"}


def fastest_per_error(frame: pd.DataFrame, errors: Sequence[float] | None = None) -> pd.DataFrame:
    """For each problem and error: the fastest contender of all, of galvi's, and, where they took
    part, of MuJoCo's integrators, by their times at that error as in `fronts.ratios`.

    A run that is the reference of the others counts as reaching every error; its own is unknown.
    Without `errors`, those at which the problem's contenders are compared.

    Columns problem, asked, of ("all", "galvi" or "MuJoCo"), contender, settings, stops_early,
    error, seconds, bound: its fastest run that reaches the error, and whether that run's error is
    a bound alone.
    """
    rows = []
    for problem, runs in frame.groupby("problem", sort=False):
        groups = {ALL: runs, GALVI: _of(runs, is_ours), ENGINE: _of(runs, _is_mujoco)}
        if not groups[ENGINE]["seconds"].notna().any():
            del groups[ENGINE]
        asked = errors_of(runs) if errors is None else errors
        rows += [
            {"problem": problem, "asked": error, "of": of, **_fastest(among, error)}
            for error in asked
            for of, among in groups.items()
        ]
    table = pd.DataFrame(rows, columns=["problem", "asked", "of", *CHOICE])
    return table.assign(bound=bounds(table, frame))


def readable_fastest(table: pd.DataFrame, problem: str) -> pd.DataFrame:
    """The rows of one problem as text: for each error a line for each choice, with those among
    whom it is the fastest, e.g. "all, galvi's".
    """
    lines = []
    rows = table[table["problem"] == problem]
    for (asked, _), chosen in rows.groupby(["asked", "contender"], sort=False):
        among = ", ".join(AMONG[of] for of in chosen["of"])
        lines.append(_line(heading(asked), among, chosen.iloc[0]))
    return pd.DataFrame(lines)


def of_mujoco(table: pd.DataFrame, problem: str) -> str:
    """A sentence on the fastest of MuJoCo's integrators at each error; empty without them."""
    rows = table[(table["problem"] == problem) & (table["of"] == ENGINE)]
    if rows.empty:
        return ""
    said = [
        f"{contender} for {', '.join(map(heading, chosen['asked']))}"
        for contender, chosen in rows.groupby("contender", sort=False)
        if contender != NOBODY
    ]
    none = [heading(asked) for asked in rows.loc[rows["contender"] == NOBODY, "asked"]]
    said += [f"none reaches {', '.join(none)}"] if none else []
    return f"Of MuJoCo's integrators, the fastest at an error: {'; '.join(said)}."


def _fastest(runs: pd.DataFrame, asked: float) -> dict[str, Any]:
    """The CHOICE among these runs of one problem at this error."""
    each = (fastest(some, asked) for _, some in runs.groupby("contender", sort=False))
    run = min(
        (best for best in each if best is not None), key=lambda row: row["seconds"], default=None
    )
    if run is None:
        nobody = {"contender": NOBODY, "settings": "", "stops_early": False}
        return dict.fromkeys(CHOICE, float("nan")) | nobody
    return dict(run[list(CHOICE)])


def _of(runs: pd.DataFrame, belongs: Callable[[str], bool]) -> pd.DataFrame:
    return runs[runs["contender"].map(belongs)]


def _is_mujoco(contender: str) -> bool:
    return contender.startswith(ENGINE)


def _line(asked: str, what: str, row: pd.Series) -> dict[str, str]:
    return {
        "error asked": asked,
        "among": what,
        "contender": row["contender"],
        "time": seconds(row["seconds"]),
        "setting": _setting(row),
        "error": _error(row),
    }


def _error(row: pd.Series) -> str:
    text = readable(row["error"], 2) or ("truth" if known(row["seconds"]) else "")
    return f"{text} (bound)" if row["bound"] else text


def _setting(row: pd.Series) -> str:
    """With the unit of a step, and whether galvi's iteration ends before it has converged."""
    text, unit = str(row["settings"]), label_of(row["problem"]).time
    text = re.sub(r"(\bstep=\S+)", rf"\1 {unit}", text) if unit else text
    return f"{text} (stopped early)" if row["stops_early"] else text


def energies(runs: pd.DataFrame) -> pd.DataFrame:
    """As text, from one problem's rows of `benchmarks.work_precision.run`: for each contender, of
    galvi's methods the fastest, a column for each error of position, with the relative error of the
    energy at the end of the run that is the fastest to reach it. Empty where none was measured."""
    if "energy" not in runs or not runs["energy"].notna().any():
        return pd.DataFrame()
    counted = dependable(runs)
    names = counted["contender"].map(lambda name: OURS if is_ours(name) else name)
    lines = [
        {"contender": str(name)}
        | {heading(error): _energy(fastest(rows, error)) for error in errors_of(counted)}
        for name, rows in counted.groupby(names, sort=False)
    ]
    table = pd.DataFrame(lines)
    return table[(table.drop(columns="contender") != NOT_REACHED).any(axis="columns")]


def _energy(row: pd.Series | None) -> str:
    return NOT_REACHED if row is None else readable(float(row["energy"]), 2)


def elsewhere(runs: pd.DataFrame, problem: str) -> pd.DataFrame:
    """The readable table of another machine's rows on one problem."""
    counted = dependable(runs[runs["problem"] == problem])
    return readable_ratios(matched(counted), smallest(counted), problem)


def built() -> pd.DataFrame:
    """A line for each code: its options, closed and open, how it was compiled, and the source."""
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
