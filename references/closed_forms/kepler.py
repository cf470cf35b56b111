"""The Kepler problem: its motion, its flow between any states, and its action."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from decimal import Context, Decimal, localcontext
from typing import Any, ClassVar

import numpy as np

from galvi import Canonical, CentralForce, NBody, Problem, Trajectory
from galvi.arrays import Array
from references.as_trajectory import as_trajectory
from references.closed_forms.double_double import DoubleDouble
from references.contender import times_of_run
from references.newton import is_moved_by
from references.setting import described

# The motion of one point about a fixed centre, r'' = -gm r / |r|^3, on any ellipse.
#
# With x = E - E0 the eccentric anomaly since the start, versine 1 - cos x and excess x - sin x,
#   n t = (r0/a) sin x + (x - sin x) + sigma (1 - cos x),  n^2 a^3 = gm, sigma = r0.v0 / sqrt(gm a)
#   r(t) = f r0 + g v0                                  (Battin, Astrodynamics (1999), section 4.3)
# From a pericentre these formulas subtract no nearly equal numbers, at any eccentricity; from other
# starts double-double arithmetic absorbs the cancellation, so that r and v are rounded once.

DIGITS = Context(prec=120)
TWO_PI = Decimal("6.28318530717958647692528676655900576839433879875021164194988918461563281257")
HALVINGS = 6  # of an angle before its series
TERMS = 10  # of the series of 1 - cos x and x - sin x
BISECTIONS = 60  # iterations of the solution in double precision
CORRECTIONS = 80  # largest number of Newton steps in double-double precision
SOLVED = 1e-29  # residual of Kepler's equation, relative to its terms, at which it is solved


@dataclass(frozen=True)
class Orbit:
    """The constants of a bound orbit, from its start; exact to 100 digits.

    Attributes
    ----------
    inverse_axis
        1 / a, positive
    mean_motion
        n
    r0
        distance at the start, over a
    sigma
        r0.v0 / sqrt(gm a)
    """

    inverse_axis: Decimal
    mean_motion: Decimal
    r0: Decimal
    sigma: Decimal


def orbit(gm: Decimal, r0: list[Decimal], v0: list[Decimal]) -> Orbit | None:
    """The orbit through (r0, v0); None where it is not an ellipse with 0 <= e < 1."""
    with localcontext(DIGITS):
        square, speed = sum(x * x for x in r0), sum(x * x for x in v0)
        inward = sum(x * y for x, y in zip(r0, v0, strict=True))
        distance = Decimal(square).sqrt()
        if not gm > 0 or not distance > 0 or inward * inward == square * speed:
            return None
        inverse_axis = 2 / distance - speed / gm
        if inverse_axis <= 0:
            return None
        mean_motion = (gm * inverse_axis**3).sqrt()
        return Orbit(
            inverse_axis=inverse_axis,
            mean_motion=mean_motion,
            r0=distance * inverse_axis,
            sigma=inward * (inverse_axis / gm).sqrt(),
        )


def flow(orbit: Orbit, r0: DoubleDouble, v0: DoubleDouble, t: Array) -> tuple[Any, Any]:
    """Position and velocity, DoubleDouble (k, d), at times t (k,) since the start at r0, v0 (d,).

    NaN where Kepler's equation was not solved, which no finite t is known to cause.
    """
    with localcontext(DIGITS):
        scaled_r0, sigma, n, turn, per_turn, inverse_r0 = map(
            DoubleDouble.nearest,
            (orbit.r0, orbit.sigma, orbit.mean_motion, TWO_PI, 1 / TWO_PI, 1 / orbit.r0),
        )
    mean = n * t
    mean = mean - turn * np.rint((mean * per_turn).hi)
    x = _double_root(scaled_r0.hi, sigma.hi, mean.hi)
    anomaly, solved = DoubleDouble(x, np.zeros_like(x)), False
    for _ in range(CORRECTIONS):
        sine, versine, excess = circle(anomaly)
        terms = scaled_r0 * sine, sigma * versine
        gap = terms[0] + excess + terms[1] - mean
        r = scaled_r0 + (1.0 - scaled_r0) * versine + sigma * sine
        anomaly = anomaly - gap.hi / r.hi
        size = np.abs(terms[0].hi) + np.abs(terms[1].hi) + np.abs(excess.hi) + np.abs(mean.hi)
        solved = np.abs(gap.hi) <= SOLVED * size
        if np.all(solved):
            break
    sine, versine, excess = circle(anomaly)
    r = scaled_r0 + (1.0 - scaled_r0) * versine + sigma * sine
    f = 1.0 - versine * inverse_r0
    g = (scaled_r0 * sine + sigma * versine) / n
    f_dot = -(n * sine) / (r * scaled_r0)
    g_dot = 1.0 - versine / r
    nan_if_unsolved = np.where(solved, 0.0, np.nan)[:, None]
    f, g, f_dot, g_dot = (x[:, None] for x in (f, g, f_dot, g_dot))
    return f * r0 + g * v0 + nan_if_unsolved, f_dot * r0 + g_dot * v0 + nan_if_unsolved


def circle(x: Any) -> tuple[Any, Any, Any]:
    """sin x, 1 - cos x and x - sin x of a DoubleDouble or an array, |x| < 2 pi, none cancelling.

    Taylor series at x / 2^6, then the doubling formulas: excess' = 2 excess + 2 sine versine,
    versine' = 2 versine (2 - versine), sine' = 2 sine (1 - versine).
    """
    x = x * 0.5**HALVINGS
    square = x * x
    excess = versine = 1.0 + square * 0.0
    for k in range(TERMS, 0, -1):
        excess = 1.0 - square * excess / ((2 * k + 2.0) * (2 * k + 3.0))
        versine = 1.0 - square * versine / ((2 * k + 1.0) * (2 * k + 2.0))
    excess = x * square * excess / 6.0
    versine = square * versine * 0.5
    sine = x - excess
    for _ in range(HALVINGS):
        excess = 2.0 * (excess + sine * versine)
        sine, versine = 2.0 * sine * (1.0 - versine), 2.0 * versine * (2.0 - versine)
    return sine, versine, excess


def _double_root(scaled_r0: float, sigma: float, mean: Array) -> Array:
    """Kepler's equation in double precision by Newton's method inside a shrinking bracket."""
    low, high, x = mean - 2.0, mean + 2.0, mean
    for _ in range(BISECTIONS):
        sine, versine, excess = circle(x)
        gap = scaled_r0 * sine + excess + sigma * versine - mean
        low, high = np.where(gap < 0.0, x, low), np.where(gap < 0.0, high, x)
        with np.errstate(divide="ignore", invalid="ignore"):
            newton = x - gap / (scaled_r0 + (1.0 - scaled_r0) * versine + sigma * sine)
        x = np.where((newton > low) & (newton < high), newton, 0.5 * (low + high))
    return x


@dataclass(frozen=True)
class Kepler:
    """A CentralForce on a scalar mass in 2 or 3 dimensions, or two bodies; bound, not radial.

    Setting: samples. The start is taken as exact, t - t0 likewise, and the error of q stays within
    4 eps (|q| + |v| |t - t0|), eps = 2.2e-16, at eccentricities up to 0.999999.
    """

    fixed_step: ClassVar[bool] = False

    name: str = "Kepler, closed form"
    exact: bool = True
    missing: str = ""

    def supports(self, problem: Problem) -> bool:
        """A CentralForce on a scalar mass, or two bodies without forces, on an ellipse."""
        return _orbit(problem) is not None

    def run(self, problem: Problem, duration: float, setting: Mapping[str, Any]) -> Trajectory:
        """States at evenly spaced times; see `Contender`."""
        times = times_of_run(self, problem, duration, setting)
        ellipse = _orbit(problem)
        assert ellipse is not None
        q, v = _motion(problem, ellipse, times - problem.t0)
        return as_trajectory(
            problem, described(self.name, setting), times, q, v, counts={"steps": 0}
        )


def _orbit(problem: Problem) -> Orbit | None:
    """The orbit about the centre, or of the second body about the first; None if unsupported."""
    system, q0, v0 = problem.system, problem.q0, problem.v0
    with localcontext(DIGITS):
        if isinstance(system, Canonical) and is_moved_by(problem, CentralForce):
            if system.mass.ndim:
                return None
            gm = Decimal(system.potential.mu) / Decimal(float(system.mass))
            return orbit(gm, [Decimal(x) for x in q0.tolist()], [Decimal(x) for x in v0.tolist()])
        if isinstance(system, NBody) and system.masses.size == 2 and not system.forces:
            gm = Decimal(system.G) * sum(map(Decimal, system.masses.tolist()))
            relative_state = [
                [Decimal(b) - Decimal(a) for a, b in zip(*x.tolist(), strict=True)]
                for x in (q0, v0)
            ]
            return orbit(gm, *relative_state)
    return None


def _motion(problem: Problem, ellipse: Orbit, t: Array) -> tuple[Array, Array]:
    """q and v of the problem, (k, ...), at times t (k,) since the start."""
    q0, v0 = (DoubleDouble(x, np.zeros_like(x)) for x in (problem.q0, problem.v0))
    if not isinstance(problem.system, NBody):
        q, v = flow(ellipse, q0, v0, t)
        return q.hi, v.hi
    masses = problem.system.masses
    share = DoubleDouble(masses) / (DoubleDouble(masses[0]) + masses[1])
    moving_q, moving_v = (share[0] * x[0] + share[1] * x[1] for x in (q0, v0))
    q, v = flow(ellipse, q0[1] - q0[0], v0[1] - v0[0], t)
    centre = moving_q + moving_v * t[:, None]
    positions = (centre - share[1] * q, centre + share[0] * q)
    speeds = (moving_v - share[1] * v, moving_v + share[0] * v)
    return np.stack([x.hi for x in positions], axis=1), np.stack([x.hi for x in speeds], axis=1)


KEPLER = Kepler()
