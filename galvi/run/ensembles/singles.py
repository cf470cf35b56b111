"""Members that run one by one through `galvi.integrate`, from their starts."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np

from galvi.arrays import Array
from galvi.method import Galerkin
from galvi.problem import Problem
from galvi.run.ensembles.keep import Keep, Plan
from galvi.run.ensembles.parameters import Parameters
from galvi.run.integrate import integrate
from galvi.run.interruption import uninterrupted
from galvi.trajectory import Trajectory


class Single(NamedTuple):
    """What a run by itself leaves: values without the members' axis, and how it ended."""

    values: tuple[Array, ...]
    status: str
    failed: int
    passes: int


class Singles:
    """The members of an ensemble as runs by themselves."""

    def __init__(
        self, parameters: Parameters, method: Galerkin, plan: Plan, q: Array, v: Array,
        tolerance: float | None, solver: str,
    ) -> None:  # fmt: skip
        self.parameters, self.method, self.plan = parameters, method, plan
        self.q, self.v, self.options = q, v, {"tolerance": tolerance, "solver": solver}

    def problem(self, member: int) -> Problem:
        """The problem of one member."""
        own = self.parameters.problem
        system = self.parameters.system(member)
        return replace(own, system=system, q0=self.q[member], v0=self.v[member])

    def trajectory(self, member: int, curves: bool) -> Trajectory:
        """The run of one member."""
        step = float(self.plan.step[member])
        options: dict[str, Any] = self.options
        return uninterrupted(integrate(
            self.problem(member), self.method, step, self.plan.steps, curves=curves, **options
        ))  # fmt: skip

    def kept(self, member: int, keep: Keep) -> Single:
        """What ``keep`` keeps of one member."""
        run = self.trajectory(member, curves=False)
        plan = self.plan._replace(step=self.plan.step[member : member + 1])
        record = keep.begin(plan)
        for k in keep.steps(plan):
            record.see(k, run.t[k : k + 1], run.q[k : k + 1], run.p[k : k + 1])
        return self._single(tuple(value[0] for value in record.result()), run)

    def returned(self, member: int, function: Callable[[Trajectory], Any]) -> Single:
        """What a function of the run returns."""
        run = self.trajectory(member, curves=self.plan.steps <= 10**4)
        return self._single((np.asarray(function(run), dtype=np.float64),), run)

    @staticmethod
    def _single(values: tuple[Array, ...], run: Trajectory) -> Single:
        return Single(values, run.status, run.failed_step or 0, run.counts["iterations"])
