"""The sections that set galvi beside other engines: trees of bodies, versions of MuJoCo, an
ephemeris, forces."""

from __future__ import annotations

import math
import re

import numpy as np
import pandas as pd

from benchmarks.statistics.convergence_fits import Fit, algebraic
from benchmarks.studies import engine_versions, ephemeris, forces, trees
from references.heyoka.taylor import HEYOKA_QUADRUPLE
from references.jpl.ephemeris import JPL_EPHEMERIS
from reports.results.section import LongForm, Section
from reports.tables.number_format import readable, seconds, with_uncertainty
from reports.tables.study_table import readable_table

TREE_ERROR = 1e-6  # error to which the times in the last column on trees belong
TREE_ROUND_OFF = 1e-13  # of the errors on trees
TREE_COLUMNS = {
    "problem": "tree",
    "contender": "integrator",
    "order": "order",
    "measured": "measured",
    "step": "step, coarse",
    "error": "error",
    "fine_step": "step, fine",
    "fine_error": "error then",
    "seconds_per_step": "time per step",
    "time_to_error": f"time to {TREE_ERROR:g}",
}
TREE_FORMATS = {
    "measured": readable,
    "error": readable,
    "fine_error": readable,
    "seconds_per_step": seconds,
    "time_to_error": seconds,
}


def orders(table: pd.DataFrame) -> dict[tuple[str, str], Fit]:
    """(tree, integrator) -> the fit of its order, to errors above ten times that of the truth and
    TREE_ROUND_OFF."""
    return {
        (str(problem), str(contender)): algebraic(
            list(rows["step"]),
            list(rows["error"]),
            floor=10.0 * float(rows["unsure"].iloc[0]) + TREE_ROUND_OFF,
        )
        for (problem, contender), rows in table.groupby(["problem", "contender"], sort=False)
    }


def trees_table(table: pd.DataFrame) -> tuple[pd.DataFrame, dict[str, str]]:
    """A line for each tree and integrator, and the CSS classes of the columns."""
    if table["problem"].isna().all():
        return table[["status"]], {}
    lines = []
    for (problem, contender), fit in orders(table).items():
        rows = table[(table["problem"] == problem) & (table["contender"] == contender)]
        finest = rows.iloc[-1]
        step = (TREE_ERROR / fit.coefficient) ** (1.0 / fit.rate) if fit.points else math.nan
        lines.append(
            rows.iloc[0].to_dict()
            | {
                "measured": with_uncertainty(fit.rate, fit.uncertainty),
                "fine_step": finest["step"],
                "fine_error": finest["error"],
                "seconds_per_step": finest["seconds_per_step"],
                "time_to_error": finest["seconds_per_step"]
                * finest["step"]
                * finest["steps"]
                / step,
            }
        )
    return readable_table(pd.DataFrame(lines), TREE_COLUMNS, TREE_FORMATS)


TREES = Section(
    name="trees",
    title="Trees of rigid bodies",
    text=trees.EXPLANATION,
    measure=trees.tree_study,
    table=trees_table,
    timed=True,
)


ATTITUDE_FLOOR = 1e-12  # round-off of the attitude, after ten thousand steps
SHOWN_STEP = 0.0125  # the step at which errors are shown
JOINTS = ("ball", "free", engine_versions.NESTED)
RUN_KEYS = ["engine", "integrator", "joint", "step"]


def engine_versions_table(observations: pd.DataFrame) -> tuple[pd.DataFrame, dict[str, str]]:
    """A line for each version and integrator, and the CSS classes of the columns.

    For each joint: the order of the attitude, fitted over the steps, and the errors at the step
    SHOWN_STEP. A missing version has a line with the reason. Where the same version ran twice, the
    stored rows are shown.
    """
    rows = observations.drop_duplicates(RUN_KEYS, keep="last").sort_values(
        "step", ascending=False, kind="stable"
    )
    was_run = rows["integrator"] != ""
    rows = rows[was_run | ~rows["engine"].isin(rows.loc[was_run, "engine"])]
    lines = []
    for (engine, integrator), runs in rows.groupby(["engine", "integrator"], sort=False):
        line = {"engine": engine, "integrator": integrator}
        for joint in JOINTS:
            of_joint = runs[runs["joint"] == joint]
            steps, errors = list(of_joint["step"]), list(of_joint["attitude_error"])
            shown = of_joint[np.isclose(of_joint["step"], SHOWN_STEP)]
            line[f"order, {joint}"] = algebraic(steps, errors, floor=ATTITUDE_FLOOR).rate
            line[f"attitude error, {joint}"] = shown["attitude_error"].max()
            line[f"energy error, {joint}"] = shown["energy_error"].max()
        lines.append(line | {"status": "; ".join(filter(None, runs["status"].unique()))})
    table = pd.DataFrame(lines).sort_values("engine", key=_by_version, kind="stable")
    numbers = table.columns.drop(["engine", "integrator", "status"])
    return readable_table(table, {name: name for name in table}, dict.fromkeys(numbers, readable))


def _by_version(engines: pd.Series) -> pd.Series:
    """Sort keys by which mujoco 3.6.0 precedes mujoco 3.10.0."""
    return engines.map(lambda name: tuple(map(int, re.findall(r"\d+", name))))


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
    long_form=LongForm(engine_versions.parts, engine_versions.stored),
)


SKY_COLUMNS = {
    "contender": "contender",
    "body": "body",
    "days": "days",
    "difference_au": "from DE421, barycentric [au]",
    "difference_arcsec": "seen from the Sun [″]",
    "relativity_au": "relativity alone [au]",
    "integration_error_au": "error of the run [au]",
    "in_frame": "in the Kepler frame [au]",
    "status": "status",
}


def sky_table(rows: pd.DataFrame) -> tuple[pd.DataFrame, dict[str, str]]:
    """A line for each contender, body and time, and the CSS classes of the columns.

    Lines of the first contender also have the error in the Kepler frame, whose model is the same.
    """
    in_frame = (rows["contender"] == ephemeris.FRAME_LABEL) & (rows["status"] == "")
    errors = rows[in_frame].set_index(["body", "days"])["integration_error_au"]
    table = rows[~in_frame].join(errors.rename("in_frame"), on=["body", "days"])
    is_first = table["contender"] == table["contender"].iloc[0]
    return readable_table(table.assign(in_frame=table["in_frame"].where(is_first)), SKY_COLUMNS)


EPHEMERIS = Section(
    name="ephemeris",
    title="Point masses against JPL's ephemeris",
    text=ephemeris.EXPLANATION,
    measure=ephemeris.ephemeris_table,
    table=sky_table,
    absent=lambda: JPL_EPHEMERIS.missing,
    open=True,
    compared=True,
)


def force_matrix(table: pd.DataFrame) -> tuple[pd.DataFrame, dict[str, str]]:
    """A line for each force and eccentricity, a column for each contender; no CSS classes."""
    return forces.matrix(table), {}


def versions_and_statuses(table: pd.DataFrame) -> str:
    """Sentences on the versions, and on the statuses that contenders reported."""
    noted = table[table["status"].fillna("") != ""]
    pairs = noted[["contender", "status"]].drop_duplicates().itertuples(index=False)
    statuses = [f"{contender}: {status}" for contender, status in pairs]
    return " ".join([*(f"{text}." for text in table["versions"].dropna().unique()), *statuses])


FORCES = Section(
    name="forces",
    title="Forces and integrators",
    text=forces.EXPLANATION,
    measure=forces.forces_table,
    table=force_matrix,
    summary=versions_and_statuses,
    absent=lambda: HEYOKA_QUADRUPLE.missing,
)
