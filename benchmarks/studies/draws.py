"""Encounters from a hundred starts: medians and quartiles of errors."""

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
from references.stored.draws import BINARY, BURRAU, DRAWN, DRAWS, draws

COLUMNS = (
    "problem", "contender", "settings", "median", "lower_quartile", "upper_quartile", "largest",
    "seconds", "runs", "status",
)  # fmt: skip
QUICK = 20  # draws
EXPLANATION = (
    "Burrau's problem to t = 63 from starts that differ by 1e-15, where close triples multiply a "
    "rounding by 1e8, so that the error of one run is one draw; and a third star that flies "
    "through a binary, at any phase and distance, to t = 60, each start with a truth of its own in "
    "quadruple precision. Medians and quartiles of the largest error of a coordinate are compared, "
    "and the median time of a run; of an ensemble, which runs in as many threads as there are "
    "processors, the time divided by its members."
)
TITLES = {BURRAU: "Burrau's problem", BINARY: "a binary meets a star"}
ENSEMBLE = "galvi clock, Gauss 8, ensemble"
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
    """One row for each problem, contender and setting."""
    rows, runs = [], QUICK if quick else DRAWS
    for name, problem in TITLES.items():
        for label, contender, setting in PARTICIPANTS:
            report(f"{problem}: {label}, {readable_setting(setting)}")
            first = {"problem": problem, "contender": label, "settings": readable_setting(setting)}
            rows.append({**first, **_measured(name, contender, setting, runs)})
        if galvi.FAST and name == BINARY:
            report(f"{problem}: {ENSEMBLE}")
            for h in (0.6, 0.4):
                first = {"problem": problem, "contender": ENSEMBLE, "settings": f"step={h:g}"}
                rows.append({**first, **_of_ensemble(name, h, runs)})
    return pd.DataFrame(rows, columns=list(COLUMNS))


def _measured(name: str, contender: Contender, setting: Setting, runs: int) -> dict[str, Any]:
    known, duration = draws(name), DRAWN[name].duration
    if contender.missing:
        return {"runs": 0, "status": contender.missing}
    contender.run(known.problem(0), duration, setting)  # compiles
    errors, seconds = [], []
    for k in range(runs):
        run, time = once(lambda k=k: contender.run(known.problem(k), duration, setting))  # type: ignore[misc]
        errors.append(float(np.max(np.abs(run.q[-1] - known.ends[k]))) if run.success else np.inf)
        seconds.append(time)
    return _row(errors, float(np.median(seconds)))


def _of_ensemble(name: str, step: float, runs: int) -> dict[str, Any]:
    """All members by one call."""
    known = draws(name)

    def call() -> galvi.Ensemble:
        return galvi.integrate_ensemble(
            known.problem(0), known.starts[:runs], known.velocities[:runs],
            in_clock(8, galvi.DynamicalTime()).method, step, duration=DRAWN[name].duration,
        )  # fmt: skip

    call()
    found, time = once(call)
    errors = np.max(np.abs(found[0] - known.ends[:runs]), axis=(1, 2))
    return _row(np.where(found.success, errors, np.inf).tolist(), time / runs)


def _row(errors: list[float], seconds: float) -> dict[str, Any]:
    low, middle, high = np.quantile(errors, (0.25, 0.5, 0.75))
    failed = int(np.count_nonzero(np.isinf(errors)))
    return {
        "median": middle, "lower_quartile": low, "upper_quartile": high, "largest": max(errors),
        "seconds": seconds, "runs": len(errors),
        "status": f"{failed} runs failed" if failed else "",
    }  # fmt: skip
