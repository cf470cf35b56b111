"""M's solution maps, exact and discrete: how far two solutions are apart, and bounds on it.

|u|_X^2 = |u'|^2 + |u(h)|^2 / h; K the Lipschitz constant of F = grad V - f, m the least of mu, and
eta = 3 K h^2 / (m z0^2).
"""

from __future__ import annotations

from numpy.polynomial import legendre, polynomial
from scipy.integrate import solve_ivp

from benchmarks.claims.kit import *
from benchmarks.measures.independent_space import (
    farthest,
    friedrichs,
    gauss_points,
    grams,
    inf_sup,
    lobatto_points,
    values,
    z0,
)
from benchmarks.test_problems.oscillators import PENDULUM
from references.scipy.ivp import TIGHT

POINTS = 40  # of exact integrals
INF_SUP, FARTHEST, ETA, SINGULAR = "inf-sup", "T_N", "eta C_N^2", "singular value"
Nodes = tuple[Array, Array]
Motions = Callable[[Array, Array, Array], tuple[Array, Array]]


def nodes(rule: galvi.Rule) -> Nodes:
    """The points and weights of galvi's Gauss or Lobatto rule, by numpy."""
    points = lobatto_points if "Lobatto" in rule.name else gauss_points
    return points(rule.points)


def oscillations(u0: Array, v0: Array, t: Array) -> tuple[Array, Array]:
    """u and u' of u'' = -u from each of the starts (k,), at times t: (k, times)."""
    cosine, sine = np.cos(t), np.sin(t)
    u0, v0 = u0[:, None], v0[:, None]
    return u0 * cosine + v0 * sine, v0 * cosine - u0 * sine


def swings(u0: Array, v0: Array, t: Array) -> tuple[Array, Array]:
    """The same of u'' = -sin u, by DOP853; t increasing."""
    k = len(u0)

    def rates(s: float, y: Array) -> Array:
        return np.concatenate([y[k:], -np.sin(y[:k])])

    span, start = (0.0, float(t[-1])), np.concatenate([u0, v0])
    found = solve_ivp(rates, span, start, method="DOP853", t_eval=t, **TIGHT).y
    return found[:k], found[k:]


@dataclass(frozen=True)
class Stability:
    """Bounds on the difference d of two solutions from data that differ by du and dp.

    v = d - d(h) in (2), proposition 1 with m / 3 and |du|_X = |du| / sqrt(h) give `path`; v = 1
    and Friedrichs' inequality `momentum`; `both` is their sum in terms of |du| + |dp|.

    friedrichs  C_N of the discrete problem (8), 1 of the exact one (2)
    """

    h: float
    lipschitz: float
    mass: float
    friedrichs: float = 1.0

    @property
    def eta(self) -> float:
        """eta C_N^2."""
        return 3.0 * self.lipschitz * (self.h * self.friedrichs / z0()) ** 2 / self.mass

    @property
    def pull(self) -> float:
        """C_N K h^(3/2) / z0."""
        return self.friedrichs * self.lipschitz * self.h**1.5 / z0()

    def path(self, du: Array, dp: Array) -> Array:
        """The largest |d|_X."""
        root = math.sqrt(self.h)
        return (abs(du) / root + 3.0 * root / self.mass * abs(dp)) / (1.0 - self.eta)

    def momentum(self, du: Array, dp: Array) -> Array:
        """The largest |dp_h|."""
        return abs(dp) + self.pull * self.path(du, dp)

    @property
    def both(self) -> float:
        """The largest (|d|_X + |dp_h|) / (|du| + |dp|)."""
        root = math.sqrt(self.h)
        share = (1.0 + self.pull) / (1.0 - self.eta)
        return max(share / root, 1.0 + 3.0 * share * root / self.mass)


def differences(count: int) -> tuple[Array, Array, Array, Array]:
    """Random data u0, p0 and differences du, dp, (count,): one with dp = 0, one with du = 0."""
    rng = np.random.default_rng(0)
    u0, p0 = rng.uniform(-2.0, 2.0, (2, count))
    du, dp = rng.normal(size=(2, count)) * 10.0 ** rng.uniform(-3.0, 0.0, count)
    dp[0] = du[1] = 0.0
    return u0, p0, du, dp


def exact_sizes(motions: Motions, h: float, data: tuple[Array, ...]) -> tuple[Array, Array]:
    """|d|_X and |dp_h| of exact solutions of mass 1."""
    u0, p0, du, dp = data
    s, w = gauss_points(POINTS)
    times = h * np.append(s, 1.0)
    (u, v), (other, slope) = motions(u0, p0, times), motions(u0 + du, p0 + dp, times)
    gap, rate = other - u, slope - v
    return np.sqrt(h * rate[:, :-1] ** 2 @ w + gap[:, -1] ** 2 / h), abs(rate[:, -1])


def discrete_sizes(method: Any, h: float, data: tuple[Array, ...]) -> tuple[Array, Array]:
    """|d_N|_(X,N) and |dp_h| of the method's steps of the pendulum."""
    t, b = nodes(method.rule)
    path, momentum = [], []
    for u, p, du, dp in zip(*data, strict=True):
        one, other = (_step(method, h, *start) for start in ((u, p), (u + du, p + dp)))
        gap = (other.velocity(h * t) - one.velocity(h * t))[:, 0]
        path.append(math.sqrt(h * b @ gap**2 + float(other.q[1, 0] - one.q[1, 0]) ** 2 / h))
        momentum.append(abs(float(other.p[1, 0] - one.p[1, 0])))
    return np.array(path), np.array(momentum)


def _step(method: Any, h: float, u: float, p: float) -> galvi.Trajectory:
    problem = Problem(PENDULUM.problem().system, np.full(1, u), np.full(1, p))
    return galvi.integrate(problem, method, h, 1)


def powers_of_falling(power: int) -> Array:
    """1 and (1 - t)^power as functions of `benchmarks.measures.independent_space`."""
    falling = legendre.poly2leg(polynomial.polypow([0.5, -0.5], power))
    return np.stack([np.eye(1, power + 1)[0], falling])


def step_equations(functions: Array, rule: Nodes, stiffness: float) -> Array:
    """The matrix of (8) in (u, p_h) for V = stiffness u^2 / 2, mu = h = 1."""
    seen = grams(functions, *rule)
    first, last = values(functions, np.array([0.0, 1.0])).T
    weak = np.column_stack([seen.slope - stiffness * seen.place, -last])
    return np.vstack([weak, np.append(first, 0.0)])


def opposed(power: int) -> dict[str, float]:
    """{1, (1 - t)^k}: the constants, and (8) for the V = -K u^2 / 2 that makes it singular, K from
    phi = 1 - (1 - t)^k in closed form."""
    functions, rule = powers_of_falling(power), gauss_points(1)
    seen = grams(functions, *rule)
    q = 2.0**-power
    steepness = (2.0 * power * q) ** 2 / (q * (1.0 - q))
    sizes = np.linalg.svd(step_equations(functions, rule, -steepness), compute_uv=False)
    return {
        INF_SUP: inf_sup(functions, seen),
        FARTHEST: farthest(functions, seen),
        ETA: Stability(1.0, steepness, 1.0, friedrichs(seen)).eta,
        SINGULAR: float(sizes[-1] / sizes[0]),
    }
