"""L1: the free rigid body by methods that ignore the group structure (H figure 1.2)."""

from __future__ import annotations

from typing import Any

import numpy as np
import pandas as pd

import galvi
from benchmarks.checks.bounds import AtLeast, AtMost
from benchmarks.checks.claim import Claim, MakeMethod, Report, Row
from benchmarks.claims.lie_groups.free_body import BODY, STEP, problem
from benchmarks.measures.refinement import method_on_group
from benchmarks.measures.rigid_invariants import orthogonality_defect
from benchmarks.statistics import readings
from benchmarks.store.frames import failure, frame, history
from galvi import Trajectory
from references.contender import Contender
from references.scipy.rigid_ivp import RIGID_ODE45
from references.textbook.matrix_euler import MATRIX_EULER

DURATION, N = 100.0, 8
SAMPLES = 500
EULER, ODE45, GALERKIN = "explicit Euler", "RK45", "galvi"
SPHERE, GROUP = "departure from the momentum sphere", "departure from SO(3)"
LEAVES, STAYS = 1e-8, 1e-13  # for the group methods 1e-14 was measured, for RK45 1e-6
SETUP = f"{BODY}; T = {DURATION:g}"
SETUPS = {
    EULER: f"{SETUP}; Q' = Q hat(w), y' = y x w on matrices, h = 0.01",
    ODE45: f"{SETUP}; the same equations, MATLAB's default tolerances 1e-3 and 1e-6",
    GALERKIN: f"{SETUP}; Polynomials({N - 1}), gauss({N}), Cayley, h = {STEP:g}",
}
REASONS = {
    (EULER, SPHERE): "Each step ends outside the sphere, on the tangent plane.",
    (EULER, GROUP): "Each step ends outside the group, on its tangent space: the columns grow.",
    (ODE45, SPHERE): "Nothing in the method knows the sphere. The departure is too small to be "
    "seen in a picture: the matrix asks for much smaller steps than the momentum, which H may have "
    "solved for alone.",
    (ODE45, GROUP): "Nothing in the method knows the group.",
    (GALERKIN, SPHERE): "The momentum is carried by rotations alone, so its length stays.",
    (GALERKIN, GROUP): "The step is a rotation; one step of Newton's iteration takes the rounding "
    "of each product out.",
}


def contenders() -> dict[str, tuple[Contender, dict[str, Any]]]:
    """Label -> contender and its setting."""
    return {
        EULER: (MATRIX_EULER, {"step": 0.01, "save_every": 20}),
        ODE45: (RIGID_ODE45, {"samples": SAMPLES}),
    }


def study(make_method: MakeMethod, quick: bool, report: Report) -> pd.DataFrame:
    """Series, with the method in `study`: both departures in time, and 'momentum', the body
    momentum divided by its initial length, in x, y, z."""
    body, rows = problem(), []
    for label, (contender, setting) in contenders().items():
        report(label)
        rows += _rows(label, contender.run(body, DURATION, setting))
    report(GALERKIN)
    steps = round(DURATION / STEP)
    rows += _rows(GALERKIN, galvi.integrate(body, method_on_group(make_method, N), STEP, steps))
    return frame(rows)


def _rows(label: str, run: Trajectory) -> list[dict[str, Any]]:
    place = run.p / np.linalg.norm(run.problem.p0)
    away = np.abs(np.linalg.norm(place, axis=-1) - 1.0)
    where = {"study": label, "status": failure(run)}
    return [
        *history(SPHERE, run.t, away, **where),
        *history(GROUP, run.t, orthogonality_defect(run.q), **where),
        *history("momentum", run.t, place, **where),
    ]


def judge(table: pd.DataFrame) -> list[Row]:
    """Euler and RK45 leave the sphere and the group; galvi stays on both."""
    return [_row(table, label, quantity) for label, quantity in REASONS]


def _row(table: pd.DataFrame, label: str, quantity: str) -> Row:
    stays = label == GALERKIN
    return L1.row(
        f"largest {quantity}, {label}",
        AtMost(STAYS) if stays else AtLeast(LEAVES),
        readings.largest(readings.values(table, study=label, quantity=quantity)),
        setup=SETUPS[label],
        claimed="geometric methods produce much better results" if stays else "leaves it",
        reason=REASONS[label, quantity],
    )


L1 = Claim(
    "L1",
    "Free rigid body by Euler and RK45 on matrices: off the sphere, off the group",
    study,
    judge,
    ("H fig. 1.2",),
    reference="|y| = |y0| and R^T R = I, exact",
)
