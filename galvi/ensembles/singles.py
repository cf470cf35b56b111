"""Members that run one by one through `galvi.integrate`, from their starts."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np

from galvi.arrays import Array
from galvi.ensembles.keep import Keep, Record, TimeGrid
from galvi.ensembles.parameters import Parameters
from galvi.input_checks import shown
from galvi.method import Galerkin
from galvi.problem import Problem
from galvi.run.integrate import checked
from galvi.run.interruption import uninterrupted
from galvi.run.loop import run_steps
from galvi.run.plan import check_memory
from galvi.trajectory import Trajectory


class Single(NamedTuple):
    """What a run by itself leaves: values without the members' axis, and how it ended."""

    values: tuple[Array, ...]
    status: str
    failed: int
    passes: int


class Singles:
    """The members of an ensemble as runs by themselves, whose energies are not judged."""

    def __init__(
        self, parameters: Parameters, method: Galerkin, plan: TimeGrid, q: Array, v: Array,
        tolerance: float | None, solver: str,
    ) -> None:  # fmt: skip
        self.parameters, self.method, self.plan = parameters, method, plan
        self.q, self.v = q, v
        self.options: dict[str, Any] = {"tolerance": tolerance, "solver": solver}

    def problem(self, member: int) -> Problem:
        """The problem of one member."""
        own = self.parameters.problem
        system = self.parameters.system(member)
        return replace(own, system=system, q0=self.q[member], v0=self.v[member])

    def run(self, member: int, curves: bool) -> Callable[..., Trajectory]:
        """The run of one member; ValueError for a start or numbers that cannot be run."""
        problem, steps = self.problem(member), self.plan.steps
        step, options = float(self.plan.step[member]), self.options
        engine, run = checked(problem, self.method, step, steps, curves=curves, **options)
        check_memory([run])
        return lambda: uninterrupted(run_steps(engine, run, watched=False))

    def kept(self, member: int, keep: Keep) -> Single:
        """Reduced result of one member; a refused one counts as failed at its first step.

        Its status is then what refused it.
        """
        plan = self.plan._replace(step=self.plan.step[member : member + 1])
        record = keep.begin(plan)
        try:
            begun = self.run(member, curves=False)
        except ValueError as error:
            q, p = np.full((1, *plan.q_shape), np.nan), np.full((1, *plan.p_shape), np.nan)
            for k in keep.steps(plan):
                record.see(k, plan.t0 + k * plan.step, q, p)
            return Single(_of_one(record), str(error), 1, 0)
        run = begun()
        for k in keep.steps(plan):
            record.see(k, run.t[k : k + 1], run.q[k : k + 1], run.p[k : k + 1])
        return _single(_of_one(record), run)

    def returned(self, member: int, function: Callable[[Trajectory], Any]) -> Single:
        """What a function of the run returns."""
        run = self.run(member, curves=self.plan.steps <= 10**4)()
        value = function(run)
        try:
            kept = np.asarray(value, dtype=np.float64)
        except (TypeError, ValueError):
            raise TypeError(
                f"the function given as keep must return numbers; it returned {shown(value)}. "
                f"`integrate_many` returns runs."
            ) from None
        return _single((kept,), run)


def _of_one(record: Record) -> tuple[Array, ...]:
    return tuple(value[0] for value in record.result())


def _single(values: tuple[Array, ...], run: Trajectory) -> Single:
    return Single(values, run.status, run.failed_step or 0, run.counts["iterations"])
