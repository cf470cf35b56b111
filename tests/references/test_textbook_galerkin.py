"""The integrator of one page against galvi, on R^d and on SO(3), and faults in its parts."""

from dataclasses import replace

import numpy as np
import pytest

import galvi
from references.textbook import galerkin as page
from references.textbook.galerkin import Galerkin, Rotations, VectorSpace

RULES = {"Gauss": galvi.gauss, "Lobatto": galvi.lobatto, "Clenshaw-Curtis": galvi.clenshaw_curtis}
J, WEIGHT = np.diag([4.8, 3.0, 3.8]), np.array([0.0, 0.0, 9.81])


def kepler(q, v):
    return 0.5 * v @ v + 1.0 / np.sqrt(q @ q)


def pendulum(q, v):
    """Two rods of unit mass and length: the mass depends on the angles."""
    return (
        v[0] ** 2
        + 0.5 * v[1] ** 2
        + v[0] * v[1] * np.cos(q[0] - q[1])
        + 2.0 * np.cos(q[0])
        + np.cos(q[1])
    )


def body(R, w):
    """A rigid body below a pivot, its centre of mass on its third axis."""
    return 0.5 * w @ (J @ w) + WEIGHT @ (R @ np.array([0.0, 0.0, 1.0]))


def orbit():
    return galvi.Problem(galvi.Lagrangian(kepler, galvi.Rn(2)), [0.4, 0.0], [0.0, 2.0])


SYSTEMS = {
    "Kepler": (kepler, VectorSpace(), orbit),
    "double pendulum": (
        pendulum,
        VectorSpace(),
        lambda: galvi.Problem(galvi.Lagrangian(pendulum, galvi.Rn(2)), [1.0, 0.5], [0.1, -0.3]),
    ),
    "body on a pivot": (body, Rotations(), lambda: galvi.problems.pendulum_3d()),
}
CASES = [
    (6, "Gauss", 6),
    (4, "Gauss", 3),
    (5, "Gauss", 8),
    (5, "Lobatto", 6),
    (4, "Clenshaw-Curtis", 7),
]


def runs_of(name, n, rule, points, h=0.1, steps=4):
    """The runs of a system by galvi and by the page, in this order."""
    L, chart, problem = SYSTEMS[name]
    rule = RULES[rule](points)
    by_galvi = galvi.integrate(
        problem(), galvi.Galerkin(galvi.Polynomials(n - 1), rule), h, steps, solver="newton"
    )
    method = Galerkin(n, np.asarray(rule.nodes), np.asarray(rule.weights), chart)
    return by_galvi, method.run(L, problem().q0, problem().v0, h, steps)


@pytest.mark.slow_cases(
    "Kepler-6-Gauss-6",
    "double pendulum-6-Gauss-6",
    "body on a pivot-6-Gauss-6",
    "body on a pivot-4-Gauss-3",
    "body on a pivot-5-Gauss-8",
    "body on a pivot-5-Lobatto-6",
    "body on a pivot-4-Clenshaw-Curtis-7",
)
@pytest.mark.parametrize(("n", "rule", "points"), CASES)
@pytest.mark.parametrize("name", SYSTEMS)
def test_galvi_computes_what_the_page_says(name, n, rule, points):
    by_galvi, by_page = runs_of(name, n, rule, points)
    assert by_galvi.success, by_galvi.status
    assert np.max(np.abs(by_galvi.q - by_page.q)) < 1e-14  # 2e-15
    assert np.max(np.abs(by_galvi.p.reshape(5, -1) - by_page.p)) < 1e-13
    for t in (0.013, 0.1, 0.27, 0.4):
        q, v = by_page.at(t)
        assert np.max(np.abs(by_galvi(t) - q)) < 1e-13
        assert np.max(np.abs(by_galvi.velocity(t).ravel() - v)) < 1e-12


FAULTS = {
    "weights that do not sum to 1": ("weights", lambda method: replace(method, b=1.01 * method.b)),
    "velocities of the other sign": ("velocity", lambda chart: lambda x, rate: -rate),
    "momenta without the chart": ("tangent", lambda chart: lambda x: -2.0 * np.eye(3)),
    "a chart that stays": ("carried", lambda chart: lambda x, p: p),
}


@pytest.mark.slow_cases(but=["velocities of the other sign"])
@pytest.mark.parametrize("fault", FAULTS)
def test_a_fault_of_the_page_is_seen(fault, monkeypatch):
    part, change = FAULTS[fault]
    name = "body on a pivot"
    L, chart, problem = SYSTEMS[name]
    rule = galvi.gauss(4)
    method = Galerkin(5, np.asarray(rule.nodes), np.asarray(rule.weights), chart)
    if part == "weights":
        method = change(method)
    else:
        monkeypatch.setattr(page.Rotations, part, lambda self, *arguments: change(self)(*arguments))
    by_galvi = galvi.integrate(problem(), galvi.Galerkin(galvi.Polynomials(4), rule), 0.1, 3)
    try:
        by_page = method.run(L, problem().q0, problem().v0, 0.1, 3)
    except (ArithmeticError, np.linalg.LinAlgError):
        return
    assert not np.max(np.abs(by_galvi.q - by_page.q)) < 1e-6
