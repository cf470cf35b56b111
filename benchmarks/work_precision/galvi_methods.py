"""galvi's methods as contenders, with the same interface as the references."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

import galvi
from galvi import Problem, Trajectory
from references.contender import require, steps_of_run
from references.setting import check_keys, sample_times

SAVE_LAST_ONLY = 2**62  # of save_every: the last state alone is kept
SYSTEMS = (galvi.Canonical, galvi.NBody, galvi.Lagrangian, galvi.RigidBody, galvi.FreeBody)


@dataclass(frozen=True)
class Variational:
    """A `galvi.Galerkin` method; setting: step, save_every, solver, tolerance.

    No curves are kept unless every step is saved. Errors as in `references.Contender`.
    """

    method: galvi.Galerkin
    exact: bool = False
    missing: str = ""
    fixed_step: bool = True

    @property
    def name(self) -> str:
        """For titles and tables, e.g. 'galvi Gauss collocation, 8 stages'."""
        return f"galvi {self.method.name}"

    @property
    def order(self) -> int:
        """Of convergence."""
        return self.method.order

    def supports(self, problem: Problem) -> bool:
        """True for any `galvi.Problem`."""
        return isinstance(problem.system, SYSTEMS)

    def stops_early(self, setting: Mapping[str, Any]) -> bool:
        """Whether the iteration of a step may end before it has converged."""
        return "tolerance" in setting or getattr(self.method.chart, "passes", None) is not None

    def run(self, problem: Problem, duration: float, setting: Mapping[str, Any]) -> Trajectory:
        """Equal steps from t0 to t0 + duration, negative for backwards."""
        steps = steps_of_run(self, problem, duration, setting, "solver", "tolerance")
        return galvi.integrate(
            problem,
            self.method,
            steps.step,
            steps.count,
            save_every=setting.get("save_every", 1),
            solver=setting.get("solver", "auto"),
            tolerance=setting.get("tolerance"),
        )


@dataclass(frozen=True)
class InClock:
    """A `galvi.Galerkin` method with a clock; setting: step, in units of the clock, and samples,
    evenly spread, of which the default is the end; or save_every, for states after steps."""

    method: galvi.Galerkin
    exact: bool = False
    missing: str = ""

    @property
    def name(self) -> str:
        """For titles and tables."""
        return f"galvi {self.method.name}"

    def supports(self, problem: Problem) -> bool:
        """Systems of one particle or more that have a time in the clock."""
        system = problem.system
        if not isinstance(system, SYSTEMS) or (
            isinstance(system, galvi.NBody) and not system.pairs
        ):
            return False
        try:
            self.method.clock.rate(problem)
        except ValueError:
            return False
        return True

    def run(self, problem: Problem, duration: float, setting: Mapping[str, Any]) -> Trajectory:
        """To t0 + duration, negative for backwards, whose states are those at the samples."""
        require(self, problem)
        check_keys(setting, ("step", "samples", "save_every"))
        times = sample_times(problem.t0, duration, {"samples": setting.get("samples", 1)})
        only_ends = len(times) == 2
        run = galvi.integrate(
            problem,
            self.method,
            math.copysign(setting["step"], duration),
            duration=abs(duration),
            save_every=setting.get("save_every", SAVE_LAST_ONLY if only_ends else 1),
            curves=False if only_ends else None,
        )
        if only_ends or not run.success:
            return run
        q, p = galvi.states_at(run, times[1:-1])
        q, p = (np.concatenate([x[:1], y, x[-1:]]) for x, y in ((run.q, q), (run.p, p)))
        return replace(run, t=times, q=q, p=p)


def in_clock(stages: int, clock: Any) -> InClock:
    """Polynomials of degree s with s Gauss points, in a clock."""
    return InClock(galvi.Galerkin(galvi.Polynomials(stages), galvi.gauss(stages), clock=clock))


def gauss_collocation(stages: int, chart: Any = None) -> Variational:
    """Polynomials of degree s with s Gauss points: order 2 s by the cheapest rule.

    Parameters
    ----------
    chart
        chart of the polynomials on a group; None for the default
    """
    charts = {} if chart is None else {"chart": chart}
    return Variational(galvi.Galerkin(galvi.Polynomials(stages), galvi.gauss(stages), **charts))
