"""The terms of M's theorem 3 for one step of a method from an exact state, by numpy.

|u|_X^2 = |u'|^2 + |u(h)|^2 / h; F = grad V - f, with K, m and M as in M section 2.
"""

from __future__ import annotations

from scipy.linalg import eigvalsh

from benchmarks.claims.kit import *
from benchmarks.claims.vector_spaces.solution_map import POINTS, Nodes, Stability, nodes, swings
from benchmarks.measures.best_approximation import step_error
from benchmarks.measures.independent_space import (
    all_of_degree,
    friedrichs,
    gauss_points,
    grams,
    kernels,
    slopes,
    values,
    z0,
)
from benchmarks.test_problems.oscillators import FREQUENCY, GROWING_MASS, GROWTH, PENDULUM

FLOOR = 1e-12  # of |u - u_N|_X; below it round-off is seen


@dataclass(frozen=True, eq=False)
class Comparison:
    """A motion u on steps from an exact state, for theorem 3.

    mass, slope  mu of t, F of (t, u)
    motion       t -> (u, u'), t increasing and not before t0
    problem      from the exact state at t0
    constants    h -> K, m, M on [t0, t0 + h]
    """

    name: str
    t0: float
    mass: Callable[[Array], Array]
    slope: Callable[[Array, Array], Array]
    motion: Callable[[Array], tuple[Array, Array]]
    problem: Callable[[], Problem]
    constants: Callable[[float], tuple[float, float, float]]
    where: str


def _swing(t: Array) -> tuple[Array, Array]:
    u, v = swings(np.ones(1), np.ones(1), np.asarray(t))
    return u[0], v[0]


def _growing(h: float) -> tuple[float, float, float]:
    least, most = math.exp(GROWTH), math.exp(GROWTH * (1.0 + h))
    return FREQUENCY**2 * most, least, most


COMPARISONS = (
    Comparison(
        "oscillator", 1.0, np.ones_like, lambda t, u: u, lambda t: (np.cos(t), -np.sin(t)),
        lambda: Problem(
            galvi.problems.harmonic_oscillator().system, [math.cos(1.0)], [-math.sin(1.0)], 1.0
        ),
        lambda h: (1.0, 1.0, 1.0), "u = cos t from t = 1",
    ),
    Comparison(
        "pendulum", 0.0, np.ones_like, lambda t, u: np.sin(u), _swing, PENDULUM.problem,
        lambda h: (1.0, 1.0, 1.0), "V = -cos u from u = u' = 1",
    ),
    Comparison(
        GROWING_MASS.name, 1.0, GROWING_MASS.mass, GROWING_MASS.slope, GROWING_MASS.motion,
        lambda: GROWING_MASS.problem(1.0), _growing, f"{GROWING_MASS.where}, from t = 1",
    ),
)  # fmt: skip


def consistency(case: Comparison, rule: Nodes, degree: int, h: float) -> tuple[float, float]:
    """The terms of theorem 3: I_2, the least over v_N in X_N of the root of |u - v_N|_X^2 +
    (sup_z (a - a_N)(v_N, z) / |z|_X)^2, at most I with the sum of both; and Q, the supremum with F.
    """
    functions = all_of_degree(degree)
    (s, w), (t, b) = gauss_points(POINTS), rule
    slope, at_nodes = slopes(functions, s), slopes(functions, t)
    mass, mass_at_nodes = case.mass(case.t0 + h * s), case.mass(case.t0 + h * t)
    _, ends = kernels(functions)
    onto = np.linalg.inv(np.linalg.cholesky(ends.T @ ((slope * w) @ slope.T) @ ends)) @ ends.T
    missed = (slope * (w * mass)) @ slope.T - (at_nodes * (b * mass_at_nodes)) @ at_nodes.T
    (u, rate), end = case.motion(case.t0 + h * s), case.motion(np.array([case.t0 + h]))[0]
    last = values(functions, np.ones(1)).T
    left = np.vstack([np.sqrt(w)[:, None] * slope.T, last, onto @ missed]) / math.sqrt(h)
    right = np.concatenate([np.sqrt(h * w) * rate, end / math.sqrt(h), np.zeros(degree)])
    best = np.linalg.lstsq(left, right, rcond=None)[0]
    ruled = (values(functions, t) * b) @ case.slope(
        case.t0 + h * t, case.motion(case.t0 + h * t)[0]
    )
    pulled = ruled - (values(functions, s) * w) @ case.slope(case.t0 + h * s, u)
    return float(np.linalg.norm(left @ best - right)), h**1.5 * float(np.linalg.norm(onto @ pulled))


def proof_step(
    case: Comparison, rule: Nodes, degree: int, h: float, run: galvi.Trajectory
) -> tuple[float, float]:
    """Of a step: sup_z sum_k (F_(u_N) - F_u) . z w_k / |z|_(X,N), z in K_1, over
    C_N^2 (K h^2 / z0^2) |u - u_N|_(X,N); and |u - u_N|_(0,N)."""
    t, b = rule
    functions, times = all_of_degree(degree), case.t0 + h * t
    seen = grams(functions, t, b)
    _, ends = kernels(functions)
    onto = np.linalg.inv(np.linalg.cholesky(ends.T @ seen.energy @ ends)) @ ends.T
    (u, rate), end = case.motion(times), case.motion(np.array([case.t0 + h]))[0]
    found, gap = run(times)[:, 0], run.velocity(times)[:, 0] - rate
    pull = case.slope(times, found) - case.slope(times, u)
    largest = h**1.5 * float(np.linalg.norm(onto @ ((values(functions, t) * b) @ pull)))
    size = math.sqrt(h * (b @ gap**2) + float(run.q[1, 0] - end[0]) ** 2 / h)
    bound = friedrichs(seen) ** 2 * case.constants(h)[0] * h**2 / z0() ** 2 * size
    return largest / bound, math.sqrt(h * (b @ (found - u) ** 2))


@dataclass(frozen=True)
class Terms:
    """What theorem 3 comes to for one step.

    proved   (1 - C_N z0 eta / (sqrt(2) lambda_N)) |u - u_N|_X over `right`
    printed  (1 - Lambda_N C_N^2 eta) |u - u_N|_X over `right`
    proof    sup_z sum_k (F_(u_N) - F_u) . z w_k / |z|_(X,N), z in K_1, over its bound in the proof,
             C_N^2 (K h^2 / z0^2) |u - u_N|_(X,N)
    place    |u - u_N|_(0,N) / (h |u - u_N|_X)

    right is (1 + sqrt(2) + 3 M / (m lambda_N^2)) I_2 + 3 / (m lambda_N^2) Q, see `consistency`.
    """

    proved: float
    printed: float
    proof: float
    place: float


def terms(case: Comparison, method: Any, degree: int, h: float) -> Terms | None:
    """Of one step; None where its error is round-off."""
    run = galvi.integrate(case.problem(), method, h, 1)
    if not run.success:
        return Terms(*(float("nan"),) * 4)
    error = step_error(run, case.motion)
    if error <= FLOOR:
        return None
    rule = nodes(method.rule)
    lipschitz, least, most = case.constants(h)
    functions, eta = all_of_degree(degree), Stability(h, lipschitz, least).eta
    seen, exact = grams(functions, *rule), grams(functions, *gauss_points(POINTS))
    lower, *_, upper = np.sqrt(eigvalsh(seen.energy, exact.energy))  # lambda_N and Lambda_N
    constant, onto = friedrichs(seen), 3.0 / (least * lower**2)
    best, forced = consistency(case, rule, degree, h)
    right = (1.0 + math.sqrt(2.0) + onto * most) * best + onto * forced
    ratio, place = proof_step(case, rule, degree, h, run)
    return Terms(
        (1.0 - constant * z0() * eta / (math.sqrt(2.0) * lower)) * error / right,
        (1.0 - upper * constant**2 * eta) * error / right,
        ratio,
        place / (h * error),
    )
