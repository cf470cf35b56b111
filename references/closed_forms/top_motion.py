"""Free rigid bodies and thrown bodies in closed form, and principal axes of rigid bodies."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from decimal import Decimal, localcontext
from functools import cached_property
from itertools import combinations
from typing import Any, ClassVar

import numpy as np

from galvi import Problem, RigidBody, Trajectory
from galvi.arrays import Array
from galvi.extended_precision import decimals
from references.as_trajectory import as_trajectory
from references.closed_forms.double_double import DIGITS, PI, SMALLEST, angle, sine_cosine
from references.closed_forms.pendulum import Modulus, first_integral
from references.contender import times_of_run
from references.newton import is_forced, is_thrown
from references.rigid_equations import has_known_weight, rotation
from references.setting import described

SWEEPS = 20  # largest number of sweeps of Jacobi's method
TERMS = 400  # largest number of terms of a theta series
State = tuple[Any, Any]  # R (3, 3) and body momentum (3,), of decimals


def principal_axes(inertia: Any) -> tuple[Any, Any]:
    """Moments (3,), ascending, and axes as columns of an orthogonal (3, 3), by Jacobi's method.

    Parameters
    ----------
    inertia : array, shape (3, 3)
        symmetric, of decimals; call inside ``localcontext(DIGITS)``

    Notes
    -----
    The moments of a diagonal matrix are its diagonal, exactly.
    """
    J, axes = inertia.copy(), decimals(np.eye(3))
    size = max(abs(J.ravel()))
    for _ in range(SWEEPS):
        if max(abs(J[i, j]) for i, j in combinations(range(3), 2)) < SMALLEST * size:
            break
        for i, j in combinations(range(3), 2):
            if J[i, j]:
                turn = _rotation(J, i, j)
                J, axes = turn.T @ J @ turn, axes @ turn
    order = sorted(range(3), key=lambda k: J[k, k])
    return J.diagonal()[order], axes[:, order]


def _rotation(J: Any, i: int, j: int) -> Any:
    """The plane rotation, by at most an eighth of a turn, that makes J_ij zero."""
    half = (J[j, j] - J[i, i]) / (2 * J[i, j])
    tangent = 1 / (abs(half) + (half * half + 1).sqrt()) * (1 if half >= 0 else -1)
    cosine = 1 / (tangent * tangent + 1).sqrt()
    turn = decimals(np.eye(3))
    turn[i, i] = turn[j, j] = cosine
    turn[i, j], turn[j, i] = tangent * cosine, -tangent * cosine
    return turn


@dataclass(frozen=True, eq=False)
class PrincipalBody:
    """The constants of one problem in principal axes.

    Attributes
    ----------
    axes : array, shape (3, 3)
        columns: the principal axes in the body's frame; the unit matrix for a diagonal inertia
    numbers
        inverse moments (3,), mass g in the frame of the start (3,), centre of mass (3,), and
        whether the body has weight
    p0 : array, shape (3,)
        momentum at the start
    """

    axes: Array
    numbers: tuple[Array, Array, Array, bool]
    p0: Array

    @staticmethod
    def of(problem: Problem) -> PrincipalBody:
        """The constants of a problem for which `is_known_body` returns True."""
        J, weight = problem.system.inertia, problem.system.potential
        moments, axes = np.diagonal(J), np.eye(3)
        if np.any(np.diag(moments) != J):
            moments, axes = np.linalg.eigh(J)
            axes = axes * np.linalg.det(axes)
        force, centre = np.zeros(3), np.zeros(3)
        if weight is not None:
            force = (problem.q0 @ axes).T @ (weight.mass * weight.g)
            centre = axes.T @ weight.centre
        numbers = (1.0 / moments, force, centre, weight is not None)
        return PrincipalBody(axes, numbers, axes.T @ problem.p0)

    def start(self) -> Array:
        """The initial state (7,): the unit quaternion, then the momentum."""
        return np.array([1.0, 0.0, 0.0, 0.0, *self.p0])

    def states(self, problem: Problem, saved: Array) -> tuple[Array, Array]:
        """R (k, 3, 3) and body momentum (k, 3) of states (k, 7), the first the start."""
        R = problem.q0 @ (self.axes @ rotation(saved[:, :4]) @ self.axes.T)
        p = saved[:, 4:] @ self.axes.T
        R[0], p[0] = problem.q0, problem.p0
        return R, p


def is_known_body(problem: Problem) -> bool:
    """Whether the system is a RigidBody, free or under the weight of `galvi.UniformGravity`
    alone."""
    system = problem.system
    if not isinstance(system, RigidBody) or is_forced(problem):
        return False
    return system.potential is None or has_known_weight(problem)


@dataclass(frozen=True)
class FreeTop:
    """A RigidBody without potential: any inertia, any start, on the separatrix too.

    Setting: samples. The start is taken as exact, t - t0 likewise, and the entries of q and p come
    out rounded once: within eps / 2 of the exact motion of that start, however long the run.
    """

    fixed_step: ClassVar[bool] = False

    name: str = "free rigid body, closed form"
    exact: bool = True
    missing: str = ""

    def supports(self, problem: Problem) -> bool:
        """A RigidBody without potential and external torque."""
        free = isinstance(problem.system, RigidBody) and problem.system.potential is None
        return free and not is_forced(problem)

    def run(self, problem: Problem, duration: float, setting: Mapping[str, Any]) -> Trajectory:
        """States at evenly spaced times; see `Contender`."""
        times = times_of_run(self, problem, duration, setting)
        with localcontext(DIGITS):
            moving = motion(problem.system.inertia, problem.q0, problem.v0)
            states = [moving(t) for t in (times - problem.t0).tolist()]
        q, p = (np.array([x[k] for x in states], dtype=np.float64) for k in (0, 1))
        p[0] = problem.p0  # rounded as galvi rounds it
        return as_trajectory(
            problem, described(self.name, setting), times, q, p=p, counts={"steps": 0}
        )


FREE_TOP = FreeTop()


def motion(inertia: Array, q0: Array, v0: Array) -> Callable[[float], State]:
    """R (3, 3) and body momentum (3,), of decimals, as a function of the time since the start.

    Call it, and what it returns, inside ``localcontext(DIGITS)``.
    """
    J, R0, v = decimals(inertia), decimals(q0), decimals(v0)
    m = J @ v
    if not np.any(np.cross(m, v)):
        return lambda t: (R0 @ _turned_about(v, Decimal(t)), m)
    moments, axes = principal_axes(J)
    along = axes.T @ m
    short, middle, long = moments
    excess = (short - middle) * long * along[0] ** 2 + (long - middle) * short * along[2] ** 2
    order = [0, 1, 2] if excess >= 0 else [2, 1, 0]
    moments, axes = moments[order], axes[:, order]
    axes = axes * np.where(axes.T @ m >= 0, Decimal(1), Decimal(-1))
    axes[:, 1] = np.cross(axes[:, 2], axes[:, 0])
    euler_top = top(*moments, *(axes.T @ m))
    start = R0 @ axes @ euler_top.frame(euler_top.start)

    def state(t: float) -> State:
        if not t:
            return R0, m
        u = euler_top.start + euler_top.rate * Decimal(t)
        turned = start @ _about_third(euler_top.precession(Decimal(t), u))
        return turned @ euler_top.frame(u).T @ axes.T, axes @ euler_top.momentum(u)

    return state


@dataclass(frozen=True)
class Top:
    """A free motion other than rotation at constant angular velocity.

    The momentum m along the principal axes a, b, c is (A_a cn u, A_b sn u, A_c dn u), with
    u = start + rate t.

    Attributes
    ----------
    moments
        I_a and I_b
    size
        |m|
    amplitudes
        A_a, A_b with its sign, A_c
    modulus
        of the elliptic functions
    nu
        sqrt(I_c (I_b - I_a) / (I_a (I_c - I_b))), 0 for I_a = I_b
    rate, start
        of u
    """

    moments: tuple[Decimal, Decimal]
    size: Decimal
    amplitudes: tuple[Decimal, Decimal, Decimal]
    modulus: Modulus
    nu: Decimal
    rate: Decimal
    start: Decimal

    def momentum(self, u: Decimal) -> Any:
        """The momentum (3,) along a, b, c."""
        (a, b, c), (sn, cn, dn) = self.amplitudes, self.modulus.functions(u)
        return np.array([a * cn, b * sn, c * dn])

    def frame(self, u: Decimal) -> Any:
        """The frame N, (3, 3), whose third axis is the momentum, in columns along a, b, c."""
        a, b, c = self.momentum(u) / self.size
        across = (a * a + b * b).sqrt()
        first = [a * c / across, b * c / across, -across]
        return np.array([first, [-b / across, a / across, Decimal(0)], [a, b, c]]).T

    def precession(self, t: Decimal, u: Decimal) -> Decimal:
        """The angle psi about the momentum at the time t since the start, where u is given."""
        Ia, Ib = self.moments
        increment = self._integral(u) - self._integral(self.start) if self.nu else Decimal(0)
        wobble = (1 / Ib - 1 / Ia) * (1 + self.nu**2) * increment / self.rate
        return self.size * (t / Ia + wobble)

    def _integral(self, u: Decimal) -> Decimal:
        """int_0^u sn^2 / (1 + nu^2 sn^2) = (u Z - arg Theta(u + i eta)) / (...), DLMF 22.16."""
        nu, k2 = self.nu, self.modulus.square
        if not self.modulus.complement:
            sn, _, _ = self.modulus.functions(u)
            return (u - angle(nu * sn, Decimal(1)) / nu) / (1 + nu**2)
        z = PI * u / (2 * self.modulus.quarter)
        sine, cosine = sine_cosine(2 * z)
        s, c, real, imaginary = Decimal(0), Decimal(1), Decimal(1), Decimal(0)
        for even, odd in self._theta:
            s, c = s * cosine + c * sine, c * cosine - s * sine
            real += even * c
            imaginary -= odd * s
        scale = nu * ((k2 + nu**2) * (1 + nu**2)).sqrt()
        return (u * self._drift - angle(imaginary, real)) / scale

    @cached_property
    def _theta(self) -> list[tuple[Decimal, Decimal]]:
        """2 (-1)^n q^(n^2) times cosh and sinh of 2 n y, n = 1, 2, ..., y = pi eta / (2 K)."""
        nu2, k2, q = self.nu**2, self.modulus.square, self.modulus.nome
        part = k2 / (k2 + nu2)
        eta = (1 - part).sqrt() * first_integral(part, part * (1 + nu2), Decimal(1))
        growth = (PI * eta / self.modulus.quarter).exp()
        coefficients: list[tuple[Decimal, Decimal]] = []
        for n in range(1, TERMS):
            large, small = q ** (n * n) * growth**n, q ** (n * n) / growth**n
            if large < SMALLEST:
                break
            sign = 1 if n % 2 == 0 else -1
            coefficients.append((sign * (large + small), sign * (large - small)))
        return coefficients

    @cached_property
    def _drift(self) -> Decimal:
        """Z(i eta) / i, Jacobi's zeta function."""
        above = sum(n * odd for n, (_, odd) in enumerate(self._theta, start=1))
        below = 1 + sum(even for even, _ in self._theta)
        return -PI / self.modulus.quarter * above / below


def top(Ia: Decimal, Ib: Decimal, Ic: Decimal, ma: Decimal, mb: Decimal, mc: Decimal) -> Top:
    """The motion with these moments and this momentum at the start; no nearly equal energies are
    subtracted."""
    below = mb * mb * (Ib - Ia) / Ib + mc * mc * (Ic - Ia) / Ic  # |m|^2 - 2 H I_a
    above = ma * ma * (Ic - Ia) / Ia + mb * mb * (Ic - Ib) / Ib  # 2 H I_c - |m|^2
    middle = (ma * ma * (Ia - Ib) * Ic + mc * mc * (Ic - Ib) * Ia) / (Ia * Ic)  # |m|^2 - 2 H I_b
    factor = (Ic - Ib) * below
    a, c = (Ia * above / (Ic - Ia)).sqrt(), (Ic * below / (Ic - Ia)).sqrt()
    b = (Ib * above / (Ic - Ib)).sqrt() * (1 if Ic > Ib else -1)
    return Top(
        moments=(Ia, Ib),
        size=(ma * ma + mb * mb + mc * mc).sqrt(),
        amplitudes=(a, b, c),
        modulus=Modulus((Ib - Ia) * above / factor, (Ic - Ia) * middle / factor),
        nu=(Ic * (Ib - Ia) / (Ia * (Ic - Ib))).sqrt(),
        rate=(factor / (Ia * Ib * Ic)).sqrt(),
        start=mb / b * first_integral((ma / a) ** 2, (mc / c) ** 2, Decimal(1)),
    )


def _about_third(angle: Decimal) -> Any:
    sine, cosine = sine_cosine(angle)
    zero, unit = Decimal(0), Decimal(1)
    return np.array([[cosine, -sine, zero], [sine, cosine, zero], [zero, zero, unit]])


def _turned_about(v: Any, t: Decimal) -> Any:
    """exp(t hat(v)), rotation at constant angular velocity."""
    size = sum(v * v).sqrt()
    if not size:
        return decimals(np.eye(3))
    x, y, z = v / size
    sine, cosine = sine_cosine(size * t)
    zero = Decimal(0)
    turn = np.array([[zero, -z, y], [z, zero, -x], [-y, x, zero]])
    return decimals(np.eye(3)) + sine * turn + (1 - cosine) * (turn @ turn)


@dataclass(frozen=True)
class ThrownBody:
    """A FreeBody: any inertia, any start.

    Setting: samples. The start is taken as exact, t - t0 likewise, and the entries of q and p are
    rounded once, as those of `FreeTop`.
    """

    fixed_step: ClassVar[bool] = False

    name: str = "thrown body, closed form"
    exact: bool = True
    missing: str = ""

    def supports(self, problem: Problem) -> bool:
        """A FreeBody on which gravity alone acts."""
        return is_thrown(problem)

    def run(self, problem: Problem, duration: float, setting: Mapping[str, Any]) -> Trajectory:
        """States at evenly spaced times; see `Contender`."""
        times = times_of_run(self, problem, duration, setting)
        body: Any = problem.system
        start, v = problem.q0, problem.v0
        q = np.zeros((len(times), 4, 4))
        q[:, 3, 3] = 1.0
        p = np.empty((len(times), 6))
        with localcontext(DIGITS):
            turning = motion(body.inertia, start[:3, :3], v[:3])
            position, g = decimals(start[:3, 3]), decimals(body.g)
            speed = decimals(start[:3, :3]) @ decimals(v[3:])
            for k, t in enumerate(Decimal(t) for t in (times - problem.t0).tolist()):
                R, spin = turning(float(t))
                q[k, :3, :3], q[k, :3, 3] = R, position + t * speed + t * t / 2 * g
                p[k, :3], p[k, 3:] = spin, Decimal(body.mass) * ((speed + t * g) @ R)
        p[0] = problem.p0  # rounded as galvi rounds it
        return as_trajectory(
            problem, described(self.name, setting), times, q, p=p, counts={"steps": 0}
        )


THROWN_BODY = ThrownBody()
