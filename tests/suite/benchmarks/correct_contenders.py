"""Correct contenders of users: compositions of leapfrog and Runge and Kutta's method, compiled and
independent of galvi, Gauss collocation, and SciPy's DOP853."""

from __future__ import annotations

from typing import Any

import numpy as np

import galvi
from benchmarks.work_precision.galvi_methods import gauss_collocation
from references.scipy.ivp import DOP853
from references.textbook.fourth_order import RK4
from references.textbook.nystrom import splitting
from tests.suite.benchmarks.contenders_at_hand import Stepped, altered

# Composition of leapfrog: Yoshida, Phys. Lett. A 150 (1990) 262; of order 6 his solution A, of
# order 8 the triple jump.
SIX = (0.784513610477560, 0.235573213359357, -1.17767998417887)


def triple_jump(order: int) -> list[float]:
    """Fractions of a step for leapfrog that compose a step of this order."""
    if order == 2:
        return [1.0]
    inner = triple_jump(order - 2)
    outside = 1.0 / (2.0 - 2.0 ** (1.0 / (order - 1)))
    return [w * x for w in (outside, 1.0 - 2.0 * outside, outside) for x in inner]


class Compiled(Stepped):
    """A reference as a user's contender, or the composition of leapfrog with these weights."""

    def __init__(
        self,
        name: str,
        order: float,
        symplectic: bool,
        step_counts: Any,
        weights: Any = (),
        inner: Any = None,
    ) -> None:
        kicks = np.array(weights)
        kicks[len(kicks) // 2 :][:1] += 1.0 - sum(kicks)  # so that the sum is 1 despite rounding
        self.name, self.order, self.step_counts = name, order, step_counts
        self.inner = inner or splitting(
            name, order=order, nodes=np.cumsum(kicks) - kicks / 2.0, kicks=kicks
        )
        self.conserves = {"energy": 0.1, "angular momentum": 1e-10} if symplectic else {}

    def supports(self, problem: galvi.Problem) -> bool:
        return isinstance(problem.system, galvi.Canonical | galvi.NBody)

    def run(self, problem: galvi.Problem, duration: float, setting: Any) -> galvi.Trajectory:
        return altered(self.inner.run(problem, duration, setting))


SIXTH_ORDER = (*SIX, 1.0 - 2.0 * sum(SIX), *SIX[::-1])
FOUR = triple_jump(4)
METHODS: dict[str, dict[str, Any]] = {
    "leapfrog": {"order": 2, "symplectic": True, "weights": [1.0]},
    "Yoshida 4": {"order": 4, "symplectic": True, "weights": FOUR},
    "Yoshida 6": {"order": 6, "symplectic": True, "weights": SIXTH_ORDER},
    "Yoshida 8": {"order": 8, "symplectic": True, "weights": triple_jump(8)},
    "Runge-Kutta 4": {"order": 4, "symplectic": False, "inner": RK4},
    **{
        f"Gauss {2 * s}": {"order": 2 * s, "symplectic": True, "inner": gauss_collocation(s)}
        for s in (1, 2, 3, 4)
    },
}
SETTINGS = {  # numbers of steps, relative to those of docs/suite.md
    "10 times coarser": (100, 400, 1600),
    "of the page": (1000, 4000, 16000),
    "10 times finer": (10_000, 40_000, 160_000),
}


class Adaptive(Stepped):
    """SciPy's DOP853; `tolerances` are the negative exponents of 10 in its settings."""

    name, order, tolerances, conserves = "DOP853", 8, (6, 9, 12), {}

    def supports(self, problem: galvi.Problem) -> bool:
        return type(problem.system) is galvi.Canonical and problem.system.force is None

    def settings(self, problem: galvi.Problem, duration: float) -> list[dict[str, Any]]:
        return [{"tolerance": 10.0**-k} for k in self.tolerances]

    def run(self, problem: galvi.Problem, duration: float, setting: Any) -> galvi.Trajectory:
        return altered(DOP853.run(problem, duration, setting))
