"""The harmonic oscillator: its motion, its action, and the step of a method."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from decimal import Decimal, localcontext
from fractions import Fraction
from typing import Any, ClassVar

import numpy as np

from galvi import LinearSpring, Problem, Trajectory
from galvi.arrays import Array
from references.as_trajectory import as_trajectory
from references.closed_forms.double_double import DIGITS, sine_cosine
from references.contender import times_of_run
from references.newton import is_moved_by
from references.setting import described


@dataclass(frozen=True)
class Oscillator:
    """A LinearSpring on a scalar or diagonal mass: q = q0 cos wt + (v0 / w) sin wt, w^2 = k / m.

    Setting: samples. The rounding of w t costs about eps |v| |t - t0|.
    """

    fixed_step: ClassVar[bool] = False

    name: str = "oscillator, closed form"
    exact: bool = True
    missing: str = ""

    def supports(self, problem: Problem) -> bool:
        """A Canonical system with a LinearSpring and no external force."""
        return is_moved_by(problem, LinearSpring)

    def run(self, problem: Problem, duration: float, setting: Mapping[str, Any]) -> Trajectory:
        """States at evenly spaced times; see `Contender`."""
        times = times_of_run(self, problem, duration, setting)
        w = np.sqrt(problem.system.potential.stiffness / problem.system.mass)
        phase = (times - problem.t0)[:, None] * np.broadcast_to(w, problem.q0.shape)
        cosine, sine = np.cos(phase), np.sin(phase)
        return as_trajectory(
            problem,
            described(self.name, setting),
            times,
            problem.q0 * cosine + problem.v0 / w * sine,
            problem.v0 * cosine - problem.q0 * w * sine,
            counts={"steps": 0},
        )


OSCILLATOR = Oscillator()


def oscillator_action(mass: float, stiffness: float, start: float, end: float, h: float) -> float:
    """Integral of m v^2/2 - k q^2/2 from q = `start` to `end` in the time h, w h below pi:
    m w ((q0^2 + q1^2) cos wh - 2 q0 q1) / (2 sin wh), w^2 = k/m (Feynman and Hibbs, problem 2-2).

    The arguments are taken as exact; the result is rounded once.
    """
    with localcontext(DIGITS):
        m, k, q0, q1 = map(Decimal, (mass, stiffness, start, end))
        w = (k / m).sqrt()
        sine, cosine = sine_cosine(w * Decimal(h))
        return float(m * w * ((q0 * q0 + q1 * q1) * cosine - 2 * q0 * q1) / (2 * sine))


Row = list[Fraction]


@dataclass(frozen=True)
class OscillatorStep:
    """A step with polynomials of degree s >= 1 and rational size h > 0.

    Attributes
    ----------
    a, b
        exact coefficients of the discrete Lagrangian (a q0^2 + 2 b q0 q1 + a q1^2) / 2
    """

    a: Fraction
    b: Fraction

    @property
    def stable(self) -> bool:
        """Whether the trace of the step is in (-2, 2), so that its powers are bounded."""
        return self.a**2 < self.b**2

    @property
    def largest_energy_error(self) -> float:
        """Largest relative energy error, |b^2 - a^2 - 1|; infinite where the step is not stable."""
        return float(abs(self.b**2 - self.a**2 - 1)) if self.stable else math.inf

    def energy_errors(self, steps: int) -> Array:
        """Relative energy errors after 0 to `steps` steps of a stable step, from q = 1, p = 0."""
        theta = math.acos(-self.a / self.b)
        return float(self.b**2 - self.a**2 - 1) * np.sin(np.arange(steps + 1) * theta) ** 2


def oscillator_step(degree: int, step: int | Fraction) -> OscillatorStep:
    """The step with polynomials of this degree and the size ``step``, for m = k = 1."""
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
