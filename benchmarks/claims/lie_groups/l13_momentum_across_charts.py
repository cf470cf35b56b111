"""L13: the momentum is matched where the chart changes (H 3.2.2, 3.4.3)."""

from __future__ import annotations

import numpy as np

import galvi
from benchmarks.claims.kit import (
    CAYLEY,
    Array,
    MakeMethod,
    Report,
    Trajectory,
    collocation,
    method_on_group,
)
from benchmarks.claims.lie_groups.free_body import STEP, problem
from benchmarks.measures.discrete_momenta import discrete_momenta
from benchmarks.measures.rigid_invariants import spatial_momentum
from galvi.charts import CHARTS

N = 8


def measure(make_method: MakeMethod, quick: bool, report: Report) -> dict[str, float]:
    """Largest differences of momenta over 1000 steps, 200 in the quick form, relative to |mu0|."""
    body = problem()
    steps = 200 if quick else 1000
    report(f"{steps} steps in each chart")
    methods = {chart: method_on_group(make_method, N, chart) for chart in CHARTS}
    runs = {chart: galvi.integrate(body, methods[chart], STEP, steps) for chart in CHARTS}
    packed = galvi.integrate(body, collocation(make_method, N), STEP, steps)
    differences = of_curves(runs[CAYLEY], N, "") | of_curves(packed, N + 1, ", packed kernel")
    for chart, run in runs.items():
        differences[f"spatial angular momentum, {chart.name} chart"] = change_in_space(run.q, run.p)
    size = np.linalg.norm(body.p0)
    return {
        f"largest error of {name}": np.max(np.linalg.norm(values, axis=-1)) / size
        for name, values in differences.items()
    }


def of_curves(run: Trajectory, n: int, kernel: str) -> dict[str, Array]:
    """Name -> differences of momenta, (k, 3): the momenta at both ends of each step, by its curve,
    minus those of the run and those of the next step."""
    before, after = discrete_momenta(run, n, N)
    return {
        f"D1 L_d of a step against the run's momentum at its start{kernel}": before - run.p[:-1],
        f"D2 L_d of a step against the run's momentum at its end{kernel}": after - run.p[1:],
        f"D2 L_d of a step plus D1 L_d of the next{kernel}": after[:-1] - before[1:],
        f"spatial angular momentum R D2 L_d, from the curves alone{kernel}": change_in_space(
            run.q[1:], after
        ),
    }


def change_in_space(R: Array, p: Array) -> Array:
    """R p minus its value at the start of the motion, (k, 3)."""
    body = problem()
    return spatial_momentum(R, p) - body.q0 @ body.p0
