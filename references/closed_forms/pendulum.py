"""The plane pendulum in closed form: swinging, going round, at rest, and in between."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from decimal import Decimal, localcontext
from typing import Any

import numpy as np

from galvi import PendulumWeight, Problem, Trajectory
from references.as_trajectory import outcome
from references.closed_forms.decimal_trigonometry import DIGITS, PI, angle, sine_cosine
from references.closed_forms.elliptic import Modulus, first_integral
from references.contender import require
from references.newton import is_moved_by
from references.setting import check_keys, described, sample_times


@dataclass(frozen=True)
class Pendulum:
    """A PendulumWeight on a scalar or diagonal mass; every angle is a pendulum of its own.

    With k^2 = m v^2 / (4 weight) + sin^2(q / 2) at the start and rate^2 = weight / m:
      k < 1  q = 2 asin(k sn u),     u = u0 + rate t, modulus k
      k > 1  q = 2 am u,             u = u0 +- k rate t, modulus 1 / k
      k = 1  q = 2 asin(tanh u),     u = u0 +- rate t

    Setting: samples. The start is taken as exact, t - t0 likewise, and q and v come out rounded
    once: within eps / 2 of the exact motion of that start, however long the run.
    """

    name: str = "pendulum, closed form"
    exact: bool = True
    missing: str = ""

    def supports(self, problem: Problem) -> bool:
        """Canonical systems whose only force is the pendulum's weight."""
        return is_moved_by(problem, PendulumWeight)

    def run(self, problem: Problem, duration: float, setting: Mapping[str, Any]) -> Trajectory:
        """States at evenly spaced times; see `Contender`."""
        require(self, problem)
        check_keys(setting, ("samples",))
        times = sample_times(problem.t0, duration, setting)
        system: Any = problem.system
        masses = np.broadcast_to(system.mass, problem.q0.shape)
        states = np.empty((2, len(times), problem.q0.size))
        with localcontext(DIGITS):
            for k, start in enumerate(zip(masses, problem.q0, problem.v0, strict=True)):
                moving = _motion(Decimal(system.potential.weight), *map(Decimal, start))
                states[:, :, k] = np.array([moving(Decimal(t)) for t in times - problem.t0]).T
        return outcome(problem, described(self.name, setting), times, *states, counts={"steps": 0})


Motion = Callable[[Decimal], tuple[Decimal, Decimal]]


def _motion(weight: Decimal, mass: Decimal, q0: Decimal, v0: Decimal) -> Motion:
    """(q, v) as a function of the time since the start."""
    sense = 1 if v0 >= 0 else -1  # mirrored, it moves to the right
    turns = (q0 / (2 * PI)).to_integral_value()
    sine, cosine = sine_cosine(sense * (q0 / 2 - turns * PI))
    rate, spun = (weight / mass).sqrt(), mass * v0 * v0 / (4 * weight)
    square, excess = spun + sine * sine, spun - cosine * cosine  # k^2 and k^2 - 1
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
            even = 1 if halves % 2 == 0 else -1
            half = halves * PI + angle(even * sn, even * cn)
        return 2 * (turns * PI + sense * half), sense * 2 * rate * k * speed

    return state


PENDULUM = Pendulum()
