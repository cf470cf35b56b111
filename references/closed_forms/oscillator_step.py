"""The Galerkin step of the harmonic oscillator in exact arithmetic, and the form it conserves.

For L = (q'^2 - q^2) / 2 and polynomials of degree s, with a rule that is exact for their products,
the discrete Lagrangian is a quadratic form of the ends of the step,
L_d = (a q0^2 + 2 b q0 q1 + a q1^2) / 2. From p0 = -D1 L_d, p1 = D2 L_d:

    q1 = -(a / b) q0 - (1 / b) p0,    p1 = (b - a^2 / b) q0 - (a / b) p0.

For a^2 < b^2 this is a rotation by theta, cos theta = -a / b, of (w q, p), w^2 = b^2 - a^2: it
conserves p^2 + w^2 q^2. From q = 1, p = 0 the relative energy error after k steps is
(w^2 - 1) sin^2(k theta), of which |w^2 - 1| is the supremum over all k.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from fractions import Fraction

import numpy as np

from galvi.arrays import Array

Row = list[Fraction]


@dataclass(frozen=True)
class OscillatorStep:
    """The step of degree s >= 1 and rational size h > 0.

    a, b  of the discrete Lagrangian, exact
    """

    a: Fraction
    b: Fraction

    @property
    def stable(self) -> bool:
        """Whether the trace is in (-2, 2): powers of the step are bounded."""
        return self.a**2 < self.b**2

    @property
    def largest_energy_error(self) -> float:
        """|w^2 - 1|, relative; infinite where the step is not stable."""
        return float(abs(self.b**2 - self.a**2 - 1)) if self.stable else math.inf

    def energy_errors(self, steps: int) -> Array:
        """Relative energy errors after 0 to `steps` steps of a stable step, from q = 1, p = 0."""
        theta = math.acos(-self.a / self.b)
        errors: Array = float(self.b**2 - self.a**2 - 1) * np.sin(np.arange(steps + 1) * theta) ** 2
        return errors


def oscillator_step(degree: int, step: int | Fraction) -> OscillatorStep:
    """The step of polynomials of this degree, m = k = 1; size as a rational number."""
    bubbles = [_bubble(j) for j in range(1, degree)]
    functions = [[Fraction(1), Fraction(-1)], [Fraction(0), Fraction(1)], *bubbles]
    h = Fraction(step)
    form = [
        [_product(_slope(f), _slope(g)) / h - h * _product(f, g) for g in functions]
        for f in functions
    ]
    for k in range(len(functions) - 1, 1, -1):  # the stationary value over each bubble's factor
        for row in form[:k]:
            factor = row[k] / form[k][k]
            row[:k] = [x - factor * y for x, y in zip(row[:k], form[k][:k], strict=True)]
    return OscillatorStep(form[0][0], form[0][1])


def _bubble(j: int) -> Row:
    """t^j (1 - t), 0 at both ends, as coefficients of 1, t, t^2, ..."""
    return [Fraction(0)] * j + [Fraction(1), Fraction(-1)]


def _slope(f: Row) -> Row:
    return [k * c for k, c in enumerate(f)][1:]


def _product(f: Row, g: Row) -> Fraction:
    """The integral of f g over [0, 1]."""
    return sum((x * y / (j + k + 1) for j, x in enumerate(f) for k, y in enumerate(g)), Fraction(0))
