"""MuJoCo's overhead for generality: its RK4 against a textbook RK4 at the same steps."""

from __future__ import annotations

import pandas as pd

from benchmarks.work_precision.problems.rigid_bodies import TEXTBOOK_RK4
from references.mujoco.steps import MUJOCO_RK4
from reports.tables.number_format import readable

ENGINE = MUJOCO_RK4.name


def mujoco_overhead(runs: pd.DataFrame) -> str:
    """A sentence from one problem's rows of `benchmarks.work_precision.run`; empty unless both
    codes took part."""
    both = runs[runs["contender"].isin((ENGINE, TEXTBOOK_RK4)) & (runs["seconds"] > 0.0)]
    pairs = both.pivot(index="settings", columns="contender", values=["seconds", "error"]).dropna()
    if pairs.empty or not {ENGINE, TEXTBOOK_RK4} <= set(both["contender"]):
        return ""
    slower, better = (
        (pairs[what, over] / pairs[what, under]).median()
        for what, over, under in (
            ("seconds", ENGINE, TEXTBOOK_RK4),
            ("error", TEXTBOOK_RK4, ENGINE),
        )
    )
    return (
        f"A step of {ENGINE} takes {readable(slower, 2)} times as long as one of {TEXTBOOK_RK4}, "
        f"at an error {_compared(better)} (medians over {len(pairs)} step sizes): so much of "
        "MuJoCo's time is generality, for joints, contacts and actuators, which a single free body "
        "does not need."
    )


def _compared(better: float) -> str:
    if 0.9 < better < 1.1:
        return "as large"
    return f"{readable(max(better, 1.0 / better), 2)} times {'smaller' if better > 1 else 'larger'}"
