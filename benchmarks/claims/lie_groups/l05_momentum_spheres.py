"""L5: body momenta on the intersections of the sphere with the ellipsoids (H figure 3.4)."""

from __future__ import annotations

import numpy as np

import galvi
from benchmarks.claims.kit import (
    Array,
    DataFrame,
    MakeMethod,
    Report,
    failure,
    history,
    method_on_group,
    readings,
    rows,
    table_of,
)
from benchmarks.claims.lie_groups.free_body import OTHER_MOTIONS
from galvi.problems.rigid_bodies import INERTIA
from references.closed_forms.top_motion import FREE_TOP

FAULTS = OTHER_MOTIONS
SPHERE, ELLIPSOID, DISTANCE = "| |y|^2 - 1 |", "relative energy error", "distance to the exact y"


def starts() -> Array:
    """12 body momenta y0 on the unit sphere, (12, 3), three pairs about each stable axis.

    They are turned from the axis of the middle moment, 3.3, towards both ends of the axes of the
    smallest moment, 2.5, and of the largest, 3.4.
    """
    middle, *stable = np.eye(3)
    return np.array(
        [
            np.cos(angle) * middle + sign * np.sin(angle) * axis
            for axis, angles in zip(stable, ((30, 50, 75), (15, 40, 70)), strict=True)
            for angle in np.radians(angles)
            for sign in (1.0, -1.0)
        ]
    )


def study(make_method: MakeMethod, quick: bool, report: Report) -> DataFrame:
    """'momentum' in x, y, z at every eighth step end, with the number of its start in `label`; and
    for each start the largest of three measures, that of the distance over 20 times."""
    moments = np.array(INERTIA)
    observed = []
    for k, y0 in enumerate(starts()):
        body = galvi.problems.free_rigid_body(velocity=y0 / moments)
        run = galvi.integrate(body, method_on_group(make_method, 8), 0.5, 800, save_every=8)
        truth = FREE_TOP.run(body, 400.0, {"samples": 20})
        energy = np.sum(run.p**2 / moments, axis=-1) / np.sum(y0**2 / moments)
        largest = {
            SPHERE: np.max(abs(np.sum(run.p**2, axis=-1) - 1.0)),
            ELLIPSOID: np.max(abs(energy - 1.0)),
            DISTANCE: np.max(np.linalg.norm(run.p[::5] - truth.p, axis=-1)),
        }
        observed += rows(largest, study="sphere", status=failure(run))
        observed += history("momentum", run.t, run.p, study="sphere", label=str(k))
    return table_of(observed)


def read(table: DataFrame) -> dict[str, float]:
    """The largest value of each measure, and the largest sum y_i^2 / I_i on the unit sphere."""
    return {
        "largest sum y_i^2 / I_i over the unit sphere, 1 / I_min": 1.0 / min(INERTIA),
        **{
            f"largest {measure}": readings.largest_of(table, quantity=measure)
            for measure in (SPHERE, ELLIPSOID, DISTANCE)
        },
    }
