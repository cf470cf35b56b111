"""Trajectories: curves, export to data frames, invariants, symplecticity and reversibility."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

import galvi

KEPLER = galvi.problems.kepler(0.6)
SOLAR_SYSTEM = galvi.problems.solar_system()
EIGHT = galvi.Galerkin(galvi.Polynomials(8), galvi.gauss(8))


@pytest.fixture(scope="module")
def orbit():
    return galvi.integrate(KEPLER, EIGHT, 0.3, 40)


def test_the_curve_passes_through_the_steps(orbit):
    assert np.allclose(orbit(orbit.t), orbit.q, rtol=0.0, atol=4e-15)
    assert orbit(0.7).shape == (2,)
    assert orbit([0.7, 0.8]).shape == (2, 2)
    assert orbit.velocity(np.array([0.7])).shape == (1, 2)
    run = galvi.integrate(SOLAR_SYSTEM, EIGHT, 10.0, 3)
    assert run([1.0, 2.0]).shape == (2, 10, 3)
    assert run.velocity(1.0).shape == (10, 3)


@given(t=st.floats(0.01, 11.99))
def test_the_velocity_is_the_slope_of_the_position(orbit, t):
    increment = 1e-5
    assume(abs((t / 0.3) % 1.0 - 0.5) < 0.49)  # away from the ends of steps, where it jumps
    slope = (orbit(t + increment) - orbit(t - increment)) / (2 * increment)
    assert np.allclose(slope, orbit.velocity(t), rtol=1e-6, atol=1e-6)


def test_invalid_times_are_refused(orbit):
    for t in (float("nan"), "1", [0.1, float("inf")]):
        with pytest.raises(ValueError, match=r"t must (hold finite|be an array of real) numbers"):
            orbit(t)
    for t in (-0.1, 12.1, 1e308):
        with pytest.raises(
            ValueError, match=r"t must lie inside the run, from 0\.0 to 12\.0; received"
        ):
            orbit(t)
    with pytest.raises(ValueError, match=r"scalar or of shape \(k,\)"):
        orbit(np.zeros((2, 2)))


def test_a_backward_run_is_evaluated_at_negative_times():
    back = galvi.integrate(KEPLER, EIGHT, -0.3, 4)
    assert np.allclose(back(-1.2), back.q[-1])


def test_a_data_frame_has_one_column_for_each_component(orbit):
    table = orbit.to_frame()
    assert list(table.columns) == ["t", "q[0]", "q[1]", "p[0]", "p[1]"]
    assert np.array_equal(table["p[1]"], orbit.p[:, 1])
    assert list(galvi.integrate(SOLAR_SYSTEM, EIGHT, 10.0, 1).to_frame().columns[:4]) == [
        "t",
        "q[0,0]",
        "q[0,1]",
        "q[0,2]",
    ]


def test_energy_and_momenta_are_those_of_the_definition(orbit):
    q, p = orbit.q, orbit.p
    by_hand = 0.5 * np.sum(p**2, axis=1) - 1 / np.hypot(q[:, 0], q[:, 1])
    assert np.allclose(galvi.energy(orbit), by_hand, rtol=0.0, atol=1e-14)
    assert np.allclose(galvi.momentum_map(orbit), q[:, 0] * p[:, 1] - q[:, 1] * p[:, 0])
    t = [0.1, 5.0]
    v = orbit.velocity(t)
    assert np.allclose(
        galvi.energy(orbit, t), 0.5 * np.sum(v**2, 1) - 1 / np.linalg.norm(orbit(t), axis=1)
    )
    assert galvi.energy(orbit, 0.1).shape == ()
    assert galvi.momentum_map(orbit, 0.1).shape == ()


DEGREES_AND_RULES = [
    (1, galvi.gauss(1)),
    (1, galvi.lobatto(2)),
    (3, galvi.gauss(3)),
    (3, galvi.lobatto(4)),
    (4, galvi.clenshaw_curtis(7)),
    (5, galvi.gauss(10)),
]
NONLINEAR = [
    galvi.problems.kepler(0.3),
    galvi.problems.henon_heiles(),
    galvi.problems.fermi_pasta_ulam_tsingou(4, beta=0.5),
    galvi.Problem(
        galvi.Canonical([[2.0, 0.5], [0.5, 1.0]], galvi.CentralForce(1.0)), [1.0, 0.0], [0.0, 1.0]
    ),
]


@pytest.mark.parametrize(
    ("problem", "degree", "rule"),
    [(NONLINEAR[k % 4], *row) for k, row in enumerate(DEGREES_AND_RULES)],  # one problem for each
)
def test_methods_are_symplectic_to_round_off(problem, degree, rule):
    method = galvi.Galerkin(galvi.Polynomials(degree), rule)
    assert galvi.symplecticity_defect(problem, method, 0.2) < 2e-15


def test_the_derivative_of_a_step_is_that_of_differences():
    """The mass is 1, so that p = v."""
    problem, h, increment = NONLINEAR[0], 0.4, 1e-5
    derivative = galvi.step_derivative(problem, EIGHT, h)
    columns = []
    for unit in np.eye(4):
        ends = []
        for sign in (1, -1):
            shift = sign * increment * unit
            shifted = problem.with_initial_state(problem.q0 + shift[:2], problem.v0 + shift[2:])
            run = galvi.integrate(shifted, EIGHT, h, 1)
            ends.append(np.concatenate([run.q[-1], run.p[-1]]))
        columns.append((ends[0] - ends[1]) / (2 * increment))
    assert np.allclose(derivative, np.array(columns).T, atol=1e-8)


def test_a_changed_coefficient_is_caught_by_symplecticity_and_round_trip():
    method = galvi.Galerkin(galvi.Polynomials(3), galvi.gauss(3))
    A = method.table.A.copy()
    A[0, 2] *= 1.0 + 1e-6
    faulty = galvi.Galerkin(galvi.Polynomials(3), galvi.gauss(3))
    faulty.__dict__["table"] = replace(method.table, A=A)  # in place of the cached property
    problem = galvi.problems.henon_heiles()
    assert galvi.symplecticity_defect(problem, method, 0.3) < 2e-15
    assert galvi.symplecticity_defect(problem, faulty, 0.3) > 1e-12
    assert galvi.round_trip_error(problem, method, 0.3, 100) < 1e-12
    assert galvi.round_trip_error(problem, faulty, 0.3, 100) > 1e-11
