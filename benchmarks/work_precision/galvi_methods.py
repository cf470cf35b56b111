"""galvi's methods as contenders, with the same interface as the references."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import galvi
from galvi import Problem, Trajectory
from references.contender import require
from references.setting import check_keys, fixed_steps

SYSTEMS = (galvi.Canonical, galvi.NBody, galvi.Lagrangian, galvi.RigidBody, galvi.FreeBody)


@dataclass(frozen=True)
class Variational:
    """A `galvi.Galerkin` method; setting: step, save_every, solver, tolerance.

    No curves are kept unless every step is saved. Errors as in `references.Contender`.
    """

    method: galvi.Galerkin
    exact: bool = False
    missing: str = ""

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

    def run(self, problem: Problem, duration: float, setting: Mapping[str, Any]) -> Trajectory:
        """Equal steps from t0 to t0 + duration, negative for backwards."""
        require(self, problem)
        check_keys(setting, ("step", "save_every", "solver", "tolerance"))
        steps = fixed_steps(duration, setting)
        return galvi.integrate(
            problem,
            self.method,
            steps.step,
            steps.count,
            save_every=setting.get("save_every", 1),
            solver=setting.get("solver", "auto"),
            tolerance=setting.get("tolerance"),
        )


def gauss_collocation(stages: int, chart: Any = None) -> Variational:
    """Polynomials of degree s with s Gauss points: order 2 s by the cheapest rule.

    chart  chart of the polynomials on a group; None for the default
    """
    charts = {} if chart is None else {"chart": chart}
    return Variational(galvi.Galerkin(galvi.Polynomials(stages), galvi.gauss(stages), **charts))
