"""L1: the free rigid body by methods that ignore the group structure (H figure 1.2)."""

from __future__ import annotations

from scipy.integrate import solve_ivp

from benchmarks.claims.kit import *
from benchmarks.claims.lie_groups.free_body import BODY, STEP, problem
from benchmarks.measures.rigid_invariants import orthogonality_defect
from references.closed_forms.top_motion import FREE_TOP
from references.contender import Contender
from references.scipy.rigid_ivp import RIGID_ODE45
from references.textbook.euler import MATRIX_EULER

DURATION, LONG, N = 100.0, 1000.0, 8  # H gives no duration
SAMPLES = 500
EULER, ODE45, GALERKIN, EXACT = "explicit Euler", "RK45 on matrices", "galvi", "closed form"
MOMENTUM = {f"RK45 on the momentum alone, T = {T:g}": T for T in (DURATION, LONG)}
SPHERE, GROUP = "departure from the momentum sphere", "departure from SO(3)"
ENERGY = "relative change of the energy"
# "leaves" is what a picture can show: a thousandth of the sphere's radius is one pixel where the
# sphere is 2,000 pixels wide. A rounding in every step is no departure.
VISIBLE = 1e-3
STAYS = 2.0 * DURATION / STEP * float(np.finfo(np.float64).eps)  # two rounding units a step
REFINE = 4  # points that ode45 returns for each step, by its interpolant; for the picture
SETUP = f"{BODY} (H gives none for this figure); T = {DURATION:g} (H gives none)"
ALONE = f"{BODY} (H gives none for this figure); y' = y x w, ode45's default tolerances 1e-3, 1e-6"
SETUPS = {
    EULER: f"{SETUP}; Q' = Q hat(w), y' = y x w on matrices, h = 0.01",
    ODE45: f"{SETUP}; the same equations, ode45's default tolerances 1e-3 and 1e-6",
    GALERKIN: f"{SETUP}; Polynomials({N - 1}), gauss({N}), Cayley, h = {STEP:g}",
    EXACT: f"{SETUP}; {SAMPLES} samples",
    **{label: f"{ALONE}; T = {T:g}, of 100 and 1000 (H gives none)"
       for label, T in MOMENTUM.items()},
}  # fmt: skip
DRIFT = (
    "Nothing in the method knows the invariant: each step may lose 1e-3 of y, and the losses add "
    "up, ten times as much in ten times the time."
)
REASONS = {
    (EULER, SPHERE): "Each step ends outside the sphere, on the tangent plane.",
    (EULER, ENERGY): "Each step ends outside the ellipsoid too, on its tangent plane.",
    (EULER, GROUP): "Each step ends outside the group, on its tangent space: the rows grow.",
    (ODE45, SPHERE): "In one solve with the matrix, whose entries turn faster, the momentum takes "
    "steps seven times as short as its own error asks for: no picture shows its departure. H's, "
    "which does, is of the momentum alone.",
    (ODE45, GROUP): "Nothing in the method knows the group.",
    **{(label, quantity): DRIFT for label in MOMENTUM for quantity in (SPHERE, ENERGY)},
    (GALERKIN, SPHERE): "The momentum is carried by rotations alone, so its length stays.",
    (GALERKIN, GROUP): "The step is a rotation; one step of Newton's iteration takes the rounding "
    "of each product out.",
    (EXACT, SPHERE): "The closed form, rounded once: a tenth of what galvi may depart.",
    (EXACT, GROUP): "The closed form, rounded once: a tenth of what galvi may depart.",
}
HOLDS_ON = "the approximate solution fails to conserve energy and momentum, and drifts out of SO(3)"


def contenders() -> dict[str, tuple[Contender, dict[str, Any]]]:
    """Label -> contender and its setting."""
    return {
        EULER: (MATRIX_EULER, {"step": 0.01, "save_every": 20}),
        ODE45: (RIGID_ODE45, {"samples": SAMPLES}),
        EXACT: (FREE_TOP, {"samples": SAMPLES}),
    }


def momentum_alone(body: Problem, duration: float) -> tuple[Array, Array, Array]:
    """Euler's equations by RK45: ends of steps (k,), y there (k, 3), and y at ode45's points."""
    moments = np.diag(body.system.inertia)  # type: ignore[attr-defined]
    run = solve_ivp(
        lambda t, y: np.cross(y, y / moments), (0.0, duration), body.p0, dense_output=True
    )
    parts = np.arange(REFINE) / REFINE
    fine = (run.t[:-1, None] + np.diff(run.t)[:, None] * parts).ravel()
    return run.t, run.y.T, run.sol(fine).T


def study(make_method: MakeMethod, quick: bool, report: Report) -> DataFrame:
    """Series, with the method in `study`: the departures and the change of energy in time, and
    'momentum', the body momentum divided by its initial length, in x, y, z."""
    body, rows = problem(), []
    for label, (contender, setting) in contenders().items():
        report(label)
        rows += _rows(label, contender.run(body, DURATION, setting))
    size = float(np.linalg.norm(body.p0))
    for label, duration in MOMENTUM.items():
        report(label)
        t, y, fine = momentum_alone(body, duration)
        rows += _invariants(label, body, t, y)
        rows += history("momentum", np.arange(len(fine), dtype=float), fine / size, study=label)
    report(GALERKIN)
    steps = round(DURATION / STEP)
    rows += _rows(GALERKIN, galvi.integrate(body, method_on_group(make_method, N), STEP, steps))
    return frame(rows)


def _rows(label: str, run: Trajectory) -> list[dict[str, Any]]:
    where = {"study": label, "status": failure(run)}
    place = run.p / np.linalg.norm(run.problem.p0)
    return [
        *_invariants(label, run.problem, run.t, run.p),
        *history(GROUP, run.t, orthogonality_defect(run.q), **where),
        *history("momentum", run.t, place, **where),
    ]


def _invariants(label: str, body: Problem, t: Array, y: Array) -> list[dict[str, Any]]:
    """| |y| / |y0| - 1 | and |E / E0 - 1| for E = sum_i y_i^2 / (2 I_i)."""
    away = np.abs(np.linalg.norm(y, axis=-1) / np.linalg.norm(body.p0) - 1.0)
    moments = np.diag(body.system.inertia)  # type: ignore[attr-defined]
    energy = np.sum(y**2 / moments, axis=-1)
    change = np.abs(energy / np.sum(body.p0**2 / moments) - 1.0)
    return [
        *history(SPHERE, t, away, study=label),
        *history(ENERGY, t, change, study=label),
    ]


def judge(table: DataFrame) -> list[Row]:
    """Euler and RK45 leave the sphere, the ellipsoid and the group; galvi stays."""
    return [_row(table, label, quantity) for label, quantity in REASONS]


def _row(table: DataFrame, label: str, quantity: str) -> Row:
    bound: Bound = AtLeast(VISIBLE)
    claimed = HOLDS_ON
    if label == GALERKIN:
        bound, claimed = AtMost(STAYS), "geometric methods produce much better results"
    if label == EXACT:
        bound, claimed = Finding(AtMost(0.1 * STAYS)), "no claim: check of the reference"
    if (label, quantity) == (ODE45, SPHERE):
        bound, claimed = Finding(Below(VISIBLE)), "not in H: it does not say what ode45 solves"
    return L1.row(
        f"largest {quantity}, {label}",
        bound,
        readings.largest_of(table, study=label, quantity=quantity),
        setup=SETUPS[label],
        claimed=claimed,
        reason=REASONS[label, quantity],
    )


L1 = Claim(
    "L1",
    "Free rigid body by Euler and RK45 on matrices: off the sphere, off the group",
    study,
    judge,
    ("H fig. 1.2",),
    reference="|y| = |y0|, E = E0 and R^T R = I, exact; the closed form stays within 3e-16",
    statement="H fig. 1.2: explicit Euler and RK45 on matrices leave the momentum sphere, the "
    "energy and SO(3); geometric methods do much better.",
    caught=(
        Fault(
            "departures that no picture shows",
            {f"largest {quantity}, {label}" for quantity in (SPHERE, ENERGY) for label in MOMENTUM},
            table=lambda table: [times(1e-3, quantity=one)(table) for one in (SPHERE, ENERGY)],
        ),
    ),
)
