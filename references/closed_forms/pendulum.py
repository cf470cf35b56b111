"""Elliptic integrals and functions, and the pendulum."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from decimal import Decimal, localcontext
from functools import cached_property
from typing import Any, ClassVar

import numpy as np

from galvi import CosinePotential, Problem, Trajectory
from references.as_trajectory import as_trajectory
from references.closed_forms.double_double import DIGITS, PI, SMALLEST, angle, sine_cosine
from references.contender import times_of_run
from references.newton import is_moved_by
from references.setting import described

# Jacobi's elliptic functions and Carlson's first integral in 80-digit arithmetic.
#
# Libraries in double precision lose digits where the modulus nears 1, which is where tops and
# pendulums are most sensitive. Call inside ``localcontext(DIGITS)``.

DUPLICATIONS = 200  # largest number of steps of Carlson's algorithm
DESCENTS = 40  # largest number of descending transformations


@dataclass(frozen=True)
class Modulus:
    """k^2 and k'^2 = 1 - k^2, both stored: near 0 neither can be computed from the other.

    k'^2 = 0 is the separatrix, where the functions are hyperbolic and no longer periodic.
    """

    square: Decimal
    complement: Decimal

    @cached_property
    def quarter(self) -> Decimal:
        """K, a quarter of the period of sn.

        Raises
        ------
        ZeroDivisionError
            On the separatrix.
        """
        return PI / 2 * self._growth

    @cached_property
    def nome(self) -> Decimal:
        """q = exp(-pi K'/K); 0 for k = 0."""
        if not self.square:
            return Decimal(0)
        return (-PI * Modulus(self.complement, self.square).quarter / self.quarter).exp()

    @cached_property
    def _descent(self) -> list[Decimal]:
        """The moduli k1 = (1 - k') / (1 + k'), iterated until negligible."""
        square, complement_root = self.square, self.complement.sqrt()
        moduli: list[Decimal] = []
        for _ in range(DESCENTS):
            if square < SMALLEST**2:
                break
            moduli.append(square / (1 + complement_root) ** 2)
            square, complement_root = (
                moduli[-1] ** 2,
                2 * complement_root.sqrt() / (1 + complement_root),
            )
        return moduli

    @cached_property
    def _growth(self) -> Decimal:
        """2 K / pi, the product of all 1 + k1."""
        if not self.complement:
            raise ZeroDivisionError("there is no period on the separatrix.")
        product = Decimal(1)
        for k1 in self._descent:
            product *= 1 + k1
        return product

    def halves(self, u: Decimal) -> Decimal:
        """u / (2 K), the number of half periods of sn, rounded to the nearest integer."""
        if not self.complement:
            return Decimal(0)
        return (u / (2 * self.quarter)).to_integral_value()

    def functions(self, u: Decimal) -> tuple[Decimal, Decimal, Decimal]:
        """sn u, cn u and dn u by Gauss's descending transformation (DLMF 22.7(i))."""
        if not self.complement:
            exponential = u.exp()
            cosh = (exponential + 1 / exponential) / 2
            return (exponential - 1 / exponential) / (2 * cosh), 1 / cosh, 1 / cosh
        sn, cn = sine_cosine(u / self._growth)
        dn = Decimal(1)
        for k1 in reversed(self._descent):
            part = k1 * sn * sn
            sn, cn, dn = (1 + k1) * sn / (1 + part), cn * dn / (1 + part), (1 - part) / (1 + part)
        return sn, cn, dn


def first_integral(x: Decimal, y: Decimal, z: Decimal) -> Decimal:
    """R_F = 1/2 int_0^inf dt / sqrt((t + x)(t + y)(t + z)), at most one of them 0 (DLMF 19.36).

    F(phi, k) = sin phi R_F(cos^2 phi, 1 - k^2 sin^2 phi, 1).
    """
    for _ in range(DUPLICATIONS):
        a, b, c = x.sqrt(), y.sqrt(), z.sqrt()
        shift = a * b + b * c + c * a
        x, y, z = (x + shift) / 4, (y + shift) / 4, (z + shift) / 4
        mean = (x + y + z) / 3
        X, Y = 1 - x / mean, 1 - y / mean
        if max(abs(X), abs(Y)) < Decimal("1e-12"):
            break
    Z = -X - Y
    E2, E3 = X * Y - Z * Z, X * Y * Z
    return _series(E2, E3) / mean.sqrt()


def _series(E2: Decimal, E3: Decimal) -> Decimal:
    """The series of R_F to degree 7 in X, Y, Z (DLMF 19.36.1)."""
    return (
        1
        - E2 / 10
        + E3 / 14
        + E2**2 / 24
        - 3 * E2 * E3 / 44
        - 5 * E2**3 / 208
        + 3 * E3**2 / 104
        + E2**2 * E3 / 16
    )


@dataclass(frozen=True)
class Pendulum:
    """A CosinePotential on a scalar or diagonal mass; every angle is a pendulum of its own.

    With k^2 = m v^2 / (4 weight) + sin^2(q / 2) at the start and rate^2 = weight / m:
      k < 1  q = 2 asin(k sn u),     u = u0 + rate t, modulus k
      k > 1  q = 2 am u,             u = u0 +- k rate t, modulus 1 / k
      k = 1  q = 2 asin(tanh u),     u = u0 +- rate t

    Setting: samples. The start is taken as exact, t - t0 likewise, and q and v come out rounded
    once: within eps / 2 of the exact motion of that start, however long the run.
    """

    fixed_step: ClassVar[bool] = False

    name: str = "pendulum, closed form"
    exact: bool = True
    missing: str = ""

    def supports(self, problem: Problem) -> bool:
        """A Canonical system with a CosinePotential and no external force."""
        return is_moved_by(problem, CosinePotential)

    def run(self, problem: Problem, duration: float, setting: Mapping[str, Any]) -> Trajectory:
        """States at evenly spaced times; see `Contender`."""
        times = times_of_run(self, problem, duration, setting)
        masses = np.broadcast_to(problem.system.mass, problem.q0.shape)
        states = np.empty((2, len(times), problem.q0.size))
        with localcontext(DIGITS):
            for k, start in enumerate(zip(masses, problem.q0, problem.v0, strict=True)):
                moving = _motion(Decimal(problem.system.potential.weight), *map(Decimal, start))
                states[:, :, k] = np.array([moving(Decimal(t)) for t in times - problem.t0]).T
        return as_trajectory(
            problem, described(self.name, setting), times, *states, counts={"steps": 0}
        )


Motion = Callable[[Decimal], tuple[Decimal, Decimal]]


def _motion(weight: Decimal, mass: Decimal, q0: Decimal, v0: Decimal) -> Motion:
    """(q, v) as a function of the time since the start."""
    sense = 1 if v0 >= 0 else -1  # mirrored, it moves to the right
    turns = (q0 / (2 * PI)).to_integral_value()
    sine, cosine = sine_cosine(sense * (q0 / 2 - turns * PI))
    rate, kinetic_part = (weight / mass).sqrt(), mass * v0 * v0 / (4 * weight)
    square, excess = kinetic_part + sine * sine, kinetic_part - cosine * cosine  # k^2 and k^2 - 1
    if not square:
        return lambda t: (q0, v0)
    k, moving = square.sqrt(), sense * v0 / (2 * rate * square.sqrt())
    if excess < 0:
        modulus, growth = Modulus(square, -excess), rate
        u0 = sine / k * first_integral(moving**2, cosine**2, Decimal(1))
    else:
        modulus, growth = Modulus(1 / square, excess / square), rate * k
        u0 = sine * first_integral(cosine**2, moving**2, Decimal(1))

    def state(t: Decimal) -> tuple[Decimal, Decimal]:
        if not t:
            return q0, v0
        u = u0 + growth * t
        if excess < 0:
            sn, cn, dn = modulus.functions(u)
            half, speed = angle(k * sn, dn), cn
        else:
            halves = modulus.halves(u)
            sn, cn, speed = modulus.functions(u)
            sign = 1 if halves % 2 == 0 else -1
            half = halves * PI + angle(sign * sn, sign * cn)
        return 2 * (turns * PI + sense * half), sense * 2 * rate * k * speed

    return state


PENDULUM = Pendulum()
