"""The section on a free body in several versions of MuJoCo."""

from __future__ import annotations

import numpy as np
import pandas as pd

from benchmarks.statistics.convergence_fits import algebraic
from benchmarks.studies import engine_versions
from reports.results.section import LongForm, Section
from reports.tables.number_format import readable
from reports.tables.study_table import without_empty_status

ROUND_OFF = 1e-12  # of the attitude, after ten thousand steps
SHOWN = 0.0125  # the step at which errors are shown
JOINTS = ("ball", "free", engine_versions.NESTED)
KEYS = ["engine", "integrator", "joint", "step"]


def engine_versions_table(frame: pd.DataFrame) -> tuple[pd.DataFrame, dict[str, str]]:
    """A line for each version and integrator, and the CSS classes of the columns.

    For each joint: the order of the attitude, fitted over the steps, and the errors at the step
    SHOWN. A missing version has a line with the reason. Where the same version ran twice, the
    stored rows are shown.
    """
    rows = frame.drop_duplicates(KEYS, keep="last")
    absent = set(rows.loc[rows["integrator"] == "", "engine"]) - set(
        rows.loc[rows["integrator"] != "", "engine"]
    )
    lines = []
    for (engine, integrator), runs in rows.groupby(["engine", "integrator"], sort=False):
        if integrator == "" and engine not in absent:
            continue
        line = {"engine": engine, "integrator": integrator}
        for joint in JOINTS:
            line |= _cells(joint, runs[runs["joint"] == joint])
        line["status"] = "; ".join(dict.fromkeys(text for text in runs["status"] if text))
        lines.append(line)
    table = pd.DataFrame(lines).sort_values("engine", key=_by_number, kind="stable")
    numbers = [name for name in table if name not in ("engine", "integrator", "status")]
    table = without_empty_status(table)
    return table, dict.fromkeys(numbers, "number")


def _cells(joint: str, runs: pd.DataFrame) -> dict[str, str]:
    runs = runs.sort_values("step", ascending=False)
    fit = algebraic(list(runs["step"]), list(runs["attitude_error"]), floor=ROUND_OFF)
    at = runs[np.isclose(runs["step"], SHOWN)]
    attitude, energy = (
        float(at[name].iloc[0]) if len(at) else float("nan")
        for name in ("attitude_error", "energy_error")
    )
    return {
        f"order, {joint}": readable(fit.rate),
        f"attitude error, {joint}": readable(attitude),
        f"energy error, {joint}": readable(energy),
    }


def one_version(frame: pd.DataFrame) -> str:
    """That there is nothing to compare with, where this is so."""
    versions = frame.loc[frame["integrator"] != "", "engine"].unique()
    return f"This build has one version, {versions[0]}." if len(versions) == 1 else ""


def _by_number(engines: pd.Series) -> pd.Series:
    """Sort keys that put mujoco 3.6.0 before mujoco 3.10.0."""
    return engines.map(
        lambda name: tuple(int(part) for part in name.split()[-1].split(".") if part.isdigit())
    )


ENGINE_VERSIONS = Section(
    name="engine-versions",
    title="Versions of MuJoCo",
    text="How MuJoCo rotates a free body depends on its version. H's free body for 10 units of "
    "time, on a ball joint and, translating too, on a free joint, there also with half of its "
    "inertia in a body that is fixed in it (nested), by every integrator of each version: the "
    "order of the attitude, fitted over steps from 0.1 to 0.0004, and, at a step of 0.0125, the "
    "largest error of the attitude matrix against the closed form, and of the energy relative to "
    "its initial value. The energy error is no measure of the attitude error.",
    measure=engine_versions.engine_versions,
    table=engine_versions_table,
    summary=one_version,
    long_form=LongForm(engine_versions.parts, engine_versions.stored),
)
