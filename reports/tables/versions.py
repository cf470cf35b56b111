"""A user's own run in releases of its engine: sentences on changes, and a line for each release."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from itertools import groupby
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from benchmarks.applications.judging import bodies, trees
from benchmarks.applications.releases.behaviour import CHANGE_FLOORS, ULPS, Behaviour
from benchmarks.applications.releases.own_run import OwnRun
from benchmarks.applications.releases.versions import Difference, Step, Versions
from reports.tables.number_format import plain
from reports.tables.writing import write_table

KINDS = {"mujoco": trees, "rebound": bodies}
DIFFERENCES = {"positions": "position_difference", "velocities": "velocity_difference"}
READABLE_COLUMNS = (
    "release",
    "order",
    "energy_change",
    "acceleration_difference",
    "position_difference",
    "velocity_difference",
    "error",
    "status",
)


def label(run: OwnRun) -> str:
    """The name of the user's integrator."""
    return str(KINDS[run.package].INTEGRATORS[run.integrator.lower()].name)


def sentences(versions: Versions) -> Iterator[str]:
    """Sentences on changes between releases, on failures, and on errors against the truth."""
    run = versions.run
    for changed, group in groupby(versions.steps, lambda step: step.changed):
        steps = list(group)
        if changed:
            yield from (change(step, run) for step in steps)
        else:
            ends = f"From {steps[0].earlier.version} to {steps[-1].later.version}"
            failure = steps[-1].later.failure
            yield (
                f"{ends} your run fails: {failure}"
                if failure
                else (f"{ends} nothing changed by more than rounding.")
            )
    for behaviour in versions.behaviours.values():
        if behaviour.missing:
            yield f"{behaviour.version} is left out: {behaviour.missing.rstrip('.')}."
    yield from versions.notes
    yield _measured(versions)
    yield from _errors(versions)


def change(step: Step, run: OwnRun) -> str:
    """A sentence on the quantities that changed between two releases, and on those that did not."""
    between = f"Between {step.earlier.version} and {step.later.version}"
    if step.failure_changed:
        transition = "began to fail" if step.later.failure else "ceased to fail"
        return f"{between} your run {transition}: {step.later.failure or step.earlier.failure}"
    parts, unchanged_quantities = [], []
    before, after = step.earlier.order, step.later.order
    if step.order_changed:
        parts.append(f"the order of {label(run)} went from {before:.1f} to {after:.1f}")
    elif math.isfinite(before) and math.isfinite(after):
        unchanged_quantities.append("order")
    for difference in step.differences:
        if difference.is_change:
            parts.append(_change_text(difference, run))
        else:
            unchanged_quantities.append(difference.quantity)
    unchanged = f"; the same: {', '.join(unchanged_quantities)}" if unchanged_quantities else ""
    return f"{between} {'; '.join(parts)}{unchanged}."


def _change_text(difference: Difference, run: OwnRun) -> str:
    floors = f"{plain(difference.floors, 1)} floors"
    if difference.quantity == "accelerations":
        return f"accelerations changed by {plain(difference.relative, 2)} of their size ({floors})"
    at = run.job.get("t", 0.0) + run.times[difference.sample]
    return f"{difference.quantity} at t = {at:g} changed by {plain(difference.size, 2)} ({floors})"


def _measured(versions: Versions) -> str:
    run = versions.run
    step = "steps of its own choice" if run.step is None else f"dt = {run.step:g}"
    measured = (
        f"Measured on your run by {label(run)}, {step}, for {run.duration:g}{_time_unit(run)}."
    )
    floors = [
        behaviour.quantities["positions"].floors
        for behaviour in versions.behaviours.values()
        if behaviour.quantities
    ]
    if not floors:
        return measured
    first, last = (plain(CHANGE_FLOORS * max(sizes[k] for sizes in floors), 1) for k in (0, -1))
    times = run.job.get("t", 0.0) + run.times
    return (
        f"{measured} A floor is how far rounding moves the run: starts that differ by {ULPS:g} ulp "
        f"part so far. A change exceeds {CHANGE_FLOORS:g} floors, of positions {first} at "
        f"t = {times[0]:g} and {last} at t = {times[-1]:g}."
    )


def _time_unit(run: OwnRun) -> str:
    """The unit of time of a run, after a space."""
    return (
        trees.UNITS["time"]
        if run.model is None
        else (KINDS[run.package].unit(run.model.problem, "time"))
    )


def _errors(versions: Versions) -> Iterator[str]:
    truth = versions.truth
    if truth is None:
        yield f"{versions.reason_without_truth.rstrip('. ')}."
        return
    confirmed = (
        f", which agrees with {truth.confirmed_by} to {plain(truth.disagreement)}"
        if truth.confirmed_by
        else ""
    )
    yield f"The truth is {truth.source}{confirmed}."
    unit = truth.kind.unit(truth.trajectory.problem, "length")
    completed = [
        behaviour for behaviour in versions.behaviours.values() if behaviour.motion is not None
    ]
    parts = []
    for error, group in groupby(completed, lambda behaviour: plain(versions.error(behaviour))):
        names = [behaviour.version for behaviour in group]
        parts.append(f"{error}{unit} in {' to '.join(dict.fromkeys((names[0], names[-1])))}")
    yield f"At its own step your run is off by up to {', '.join(parts)}."


def rows(versions: Versions) -> pd.DataFrame:
    """A line for each release; docs/judge.md explains the columns."""
    before = {step.later.version: step for step in versions.steps}
    return pd.DataFrame(
        [
            _row(behaviour, before.get(behaviour.version), versions)
            for behaviour in versions.behaviours.values()
        ]
    )


def _row(behaviour: Behaviour, step: Step | None, versions: Versions) -> dict[str, Any]:
    quantities = behaviour.quantities or {}
    line: dict[str, Any] = {
        "release": f"{versions.run.package} {behaviour.version}",
        "order": behaviour.order,
        "order_error": behaviour.order_error,
        "energy_change": behaviour.energy_change,
        "acceleration_difference": _from_newest(behaviour, versions.newest),
    }
    sizes = (
        {}
        if step is None
        else {difference.quantity: difference.size for difference in step.differences}
    )
    for quantity, column in DIFFERENCES.items():
        line[column] = sizes.get(quantity, math.nan)
    for quantity in DIFFERENCES:
        floors = quantities[quantity].floors if quantities else np.array([math.nan])
        line[f"{quantity}_floor"] = float(floors[-1])
    return {
        **line,
        "error": versions.error(behaviour),
        "status": behaviour.missing or behaviour.failure,
    }


def _from_newest(behaviour: Behaviour, newest: Behaviour) -> float:
    """The largest relative difference of accelerations, over all states, from those of the
    installed release; NaN if either is unknown."""
    if behaviour.quantities is None or newest.quantities is None:
        return math.nan
    accelerations, reference = (
        release.quantities["accelerations"].values for release in (behaviour, newest)
    )
    sizes = np.abs(reference).max(axis=1)
    return float(
        np.max(np.abs(accelerations - reference).max(axis=1) / np.where(sizes > 0.0, sizes, 1.0))
    )


def changes(versions: Versions) -> list[dict[str, Any]]:
    """The changes: an entry for each pair of successive releases and each changed quantity."""
    entries: list[dict[str, Any]] = []
    for step in versions.steps:
        between = {"earlier": step.earlier.version, "later": step.later.version}
        if step.failure_changed:
            failures = {"before": step.earlier.failure, "after": step.later.failure}
            entries.append({**between, "quantity": "failure", **failures})
        if step.changed and step.order_changed:
            orders = {"before": step.earlier.order, "after": step.later.order}
            entries.append({**between, "quantity": "order", **orders})
        entries += [
            {
                **between,
                "quantity": difference.quantity,
                "size": difference.size,
                "relative": difference.relative,
                "floors": difference.floors,
            }
            for difference in step.differences
            if difference.is_change
        ]
    return entries


def truth_facts(versions: Versions) -> dict[str, Any]:
    """The source of the truth, the source that confirms it, and their distance; or the reason why
    there is no truth."""
    truth = versions.truth
    if truth is None:
        return {"without": versions.reason_without_truth}
    return {"source": truth.source, "confirmed_by": truth.confirmed_by, "apart": truth.disagreement}


def write_versions(versions: Versions, folder: Path, origin: Mapping[str, str]) -> list[Path]:
    """Write versions.csv with all columns, and columns READABLE_COLUMNS as Markdown and LaTeX;
    returns the paths."""
    table = rows(versions)
    return write_table(folder, "versions", table, table[list(READABLE_COLUMNS)], origin)
