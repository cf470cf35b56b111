"""L10: interpolating curves on a group are equivariant (H lemma 3.2.1)."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from itertools import product
from typing import Any

import numpy as np

import galvi
from benchmarks.claims.kit import (
    Array,
    Fault,
    MakeMethod,
    Problem,
    Report,
    failure,
    scaled,
    with_arguments,
)
from benchmarks.measures.matrix_group import MatrixGroup
from galvi.charts import CHARTS
from galvi.charts.chart import Chart, coordinates, place
from galvi.groups import GROUPS
from galvi.groups.group import Group

GROUP_OF_NAME: Mapping[str, Group] = dict(
    zip(("R2", "SO2", "SE2", "SO3", "SE3", "SO3 x R1 x SO2"), GROUPS, strict=True)
)
BODIES = {"SO3": galvi.problems.free_rigid_body(), "SE3": galvi.problems.free_body_se3()}
NODES = np.array([0.0, 0.1, 0.3, 0.7, 1.0])  # t_i; the first point is the base point
TIMES = np.linspace(0.0, 1.0, 21)
TURN = 0.6  # standard deviation of the points' coordinates: rotations by up to about 2 rad
N, STEP, STEPS = 6, 0.4, 10


def measure(make_method: MakeMethod, quick: bool, report: Report) -> dict[str, float | str]:
    """The largest differences of random curves of each group and chart, and of curves of runs."""
    rng = np.random.default_rng(2013)
    numbers: dict[str, float | str] = {}
    for (name, group), chart in product(GROUP_OF_NAME.items(), CHARTS):
        label = f"{name}, {type(chart).__name__}"
        report(label)
        curves = [differences_of_points(group, chart, rng) for _ in range(5 if quick else 20)]
        defect, distance = np.max(curves, axis=0)
        numbers[f"largest defect of the interpolating curve, {label}"] = defect
        numbers[f"largest distance to the points, of the curve, {label}"] = distance
    for (name, body), chart in product(BODIES.items(), CHARTS):
        method = make_method(galvi.Polynomials(N - 1), galvi.gauss(N), chart)
        label = f"{name}, {type(chart).__name__}"
        numbers[f"largest defect of a run's curve, {label}"] = difference_of_runs(body, method, rng)
    return numbers


def differences_of_points(
    group: Group, chart: Chart, rng: np.random.Generator
) -> tuple[float, float]:
    """(largest difference of the moved curve and the curve of the moved points, largest distance of
    the curve from its points) for random points."""
    matrices = MatrixGroup(group)
    unit = matrices.element(np.eye(matrices.basis.shape[-1]))
    start, g = (matrices.moved(unit, rng.standard_normal(group.dimension)) for _ in range(2))
    steps = TURN * rng.standard_normal((NODES.size, group.dimension))
    points = np.array([start, *(matrices.chart(chart, start, xi) for xi in steps[1:])])
    curve = interpolated(chart, group, points, TIMES)
    moved = interpolated(chart, group, from_left(matrices, g, points), TIMES)
    at_nodes = interpolated(chart, group, points, NODES)
    return np.max(abs(moved - from_left(matrices, g, curve))), np.max(abs(at_nodes - points))


def difference_of_runs(body: Problem, method: Any, rng: np.random.Generator) -> float | str:
    """The largest difference of the curve of a run from g q0 and of g times the curve from q0, or
    the status of a failed run."""
    system: Any = body.system
    matrices = MatrixGroup(system.group)
    g = matrices.moved(body.q0, rng.standard_normal(system.group.dimension))
    moved = replace(body, q0=from_left(matrices, g, body.q0[None])[0])
    first, second = (galvi.integrate(start, method, STEP, STEPS) for start in (body, moved))
    t = np.linspace(0.0, STEP * STEPS, 20 * STEPS + 1)
    difference = second(t) - from_left(matrices, g, first(t))
    return failure(first) or failure(second) or np.max(abs(difference))


def interpolated(chart: Chart, group: Group, points: Array, t: Array) -> Array:
    """The curve g_1 Phi(sum_i Phi^-1(g_1^-1 g_i) phi_i(t)) at the times t (k,), (k, ...); phi_i are
    Lagrange's polynomials on NODES."""
    xi = coordinates(chart, group, points[0], points)
    phi = [np.prod([(t - u) / (s - u) for u in NODES if u != s], axis=0) for s in NODES]
    return place(chart, group, points[0], np.stack(phi, axis=1) @ xi)


def from_left(matrices: MatrixGroup, g: Array, elements: Array) -> Array:
    """g k for each element k, as products of matrices."""
    return np.array([matrices.element(matrices.matrix(g) @ matrices.matrix(k)) for k in elements])


def from_the_identity(
    chart: Chart, group: Group, points: Array, t: Array
) -> tuple[Chart, Group, Array, Array]:
    """Arguments of `interpolated` for a planted fault: the chart is at the identity and does not
    move with the points."""
    unit = group.multiply(points[0], group.inverse(points[0]))
    return chart, group, np.array([unit, *points[1:]]), t


FAULTS = {
    "a chart that is no inverse": Fault(wrong={f"{__name__}.coordinates": scaled(1.0 + 1e-9)}),
    "a chart at the identity": Fault(
        wrong={f"{__name__}.interpolated": with_arguments(from_the_identity)}
    ),
}
