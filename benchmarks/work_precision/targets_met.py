"""Compare the targets with the work-precision measurements: met, missed or undecided."""

from __future__ import annotations

import math
from collections.abc import Iterable
from typing import Any

import pandas as pd

from benchmarks.work_precision.fronts import NOT_REACHED, OURS, front, ratios
from benchmarks.work_precision.targets import Target

MET, MISSED, NOT_RUN = "met", "missed", "not run"
COLUMNS = (
    *("problem", "against", "counted", "error", "target", "ratio"),
    *("contender", "galvi", "verdict", "remark", "note", "source"),
)


def targets_met(table: pd.DataFrame, targets: Iterable[Target]) -> pd.DataFrame:
    """One row for each target, from the rows of `benchmarks.work_precision.run`.

    against    the rival
    counted    which of galvi's methods count
    error      the target's error, or the rival's smallest; NaN without a run of the rival
    target     least ratio of times; NaN where reaching the error is enough
    ratio      the rival's time over that of the fastest galvi method; 'not reached' where the
               rival's front ends above the error, 'galvi: not reached' where galvi's does
    contender  label of the rival's fastest line at the error; empty when none reaches it
    galvi      the same for galvi
    verdict    met; missed, also when galvi does not reach the error; where the rival does not,
               'not reached', or met when there is no ratio to reach; 'not run' without a run of
               the rival that has an error and a time
    remark     the study's warning about the rival's own error, e.g. a truth hardly more accurate
    note       what has changed since the target was set
    source     origin of the target
    """
    return pd.DataFrame([_row(table, target) for target in targets], columns=list(COLUMNS))


def _row(table: pd.DataFrame, target: Target) -> dict[str, Any]:
    fronts = front(table[table["problem"] == target.problem])
    rival_fronts = fronts[fronts["contender"].isin(target.contenders)]
    error = target.error if target.error is not None else rival_fronts["error"].min()
    row = {
        "problem": target.problem,
        "against": target.against,
        "counted": target.counted,
        "error": error,
        "target": math.nan if target.ratio is None else target.ratio,
        "ratio": math.nan,
        "contender": "",
        "galvi": "",
        "verdict": NOT_RUN,
        "remark": "",
        "note": target.note,
        "source": target.source,
    }
    if rival_fronts.empty:
        return row
    if target.error is None:
        row["remark"] = rival_fronts.loc[rival_fronts["error"].idxmin(), "status"]
    times = ratios(fronts, [error])
    rivals = _fastest(times[times["contender"].isin(target.contenders)])
    names = times["contender"]
    is_galvi = names.str.startswith("galvi") & ~names.isin((OURS, *target.contenders))
    galvi_row = _fastest(
        times[names.isin(target.galvi_contenders) if target.galvi_contenders else is_galvi]
    )
    row |= {"contender": rivals.get("contender", ""), "galvi": galvi_row.get("contender", "")}
    if not galvi_row:
        return row | {"ratio": f"galvi: {NOT_REACHED}", "verdict": MISSED}
    if not rivals:
        return row | {"ratio": NOT_REACHED, "verdict": MET if target.ratio is None else NOT_REACHED}
    ratio = float(rivals["seconds"] / galvi_row["seconds"])
    met = target.ratio is None or ratio >= target.ratio
    return row | {"ratio": ratio, "verdict": MET if met else MISSED}


def _fastest(times: pd.DataFrame) -> dict[str, Any]:
    """The row of least time; empty when no row has a time."""
    timed = times[times["seconds"].notna()]
    return {} if timed.empty else timed.loc[timed["seconds"].idxmin()].to_dict()
