"""Laws on groups in lanes: their maps, what they keep, and faults that are seen."""

import mpmath as mp
import numpy as np
import pytest

import galvi
from galvi.kernels.lie import rotations
from galvi.kernels.lie.groups import so3
from galvi.lanes.group_collocation import Chart, group_fields
from galvi.lanes.loops import OneRun
from galvi.run.in_lanes.law_kernel import LawKernel
from tests.properties.group_lagrangians import GROUPS, swelling
from tests.properties.group_matrices import title
from tests.properties.group_motions import (
    FREE,
    each_chart,
)

each_group = pytest.mark.parametrize("name", GROUPS)
DRIFT = 1e-16  # of the relative energy in a step
SPINNING = galvi.Problem(
    galvi.FreeBody(2.0, (1.0, 2.0, 2.5)), np.eye(4), [0.3, 1.0, 0.2, 0.5, -0.4, 0.7]
)


def test_a_curve_that_leaves_the_reach_of_lanes_and_returns_is_left_to_newtons_method():
    """L = v^2 / 2 + a t v_z: a rotation by 10 t - 10 t^2, at most 2.5, and none after the step."""

    def L(R, v, t):
        return 0.5 * (v @ v) + 20.0 * t * v[2]

    system = galvi.Lagrangian(L, galvi.SO3(), explicit_time=True)
    problem = galvi.Problem(system, np.eye(3), [0.0, 0.0, 10.0])
    method = galvi.Galerkin(galvi.Polynomials(4), galvi.gauss(4), galvi.Exponential())
    for step, beyond in ((1.0, True), (0.1, False)):
        run = galvi.integrate(problem, method, step, 1)
        assert run.success and (run.counts["linear_solves"] > 0) is beyond
        turned = np.arctan2(run.q[-1][1, 0], run.q[-1][0, 0])
        assert turned == pytest.approx(10.0 * step - 10.0 * step**2, abs=1e-12)


def check_drift(problem, chart, steps):
    """Momenta in space, energy and rotations of a free motion.

    The spin of a body far away is known to the rounding of its linear momentum's moment.
    """
    more = 1 if problem is FREE else 0
    method = galvi.Galerkin(galvi.Polynomials(6), galvi.gauss(6 + more), chart)
    run = galvi.integrate(problem, method, 0.2, steps, save_every=steps // 50)
    assert run.counts["linear_solves"] == 0
    R, far = run.q[:, :3, :3], np.linalg.norm(run.q[:, :3, 3:], axis=1).max(initial=0.0)
    moment = 2.0**-52 * far * np.linalg.norm(run.p[0, 3:])
    for first in range(0, run.p.shape[1], 3):
        spatial = np.einsum("kij,kj->ki", R, run.p[:, first : first + 3])
        size = np.linalg.norm(spatial[0])
        assert np.abs(spatial - spatial[0]).max() < 3e-14 * size + moment  # 1e-15; 0.2 of a moment
    assert galvi.orthogonality_defect(run).max() < 2e-15
    energy = galvi.energy(run) / galvi.energy(run)[0] - 1.0
    drift = np.polyfit(np.arange(51) * (steps // 50), energy, 1)[0]
    assert abs(drift) < DRIFT and np.abs(energy).max() < 1e-11


@each_chart
@pytest.mark.parametrize("problem", [FREE, SPINNING], ids=title)
def test_momenta_energy_and_the_rotation_do_not_drift(problem, chart):
    check_drift(problem, chart, 10_000)


@pytest.mark.slow(beside="test_momenta_energy_and_the_rotation_do_not_drift")
@each_chart
@pytest.mark.parametrize("problem", [FREE, SPINNING], ids=title)
def test_nothing_drifts_in_a_million_steps(problem, chart):
    check_drift(problem, chart, 1_000_000)


def random_state(group, random):
    """xi, eta and mu."""
    return 0.7 * random.normal(size=(3, group.dimension))


def found(chart, name, xi, *vectors):
    return np.array(chart.apply(name, list(xi), *map(list, vectors)), dtype=float)


@each_chart
@each_group
def test_momenta_of_the_steps_start_are_pulled_back_by_the_opposite_coordinates(name, chart):
    """T(xi)^T Ad*_{Phi(xi)} = T(-xi)^T, which fails for other coordinates."""
    group, random = GROUPS[name], np.random.default_rng(6)
    maps = Chart(group.layout.tolist(), chart.number)
    for _ in range(5):
        xi, _, nu = random_state(group, random)
        carried = found(maps, "momentum", xi, found(maps, "coadjoint", xi, nu))
        np.testing.assert_allclose(found(maps, "momentum", -xi, nu), carried, rtol=0.0, atol=1e-14)
        if name != "SO2 x R2":  # which is commutative
            wrong = found(maps, "momentum", xi, nu)
            assert np.abs(wrong - carried).max() > 1e-3


@each_chart
@each_group
def test_the_tangent_map_its_transpose_and_inverses_belong_together(name, chart):
    group, random = GROUPS[name], np.random.default_rng(5)
    maps = Chart(group.layout.tolist(), chart.number)
    for _ in range(5):
        xi, eta, mu = random_state(group, random)
        v, pi = found(maps, "velocity", xi, eta), found(maps, "momentum", xi, mu)
        assert mu @ v == pytest.approx(pi @ eta, rel=1e-13, abs=1e-14)
        np.testing.assert_allclose(found(maps, "rate", xi, v), eta, rtol=0.0, atol=1e-14)
        np.testing.assert_allclose(found(maps, "covector", xi, pi), mu, rtol=0.0, atol=1e-14)


@each_chart
@each_group
def test_the_slope_of_the_momentum_is_that_of_differences(name, chart):
    group, random = GROUPS[name], np.random.default_rng(6)
    maps, far = Chart(group.layout.tolist(), chart.number), 2.0**-11
    xi, eta, mu = random_state(group, random)

    def value(moved):
        return mu @ found(maps, "velocity", moved, eta)

    units = far * np.eye(group.dimension)
    first = [(value(xi + e) - value(xi - e)) / (2 * far) for e in units]
    second = [(value(xi + 2 * e) - value(xi - 2 * e)) / (4 * far) for e in units]
    expected = (4 * np.array(first) - np.array(second)) / 3
    np.testing.assert_allclose(
        found(maps, "momentum_slope", xi, eta, mu), expected, rtol=0.0, atol=1e-9
    )


def test_rotations_by_exponential_coordinates_are_those_of_mpmath():
    xi, mu = np.array([0.3, -0.5, 0.8]), np.array([0.7, 0.2, -0.4])
    with mp.workdps(40):
        hat = mp.matrix([[0, -xi[2], xi[1]], [xi[2], 0, -xi[0]], [-xi[1], xi[0], 0]])
        exact = mp.expm(hat) * mp.matrix(mu) - mp.matrix(mu)
    maps = Chart([[4, 3, 9, 3]], 1)
    change = found(maps, "coadjoint_change", xi, mu)
    np.testing.assert_allclose(change, np.array(exact.tolist(), dtype=float).ravel(), atol=2e-16)


def test_an_angular_momentum_is_measured_with_what_displacements_make_of_a_momentum(monkeypatch):
    """A body that moves by 0.01 in a step, with a momentum of 0.2, and does not turn."""
    sizes, advance = [], LawKernel.advance

    def seen(kernel, n):
        code = advance(kernel, n)
        first = group_fields(6, 16).first["pi_sizes"]
        sizes.append(OneRun(*kernel._arguments[2]).record[first : first + 6].copy())
        return code

    monkeypatch.setattr(LawKernel, "advance", seen)
    problem = galvi.Problem(SPINNING.system, np.eye(4), [0.0, 0.0, 0.0, 0.1, 0.0, 0.0])
    assert galvi.integrate(problem, galvi.Galerkin(galvi.Polynomials(8), galvi.gauss(8)), 0.1, 1)
    np.testing.assert_allclose(sizes[-1], [500.0] * 3 + [5.0] * 3, rtol=1e-12)


PLAIN = galvi.Product((galvi.Rn(1), galvi.Rn(2)))


@pytest.mark.parametrize(
    "group", [galvi.SO2(), galvi.SE2(), galvi.SO3(), galvi.SE3(), PLAIN], ids=str
)
def test_a_step_reads_and_writes_no_number_beyond_the_state(group, monkeypatch):
    checked, advance = [], LawKernel.advance

    def seen(kernel, n):
        rows, columns = kernel._work.state.shape
        for row, column, _, count in OneRun(*kernel._arguments[2]).seats:
            checked.append(row < rows and column + count <= columns)
        return advance(kernel, n)

    monkeypatch.setattr(LawKernel, "advance", seen)
    q0 = np.eye(group.shape[0]) if len(group.shape) == 2 else np.full(group.shape, 0.3)
    system = galvi.Lagrangian(lambda q, v: 0.5 * (v @ v) - 0.1 * np.sum(q**4), group)
    problem = galvi.Problem(system, q0, 0.1 * np.arange(1.0, group.dimension + 1.0))
    method = galvi.Galerkin(galvi.Polynomials(3), galvi.gauss(3))
    runs = [galvi.integrate(problem, method, 0.05, 8, solver=way) for way in ("auto", "newton")]
    assert runs[0].engine == "lanes" and checked and all(checked)
    np.testing.assert_allclose(runs[0].q, runs[1].q, rtol=0, atol=1e-13)


@pytest.mark.slow(beside="tests/agreement/test_agreement.py::test_every_chart_agrees")
def test_a_wrong_sign_in_a_formula_for_lanes_is_seen(monkeypatch):
    """The kernels keep the sound formula, which they have compiled."""
    method = galvi.Galerkin(galvi.Polynomials(3), galvi.gauss(4))

    def turned_back(chart, xi, mu, out):
        so3.fill(rotations.change(chart, -1.0, xi, mu), out)

    monkeypatch.setattr(so3, "coadjoint_change", turned_back)
    wrong = swelling("SO3", 11, "with a wrong sign in so3.coadjoint_change")
    fast = galvi.integrate(wrong, method, 0.1, 20)
    general = galvi.integrate(wrong, method, 0.1, 20, solver="newton")
    assert np.abs(fast.q - general.q).max() > 1e-6
