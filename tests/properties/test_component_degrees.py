"""A degree for each component: equal ones change nothing, and unequal ones may cost less."""

import numpy as np
import pytest

import galvi

HENON = galvi.problems.henon_heiles()


def mixed(*degrees, points=None):
    return galvi.Galerkin(galvi.ComponentPolynomials(degrees), galvi.gauss(points or max(degrees)))


@pytest.mark.parametrize(
    ("problem", "unequal_degrees"),
    [(HENON, (1, 4)), (galvi.problems.free_rigid_body(), (4, 2, 4))],
    ids=["vector space", "group"],
)
def test_equal_degrees_are_the_plain_method_and_unequal_ones_another(problem, unequal_degrees):
    plain = galvi.Galerkin(galvi.Polynomials(4), galvi.gauss(4))
    full, equal, unequal = (
        galvi.integrate(problem, method, 0.2, 10)
        for method in (plain, mixed(*[4] * len(unequal_degrees)), mixed(*unequal_degrees))
    )
    for left, right in ((full.q, equal.q), (full.p, equal.p), (full(1.3), equal(1.3))):
        assert np.max(np.abs(left - right)) < 1e-13  # 1e-15
    assert np.max(np.abs(full.q - unequal.q)) > 1e-6  # 3e-4
    assert unequal.method.space.degree == min(unequal_degrees)


@pytest.mark.parametrize("degrees", [(5, 2), (2, 5), (4, 3)])
def test_unequal_degrees_stay_symplectic(degrees):
    assert galvi.symplecticity_defect(HENON, mixed(*degrees), 0.3) < 1e-12  # 1e-14


def test_rotational_momentum_drifts_when_components_of_a_body_differ_and_the_balance_says_so():
    kepler = galvi.problems.kepler(0.3)
    equal_run, unequal_run = (
        galvi.integrate(kepler, mixed(*degrees, points=6), 0.5, 40) for degrees in ((6, 6), (6, 4))
    )
    assert np.ptp(galvi.momentum_map(equal_run)) < 1e-13  # 2e-15
    drift = np.ptp(galvi.momentum_map(unequal_run))
    assert 1e-9 < drift < 1e-6  # 6e-8
    balance = galvi.momentum_balance(unequal_run)
    assert np.ptp(balance.defect) == pytest.approx(drift, rel=1e-6)


def fast_and_slow():
    """Two oscillators of frequencies 12 and 1, weakly coupled."""

    def potential(q):
        return 72.0 * q[0] ** 2 + 0.5 * q[1] ** 2 + 0.1 * q[0] * q[1] ** 2

    return galvi.Problem(galvi.Canonical(1.0, potential), [0.1, 1.0], [0.0, 0.0])


def test_slow_components_need_fewer_functions_for_the_same_accuracy():
    problem = fast_and_slow()
    reference = galvi.integrate(
        problem, galvi.Galerkin(galvi.Polynomials(16), galvi.gauss(16)), 0.2, 10
    )
    rich, poor, mix = (
        galvi.integrate(problem, mixed(*degrees, points=10), 0.4, 5)
        for degrees in ((10, 10), (6, 6), (10, 6))
    )
    errors = [np.max(np.abs(run.q[-1] - reference.q[-1])) for run in (rich, poor, mix)]
    assert errors[2] < 20.0 * errors[0]  # 3e-11 and 7e-12
    assert errors[1] > 1000.0 * errors[2]
