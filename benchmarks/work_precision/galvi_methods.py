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

SAVE_LAST_ONLY = 2**62  # value of save_every that saves the last state only
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
        """The name in titles and tables, e.g. 'galvi Gauss collocation, 8 stages'."""
        return f"galvi {self.method.name}"

    @property
    def order(self) -> int:
        """The order of convergence."""
        return self.method.order

    def supports(self, problem: Problem) -> bool:
        """Whether the problem's system is one of SYSTEMS."""
        return isinstance(problem.system, SYSTEMS)

    def stops_early(self, setting: Mapping[str, Any]) -> bool:
        """Whether the iteration of a step may end before it has converged."""
        return "tolerance" in setting or getattr(self.method.chart, "passes", None) is not None

    def run(self, problem: Problem, duration: float, setting: Mapping[str, Any]) -> Trajectory:
        """Run equal steps from t0 to t0 + duration, which is negative for a run backwards."""
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
    """A `galvi.Galerkin` method with a clock.

    Setting: step, in units of the clock, and samples, the number of evenly spaced states (default:
    1, the end); or save_every, for states after steps.
    """

    method: galvi.Galerkin
    exact: bool = False
    missing: str = ""

    @property
    def name(self) -> str:
        """The name in titles and tables."""
        return f"galvi {self.method.name}"

    def supports(self, problem: Problem) -> bool:
        """Whether the system is one of SYSTEMS, with attracting pairs for N bodies, and the clock
        is defined for it."""
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
        """Run to t0 + duration, which is negative for a run backwards, with states at the
        samples."""
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
    """Polynomials of degree `stages` with as many Gauss points, in a clock."""
    return InClock(galvi.Galerkin(galvi.Polynomials(stages), galvi.gauss(stages), clock=clock))


def gauss_collocation(stages: int, chart: Any = None) -> Variational:
    """Polynomials of degree s = `stages` with s Gauss points, of order 2 s.

    Parameters
    ----------
    chart
        chart of the polynomials on a group; None for the default
    """
    charts = {} if chart is None else {"chart": chart}
    return Variational(galvi.Galerkin(galvi.Polynomials(stages), galvi.gauss(stages), **charts))
