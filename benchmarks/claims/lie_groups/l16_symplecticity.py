"""L16: a step is symplectic on every group, in left trivialisation (H 3.1.1)."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import partial
from typing import Any

import numpy as np

import galvi
from benchmarks.claims.kit import Array, Fault, MakeMethod, Problem, Report, scaled
from benchmarks.measures.symplectic_form import StepMap, form_defect
from benchmarks.test_problems import thrown_plate
from benchmarks.test_problems.body_on_cart import body_on_cart
from benchmarks.test_problems.hung_body import HUNG_BODY
from benchmarks.test_problems.joined_pendulums import JOINED_PENDULUMS
from galvi.charts import CHARTS
from galvi.systems.lagrangian import velocity_at

STEP = 0.4
RULES = (galvi.gauss(4), galvi.lobatto(5), galvi.clenshaw_curtis(6))
FLOWS = {
    "body hung by a spring on SE(3)": HUNG_BODY,
    "joined pendulums on SO(3) x SO(3)": JOINED_PENDULUMS,
}
PROBLEMS: Mapping[str, Callable[[], Problem]] = {
    "free rigid body on SO(3)": galvi.problems.free_rigid_body,
    "3D pendulum on SO(3)": galvi.problems.pendulum_3d,
    "thrown plate on SE(2)": thrown_plate.problem,
    "body on a cart on SO(3) x R": body_on_cart,
    **{label: flow.problem for label, flow in FLOWS.items()},
}


def measure(make_method: MakeMethod, quick: bool, report: Report) -> dict[str, float]:
    """The largest defect over RULES for each problem and chart, and the defects of exact flows."""
    numbers = {}
    for label, make_problem in PROBLEMS.items():
        report(label)
        start = make_problem()
        starts: dict[bytes, Problem] = {}  # of all charts and rules
        for chart in CHARTS:
            methods = [make_method(galvi.Polynomials(4), rule, chart) for rule in RULES]
            steps = [partial(step_from, starts, start.system, method) for method in methods]
            name = f"defect of the form, {label}, {type(chart).__name__} chart"
            numbers[name] = np.max([defect(step, start) for step in steps])
    for label, flow in FLOWS.items():
        report(f"{label}, exact flow")
        exact = partial(flow.flow, duration=STEP)
        numbers[f"defect of the form, {label}, exact flow"] = defect(exact, flow.problem())
    return numbers


def step_from(
    starts: dict[bytes, Problem], system: Any, method: Any, g: Array, mu: Array
) -> tuple[Array, Array]:
    """(g, mu) after a step from (g, mu); NaN if the step fails.

    `starts` caches the problem of each state.
    """
    key = g.tobytes() + mu.tobytes()
    if key not in starts:
        starts[key] = Problem(system, g, velocity_at(system, g, mu, 0.0))
    run = galvi.integrate(starts[key], method, STEP, 1)
    return run.q[-1], run.p[-1]


def defect(step: StepMap, start: Problem) -> float:
    """The defect of the symplectic form for the step from a start; NaN for a failed step."""
    system: Any = start.system
    if np.any(np.isnan(step(start.q0, start.p0)[1])):
        return np.nan
    return form_defect(step, system.group, start.q0, start.p0)


FAULTS = {
    "momenta a billionth off": Fault(
        wrong={
            f"{__name__}.step_from": scaled(1.0 + 1e-9),
            "benchmarks.test_problems.coupled.Coupled.flow": scaled(1.0 + 1e-9),
        }
    )
}
