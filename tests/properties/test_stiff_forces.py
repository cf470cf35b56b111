"""Forces that are stiff, rough, or nothing at the start are solved to round-off."""

import numpy as np
import pytest

import galvi
from tests.properties.forced_systems import FOUR, compiled, no_gradient


def falling(c, mass=1.0):
    """Quadratic drag and gravity, in the units of any mass."""
    return galvi.Canonical(
        mass, lambda q: 0.0, compiled(no_gradient),
        force=lambda q, v: mass * (-9.81 - c * np.abs(v) * v),
    )  # fmt: skip


@pytest.mark.parametrize("place", [0.0, 1e3])
@pytest.mark.parametrize("v", [0.0, 1e-12])
@pytest.mark.parametrize(("c", "mass", "off"), [(1.0, 1e-20, 1e-9), (1e3, 1.0, 1e-3), (1e6, 1, 1)])
def test_a_fall_from_rest_is_solved_however_stiff_the_drag(c, mass, off, place, v):
    """v = -u tanh(9.81 t / u) with u^2 = 9.81 / c; q is the integral."""
    problem = galvi.Problem(falling(c, mass), [place], [v])
    run = galvi.integrate(problem, FOUR, 0.1, 10)
    assert run.success, run.status
    u = np.sqrt(9.81 / c)
    fallen = np.logaddexp(9.81 / u, -9.81 / u) / c - np.log(2.0) / c
    assert abs(place - run.q[-1, 0] - fallen) < off * fallen  # 6e-11, 4e-4, 1e-4 of it
    assert run.counts["iterations"] < 200  # 152, of which some in vain before Newton's method


@pytest.mark.parametrize("size", [1.0, 1e-25])
def test_a_lagrangian_at_rest_in_the_origin_is_driven_to_round_off(size):
    """q'' = -q + size cos 2 t from rest in 0: q = size (cos t - cos 2 t) / 3."""
    system = galvi.Lagrangian(
        lambda q, v, t: 0.5 * v @ v - 0.5 * q @ q + size * np.cos(2 * t) * q[0], galvi.Rn(1),
        lambda q, v, t: np.array([v[0], size * np.cos(2 * t) - q[0]]), explicit_time=True,
    )  # fmt: skip
    method = galvi.Galerkin(galvi.Polynomials(8), galvi.gauss(8))
    run = galvi.integrate(galvi.Problem(system, [0.0], [0.0]), method, 1.0, 3)
    exact = size * (np.cos(run.t) - np.cos(2 * run.t)) / 3
    assert np.max(np.abs(run.q[:, 0] - exact)) < 1e-9 * size  # 3e-10


@pytest.mark.slow_cases("1-rule0")
@pytest.mark.parametrize(
    ("degree", "rule"),
    [(1, galvi.radau(1, left=True)), (1, galvi.radau(1)), (2, galvi.lobatto(2))],
)
def test_equations_hold_also_for_functions_that_vanish_at_every_stage(degree, rule):
    """p1 = p0 + h sum b f and the stages' slopes, from the curve: only rates see such functions."""
    system = galvi.Canonical(1.0, lambda q: 0.0, compiled(no_gradient), force=compiled(rough))
    method = galvi.Galerkin(galvi.Polynomials(degree), rule)
    run = galvi.integrate(galvi.Problem(system, [0.0], [1.0]), method, 0.5, 4)
    table, rates = method.table, run.curves.coefficients[:, 0] @ method.table.slope.T / 0.5
    f = rough(0.0, rates)
    assert np.allclose(run.p[1:, 0], run.p[:-1, 0] + 0.5 * f @ table.b, rtol=0, atol=1e-14)
    left = (table.b * rates) @ table.slope + 0.5 * (table.b * f) @ table.psi
    assert np.allclose(
        left, run.p[1:] * table.end, rtol=0, atol=1e-14
    )  # 2e-16; 0.1 where only places are looked at


def rough(q, v):
    return -2.0 * np.abs(v) * v
