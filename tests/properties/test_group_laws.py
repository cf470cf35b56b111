"""Laws on groups in lanes: the reach of their charts, their memory, and planted faults."""

import numpy as np
import pytest

import galvi
from galvi.kernels.lie import rotations
from galvi.kernels.lie.groups import so3
from galvi.lanes.group_collocation import Chart
from galvi.lanes.loops import OneRun
from galvi.run.in_lanes.law_kernel import LawKernel
from galvi.systems.traces import Untraceable
from galvi.tracing.traced_lagrangian import traced_lagrangian
from tests.agreement.on_groups import Q0, bulging
from tests.properties.group_lagrangians import swelling


def test_a_curve_that_leaves_the_reach_of_lanes_and_returns_is_left_to_newtons_method():
    """L = v^2 / 2 + a t v_z: a rotation by 10 t - 10 t^2, at most 2.5, and none after the step."""

    def L(R, v, t):
        return 0.5 * (v @ v) + 20.0 * t * v[2]

    system = galvi.Lagrangian(L, galvi.SO3(), explicit_time=True)
    problem = galvi.Problem(system, np.eye(3), [0.0, 0.0, 10.0])
    method = galvi.Galerkin(galvi.Polynomials(4), galvi.gauss(4), galvi.Exponential())
    for step, leaves_reach in ((1.0, True), (0.1, False)):
        run = galvi.integrate(problem, method, step, 1)
        assert run.success and (run.counts["linear_solves"] > 0) is leaves_reach
        angle = np.arctan2(run.q[-1][1, 0], run.q[-1][0, 0])
        assert angle == pytest.approx(10.0 * step - 10.0 * step**2, abs=1e-12)


def test_an_angular_momentum_is_measured_with_what_displacements_make_of_a_momentum():
    """Otherwise the rounding of the moment costs a body that hardly turns 14 passes a step."""
    body = galvi.FreeBody(2.0, (1.0, 2.0, 2.5))
    problem = galvi.Problem(body, np.eye(4), [3e-3, 1e-2, 2e-3, 5.0, -4.0, 7.0])
    method = galvi.Galerkin(galvi.Polynomials(6), galvi.gauss(6), galvi.Exponential())
    run = galvi.integrate(problem, method, 0.2, 1000, save_every=1000)
    assert run.counts["linear_solves"] == 0
    assert run.counts["iterations"] < 12.5 * run.counts["steps"]  # 11.5


PRODUCT_OF_VECTORS = galvi.Product((galvi.Rn(1), galvi.Rn(2)))


@pytest.mark.parametrize(
    "group", [galvi.SO2(), galvi.SE2(), galvi.SO3(), galvi.SE3(), PRODUCT_OF_VECTORS], ids=str
)
def test_a_step_reads_and_writes_no_number_beyond_the_state(group, monkeypatch):
    checked, advance = [], LawKernel.advance

    def recorded(kernel, n):
        rows, columns = kernel._work.state.shape
        for row, column, _, count in OneRun(*kernel._arguments[2]).seats:
            checked.append(row < rows and column + count <= columns)
        return advance(kernel, n)

    monkeypatch.setattr(LawKernel, "advance", recorded)
    q0 = np.eye(group.shape[0]) if len(group.shape) == 2 else np.full(group.shape, 0.3)
    system = galvi.Lagrangian(lambda q, v: 0.5 * (v @ v) - 0.1 * np.sum(q**4), group)
    problem = galvi.Problem(system, q0, 0.1 * np.arange(1.0, group.dimension + 1.0))
    method = galvi.Galerkin(galvi.Polynomials(3), galvi.gauss(3))
    runs = [
        galvi.integrate(problem, method, 0.05, 8, solver=solver) for solver in ("auto", "newton")
    ]
    assert runs[0].engine == "lanes" and checked and all(checked)
    np.testing.assert_allclose(runs[0].q, runs[1].q, rtol=0, atol=1e-13)


def test_a_planted_fault_of_a_groups_derivative_is_caught(monkeypatch):
    group, derivative = galvi.SE3(), Chart.left_derivative

    def wrong(chart, g, slope):
        slopes = derivative(chart, g, slope)
        return [slopes[1], slopes[0], *slopes[2:]] if hasattr(g[0], "graph") else slopes

    def trace():
        scales = np.ones(6), np.ones(6)
        return traced_lagrangian(bulging, None, group, Q0, np.ones(6), 0.0, False, scales)

    assert trace().holds
    monkeypatch.setattr(Chart, "left_derivative", wrong)
    with pytest.raises(Untraceable, match="its derivatives are not those of the function"):
        trace()


@pytest.mark.slow(beside="tests/agreement/test_agreement.py::test_every_chart_agrees")
def test_a_wrong_sign_in_a_formula_for_lanes_is_seen(monkeypatch):
    """The general kernel keeps the right formula, which it has compiled already."""
    method = galvi.Galerkin(galvi.Polynomials(3), galvi.gauss(4))

    def turned_back(chart, xi, mu, out):
        so3.fill(rotations.change(chart, -1.0, xi, mu), out)

    monkeypatch.setattr(so3, "coadjoint_change", turned_back)
    wrong = swelling("SO3", 11, np.sin)  # a law that is compiled here alone
    fast = galvi.integrate(wrong, method, 0.1, 20)
    general = galvi.integrate(wrong, method, 0.1, 20, solver="newton")
    assert np.abs(fast.q - general.q).max() > 1e-6
