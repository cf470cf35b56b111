"""L1: the free rigid body by methods that ignore the group structure (H figure 1.2)."""

from __future__ import annotations

from typing import Any

import numpy as np
from scipy.integrate import solve_ivp

import galvi
from benchmarks.claims.kit import (
    Array,
    DataFrame,
    Fault,
    MakeMethod,
    Report,
    failure,
    history,
    method_on_group,
    readings,
    table_of,
    times,
)
from benchmarks.measures.rigid_invariants import orthogonality_defect
from references.closed_forms.top_motion import FREE_TOP
from references.scipy.rigid_ivp import RIGID_ODE45
from references.textbook.euler import MATRIX_EULER

N = 8
EULER, ODE45, GALERKIN, EXACT = "explicit Euler", "RK45 on matrices", "galvi", "closed form"
MOMENTUM = {f"RK45 on the momentum alone, T = {T:g}": T for T in (100.0, 1000.0)}
SPHERE, GROUP = "departure from the momentum sphere", "departure from SO(3)"
ENERGY = "relative change of the energy"
JUDGED = {
    EULER: (SPHERE, ENERGY, GROUP),
    **dict.fromkeys((ODE45, GALERKIN, EXACT), (SPHERE, GROUP)),
    **dict.fromkeys(MOMENTUM, (SPHERE, ENERGY)),
}
FAULTS = {
    "a momentum that stays": Fault(table=times(1e-8, quantity=SPHERE)),
    "an energy that stays": Fault(table=times(1e-8, quantity=ENERGY)),
    "a matrix that stays": Fault(table=times(1e-8, quantity=GROUP)),
    "a method that leaves": Fault(table=times(1e3, study=GALERKIN)),
}


def study(make_method: MakeMethod, quick: bool, report: Report) -> DataFrame:
    """Series, with the method in `study`: | |y| / |y0| - 1 |, |E / E0 - 1| for E = sum_i y_i^2 /
    (2 I_i), and the departure of the matrix, in time; 'momentum' y / |y0| in x, y, z."""
    body: Any = galvi.problems.free_rigid_body()
    moments = np.diag(body.system.inertia)
    size = np.linalg.norm(body.p0)
    runs = {
        EULER: MATRIX_EULER.run(body, 100.0, {"step": 0.01, "save_every": 20}),
        ODE45: RIGID_ODE45.run(body, 100.0, {"samples": 500}),
        EXACT: FREE_TOP.run(body, 100.0, {"samples": 500}),
        GALERKIN: galvi.integrate(body, method_on_group(make_method, N), 0.5, 200),
    }
    momenta = {label: (run.t, run.p, run.p) for label, run in runs.items()}
    momenta |= {label: momentum_alone(body.p0, moments, T) for label, T in MOMENTUM.items()}
    rows = []
    for label, run in runs.items():
        defect = orthogonality_defect(run.q)
        rows += history(GROUP, run.t, defect, study=label, status=failure(run))
    for label, (t, y, places) in momenta.items():
        energy = np.sum(y**2 / moments, axis=-1) / np.sum(body.p0**2 / moments)
        rows += history(SPHERE, t, abs(np.linalg.norm(y, axis=-1) / size - 1.0), study=label)
        rows += history(ENERGY, t, abs(energy - 1.0), study=label)
        rows += history("momentum", np.arange(float(len(places))), places / size, study=label)
    return table_of(rows)


def momentum_alone(y0: Array, moments: Array, duration: float) -> tuple[Array, Array, Array]:
    """Solve Euler's equations by RK45; returns the ends of the steps (k,), y there (k, 3), and y at
    four points of each step, as MATLAB's ode45 returns them by its interpolant, (4 (k - 1), 3)."""
    run = solve_ivp(lambda t, y: np.cross(y, y / moments), (0.0, duration), y0, dense_output=True)
    fine = run.t[:-1, None] + np.diff(run.t)[:, None] * np.arange(4) / 4
    return run.t, run.y.T, run.sol(fine.ravel()).T


def read(table: DataFrame) -> dict[str, float]:
    """The largest departures, and as `rounding` two rounding units for each of 200 steps."""
    numbers = {
        f"largest {quantity}, {label}": readings.largest_of(table, study=label, quantity=quantity)
        for label, quantities in JUDGED.items()
        for quantity in quantities
    }
    return numbers | {"rounding": 2 * 200 * 2.0**-52}
