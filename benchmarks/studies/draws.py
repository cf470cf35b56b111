"""Burrau's problem a hundred times: errors where close triples multiply each rounding by 1e8."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pandas as pd

import galvi
from benchmarks.statistics.timing import once
from benchmarks.work_precision.galvi_methods import in_clock
from benchmarks.work_precision.participants import readable_setting
from benchmarks.work_precision.problem import Setting
from benchmarks.work_precision.problems.encounters import clock_label
from references import Contender
from references.heyoka import taylor as heyoka_taylor
from references.rebound import ias15
from references.rebound.bulirsch_stoer import BULIRSCH_STOER
from references.stored.draws import DRAWS, DURATION, burrau_draws

COLUMNS = (
    "contender", "settings", "median", "lower_quartile", "upper_quartile", "largest", "seconds",
    "runs", "status",
)  # fmt: skip
QUICK = 20  # draws
EXPLANATION = (
    "Burrau's problem to t = 63 from starts that differ by 1e-15, each with a truth of its own in "
    "quadruple precision. Close triples multiply a rounding by 1e8, so that the error of one run "
    "is one draw: medians and quartiles of the largest error of a coordinate are compared, and the "
    "median time of a run."
)
PARTICIPANTS: tuple[tuple[str, Contender, Setting], ...] = (
    *(
        (clock_label(8), in_clock(8, galvi.DynamicalTime()), {"step": h})
        for h in (0.7, 0.6, 0.5, 0.4, 0.3)
    ),
    ("REBOUND IAS15", ias15.IAS15, {"samples": 1, **ias15.DEFAULT}),
    ("REBOUND IAS15, GLOBAL", ias15.IAS15, {"samples": 1, **ias15.GLOBAL}),
    ("REBOUND BS", BULIRSCH_STOER, {"samples": 1, "tolerance": 1e-13}),
    ("heyoka", heyoka_taylor.HEYOKA, {"samples": 1, **heyoka_taylor.BEST}),
)


def draws_table(
    quick: bool = False, report: Callable[[str], None] = lambda sentence: None
) -> pd.DataFrame:
    """One row for each contender and setting."""
    rows = []
    for label, contender, setting in PARTICIPANTS:
        report(f"{label}, {readable_setting(setting)}")
        rows.append({
            "contender": label, "settings": readable_setting(setting),
            **_measured(contender, setting, QUICK if quick else DRAWS),
        })  # fmt: skip
    return pd.DataFrame(rows, columns=list(COLUMNS))


def _measured(contender: Contender, setting: Setting, runs: int) -> dict[str, Any]:
    known = burrau_draws()
    if contender.missing:
        return {"runs": 0, "status": contender.missing}
    contender.run(known.problem(0), DURATION, setting)  # compiles
    errors, seconds, failed = [], [], 0
    for k in range(runs):
        run, time = once(lambda k=k: contender.run(known.problem(k), DURATION, setting))  # type: ignore[misc]
        error = float(np.max(np.abs(run.q[-1] - known.ends[k]))) if run.success else np.inf
        failed += not run.success
        errors.append(error)
        seconds.append(time)
    low, middle, high = np.quantile(errors, (0.25, 0.5, 0.75))
    return {
        "median": middle, "lower_quartile": low, "upper_quartile": high, "largest": max(errors),
        "seconds": float(np.median(seconds)), "runs": runs,
        "status": f"{failed} runs failed" if failed else "",
    }  # fmt: skip
