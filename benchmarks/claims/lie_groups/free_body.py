"""The free rigid body of H 3.5.1, shared by L1 to L5, L13, L17 and L18."""

from __future__ import annotations

from benchmarks.claims.kit import *
from benchmarks.measures.refinement import MethodOf
from galvi.charts import CHARTS

STEP, DURATION = 0.5, 5.0
BODY = (
    "free rigid body, J_d = diag(1.3, 2.1, 1.2), so J = diag(3.3, 2.5, 3.4); R0 = I, "
    "Omega0 = (2, -1.9, 1)"
)
METHOD = "Polynomials(n - 1), gauss(n) (H names Gauss, and no number of points)"
CAYLEY = galvi.Cayley().name
FLOOR = 2e-14  # round-off of matrix entries; 3e-15 was measured at n = 15


def problem() -> Problem:
    """H's body with H's initial state."""
    return galvi.problems.free_rigid_body()


def _heavier(problem: Problem) -> Problem:
    """One moment larger by a millionth."""
    moments = problem.system.inertia * np.diag([1.0, 1.0, 1.0 + 1e-6])
    return Problem(
        galvi.RigidBody(moments, problem.system.potential), problem.q0, problem.v0, problem.t0
    )


OTHER_MOTIONS = (
    of_motion("clock reversed", bool, reversed_clock),
    of_motion("another body", bool, _heavier),
)
METHODS: Mapping[str, MethodOf] = {
    chart.name: partial(method_on_group, chart=chart) for chart in CHARTS
}
