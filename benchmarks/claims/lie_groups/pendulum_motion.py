"""The 3D pendulum of H 3.5.2, shared by L6 to L9, L11, L15, L17 and L18."""

from __future__ import annotations

from benchmarks.claims.kit import *
from benchmarks.work_precision.with_settings import WithSettings
from references.textbook.quaternions import QUATERNION_DOP853, TIGHT

WEIGHT = 9.81  # m g; H gives none
BODY = (
    "3D pendulum, J_d = diag(1, 2.8, 2), so J = diag(4.8, 3, 3.8) about the pivot, "
    "centre of mass at (0, 0, 1), e3 down"
)
START = "R0 = I, body velocity (0.5, -0.5, 0.4)"
METHOD = "Polynomials(n - 1), gauss(n) (H states no number of points), Cayley chart"
MOTION = f"{BODY}, m g = {WEIGHT:g} (H gives none); {START}"
STEP, DURATION = 0.5, 5.0
FLOOR = 8e-15  # entries of R after T = 5; 1e-15 was measured at n = 9 and above
TRUTH = WithSettings(QUATERNION_DOP853, TIGHT)  # 2e-15 from heyoka in quadruple precision at T = 5


def problem() -> Problem:
    """The 3D pendulum started near its hanging equilibrium."""
    return galvi.problems.pendulum_3d(weight=WEIGHT)


def refinement(
    study: str, cases: Iterable[Case], make_method: MakeMethod, report: Report
) -> list[dict[str, Any]]:
    """Series of the one-step and the curve error."""
    options = (make_method, report, method_on_group)
    return refine(study, problem(), TRUTH, cases, ENDS_AND_CURVE, *options)


def _heavier(problem: Problem) -> Problem:
    """By a millionth."""
    system: Any = problem.system
    weight = replace(system.potential, mass=system.potential.mass * (1.0 + 1e-6))
    return Problem(galvi.RigidBody(system.inertia, weight), problem.q0, problem.v0, problem.t0)


OTHER_MOTIONS = (
    of_motion("clock reversed", bool, reversed_clock),
    of_motion("another weight", bool, _heavier),
)
