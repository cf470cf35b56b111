"""Oscillators: driven, nonlinear, with mass or potential in time, of limited smoothness."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

import galvi
from galvi import Canonical, LinearSpring, Problem
from galvi.arrays import Array

# A driven point whose acceleration has a singularity: a motion of stated finite smoothness.
#
# u'' + k u = |t - t*|^(-b), b < 1/2, m = 1, k = 1 or 0, with u = u' = 0 at t*. With x = t - t*
#
#     u' = sign(x) sum_j a_j |x|^(2 j + 1 - b), a_j = (-k)^j / ((1 - b) (2 - b) ... (2 j + 1 - b)),
#     u  = sum_j a_j |x|^(2 j + 2 - b) / (2 j + 2 - b).
#
# The s-th derivative is like |x|^(2 - s - b) and in L^2 as long as s < 5/2 - b: s = 2 for b from
# -1/2 (excluded) to 1/2, s = 3 from -3/2 to -1/2.

SERIES_TERMS = 12  # |x| <= 1: the next is below 1e-25


@dataclass(frozen=True)
class SingularDrive:
    """A driven point; `singularity` is t*, `b` the exponent, and k is 1 where `spring`, else 0."""

    singularity: float
    b: float
    spring: bool = False

    @property
    def smoothness(self) -> int:
        """s, the number of derivatives in L^2."""
        return math.ceil(2.5 - self.b) - 1

    @property
    def powers(self) -> Array:
        """2 j + 1 - b, (terms,): one without a spring."""
        return np.asarray(2.0 * np.arange(SERIES_TERMS if self.spring else 1) + 1.0 - self.b)

    @property
    def coefficients(self) -> Array:
        """a_j, (terms,)."""
        products = np.cumprod(np.arange(1, 2 * len(self.powers)) - self.b)[::2]
        return np.asarray((-1.0) ** np.arange(len(products)) / products)

    def motion(self, t: Array) -> tuple[Array, Array]:
        """Exact u and u' at times t, of t's shape."""
        x = np.asarray(t, dtype=np.float64)[..., None] - self.singularity
        terms = self.coefficients * abs(x) ** self.powers
        u = np.sum(terms * abs(x) / (self.powers + 1.0), axis=-1)
        return u, np.sum(np.sign(x) * terms, axis=-1)

    def problem(self, t: float) -> Problem:
        """The problem from time t on."""

        def drive(q: Array, v: Array, s: float) -> Array:
            return np.full(1, abs(s - self.singularity) ** -self.b)

        u, v = self.motion(np.array([t]))
        system = Canonical(1.0, LinearSpring(float(self.spring)), force=drive, timed_force=True)
        return Problem(system, u, v, t, name="driven point")


# Oscillators whose mass or potential depends on time, with their motions in closed form.
#
# L = mu(t) u'^2 / 2 - V(t, u) as in M section 2:
#
#     growing mass  mu = e^(g t), V = w^2 e^(g t) u^2 / 2:  u = e^(-g t / 2) cos(W t),
#                   W^2 = w^2 - g^2 / 4
#     driven        mu = 1, V = u^2 / 2 - u cos 2 t:  u = (4/3) cos t + (1/2) sin t - (1/3) cos 2 t

GROWTH, FREQUENCY = 0.5, 1.3  # g, w
TURNING = math.sqrt(FREQUENCY**2 - GROWTH**2 / 4.0)  # W


@dataclass(frozen=True, eq=False)
class TimedOscillator:
    """An oscillator whose mass or potential depends on time.

    Attributes
    ----------
    mass
        mu of t, of t's shape
    slope
        V' of (t, u), of their shape
    motion
        t -> exact (u, u')
    system
        the system for galvi
    where
        the formulas in words
    """

    name: str
    mass: Callable[[Array], Array]
    slope: Callable[[Array, Array], Array]
    motion: Callable[[Array], tuple[Array, Array]]
    system: Any
    where: str

    def problem(self, t: float = 0.0) -> Problem:
        """The problem from the exact state at t on."""
        u, v = self.motion(np.array([t]))
        return Problem(self.system, u, v, t, name=self.name)


def _growing(q: Array, v: Array, t: float) -> Any:
    return 0.5 * np.exp(GROWTH * t) * (v[0] ** 2 - FREQUENCY**2 * q[0] ** 2)


def _damped(t: Array) -> tuple[Array, Array]:
    size = np.exp(-0.5 * GROWTH * t)
    u = size * np.cos(TURNING * t)
    return u, -0.5 * GROWTH * u - TURNING * size * np.sin(TURNING * t)


def _potential(q: Array, t: float) -> Any:
    return 0.5 * q[0] ** 2 - q[0] * np.cos(2.0 * t)


def _gradient(q: Array, t: float) -> Array:
    return np.array([q[0] - np.cos(2.0 * t)])


def _forced(t: Array) -> tuple[Array, Array]:
    u = 4.0 * np.cos(t) / 3.0 + 0.5 * np.sin(t) - np.cos(2.0 * t) / 3.0
    return u, -4.0 * np.sin(t) / 3.0 + 0.5 * np.cos(t) + 2.0 * np.sin(2.0 * t) / 3.0


GROWING_MASS = TimedOscillator(
    "growing mass",
    lambda t: np.exp(GROWTH * t),
    lambda t, u: FREQUENCY**2 * np.exp(GROWTH * t) * u,
    _damped,
    galvi.Lagrangian(_growing, galvi.Rn(1), explicit_time=True),
    f"mu = e^({GROWTH:g} t), V = {FREQUENCY:g}^2 e^({GROWTH:g} t) u^2 / 2, u0 = 1, "
    f"u'(0) = {-GROWTH / 2.0:g}",
)
DRIVEN = TimedOscillator(
    "driven potential",
    np.ones_like,
    lambda t, u: u - np.cos(2.0 * t),
    _forced,
    galvi.Canonical(1.0, _potential, _gradient, explicit_time=True),
    "mu = 1, V = u^2 / 2 - u cos 2 t, u0 = 1, u'(0) = 1/2",
)
TIMED = (GROWING_MASS, DRIVEN)


REGION_SAMPLES = 200  # of curves in the region


@dataclass(frozen=True, eq=False)
class NonlinearOscillator:
    """q'' = -V'(q) from (q, v) at t = 0.

    Attributes
    ----------
    slope
        V', a function of arrays of any shape; `curvature` is its derivative
    radius
        half the length of the interval |q| <= radius where V' is Lipschitz continuous; inf for the
        line
    lipschitz
        K, the largest |V''| on the interval
    where
        the interval and K in words
    """

    name: str
    problem: Callable[[], Problem]
    slope: Callable[[Array], Array]
    curvature: Callable[[Array], Array]
    radius: float
    lipschitz: float
    where: str

    def sample_positions(self, size: int) -> Array:
        """Positions in the interval, (samples, size): random ones, and one where |V''| is K."""
        reach = min(self.radius, math.pi)
        positions = np.random.default_rng(0).uniform(-reach, reach, (REGION_SAMPLES, size))
        steepest = 0.0 if math.isinf(self.radius) else self.radius
        return np.vstack([positions, np.full((1, size), steepest)])


RADIUS = 1.5
PENDULUM = NonlinearOscillator(
    "pendulum",
    lambda: Problem(galvi.Canonical(1.0, galvi.CosinePotential(1.0)), np.ones(1), np.ones(1)),
    np.sin,
    np.cos,
    math.inf,
    1.0,
    "V = -cos q, from q = v = 1: K = 1 on the whole line, as the theorem asks",
)
HARDENING = NonlinearOscillator(
    "hardening spring",
    lambda: Problem(galvi.Canonical(1.0, _quartic, _cubic), np.ones(1), np.full(1, 0.5)),
    lambda q: q + q**3,
    lambda q: 1.0 + 3.0 * q**2,
    RADIUS,
    1.0 + 3.0 * RADIUS**2,
    f"V = q^2 / 2 + q^4 / 4, from q = 1, v = 0.5: K = 1 + 3 rho^2 on |q| <= rho = {RADIUS:g}, "
    "where the iterates stay",
)
NONLINEAR = (PENDULUM, HARDENING)


def _quartic(q: Array) -> float:
    return float(0.5 * q[0] ** 2 + 0.25 * q[0] ** 4)


def _cubic(q: Array) -> Array:
    with np.errstate(over="ignore"):  # passes above the bound diverge
        return np.asarray(q + q**3)


# A point between two springs: a motion of limited smoothness in closed form.
#
# V = k(q) q^2 / 2 with k = 1 for q >= 0 and 4 for q < 0, m = 1, from q = 1 at rest: the force is
# Lipschitz continuous with constant 4, its slope jumps at q = 0, and so does q''' at t = pi / 2
# and, at the end of the half revolution that it has to q = 0 again, at t = pi. q has three
# derivatives in L^2 and not four.

SOFT, STIFF = 1.0, 4.0
SMOOTHNESS = 3  # derivatives in L^2
KINK = np.pi / 2.0
DURATION = np.pi  # the second crossing


def _stiffness(q: Array) -> Any:
    return np.where(q >= 0.0, SOFT, STIFF)


def _two_springs_potential(q: Array) -> float:
    return float(0.5 * _stiffness(q)[0] * q[0] ** 2)


def _two_springs_gradient(q: Array) -> Array:
    return _stiffness(q) * q


def _hessian(q: Array) -> Array:
    return np.array([[float(_stiffness(q)[0])]])


def two_springs() -> Problem:
    """The point between two springs, from q = 1 at rest."""
    return Problem(
        Canonical(1.0, _two_springs_potential, _two_springs_gradient, _hessian),
        np.ones(1),
        np.zeros(1),
        name="two springs",
    )


def motion(t: Array) -> tuple[Array, Array]:
    """Exact q and q' at times t in [0, pi], of t's shape."""
    late = 2.0 * (t - KINK)
    before = t <= KINK
    q: Array = np.where(before, np.cos(t), -0.5 * np.sin(late))
    v: Array = np.where(before, -np.sin(t), -np.cos(late))
    return q, v
