"""Theory of pairs of a space and a rule: constants in closed form, names, ill-posed pairs."""

import json

import numpy as np
import pytest

import galvi
from galvi.analysis.step_bounds import Z0
from galvi.spaces.fourier import Fourier
from tests.properties.own_spaces import Monomials
from tests.properties.theory_pairs import KEPLER, OSCILLATOR, P, method


def test_z0_is_the_smallest_positive_root_of_1_equals_z_tan_z():
    assert abs(Z0 * np.tan(Z0) - 1.0) < 1e-15
    z = np.linspace(0.0, Z0 - 1e-6, 1000)
    assert np.all(z * np.tan(z) < 1.0)


@pytest.mark.parametrize(
    ("space", "rule", "squared"),
    [
        # u = x + b (t - 1): x is u(1) and b its slope, |u|_X^2 = x^2 + b^2.
        (P(1), galvi.gauss(1), 5 / 4),  # (x - b / 2)^2
        (P(1), galvi.lobatto(2), (3 + np.sqrt(5.0)) / 4),  # ((x - b)^2 + x^2) / 2
        (P(2), galvi.lobatto(2), (3 + np.sqrt(5.0)) / 4),  # the parabola is 0 at both points
    ],
)
def test_the_constant_of_friedrichs_is_that_of_a_computation_by_hand(space, rule, squared):
    theory = galvi.theory(space, rule)
    assert abs(theory.friedrichs - Z0 * np.sqrt(squared)) < 1e-14


@pytest.mark.slow_cases("40")
@pytest.mark.parametrize("degree", [8, 16, 40])
def test_the_constant_of_friedrichs_tends_to_1_with_the_degree(degree):
    """M's inequality is sharp for cos(z0 t / h), which polynomials approach."""
    for rule in (galvi.gauss(degree), galvi.gauss(2 * degree), galvi.lobatto(degree + 1)):
        assert abs(galvi.theory(P(degree), rule).friedrichs - 1.0) < 1e-13


@pytest.mark.parametrize("degree", [2, 3, 8, 32])
def test_norms_of_exact_rules_are_equal_and_those_of_lobatto_are_not(degree):
    for rule in (galvi.gauss(degree), galvi.lobatto(degree + 1)):
        theory = galvi.theory(P(degree), rule)
        for ratio in (theory.smallest_ratio, theory.largest_ratio):
            assert abs(ratio - 1.0) < 1e-13  # 7e-14 at degree 64
    theory = galvi.theory(P(degree), galvi.lobatto(degree))
    assert theory.largest_ratio > 1.1 and theory.well_posed and theory.consistent


def test_the_constants_are_those_of_the_space_and_not_of_its_basis():
    of_monomials, of_polynomials = (
        galvi.theory(space, galvi.lobatto(4)) for space in (Monomials(4), P(4))
    )
    for name in ("friedrichs", "smallest_ratio", "largest_ratio"):
        assert abs(getattr(of_monomials, name) - getattr(of_polynomials, name)) < 1e-10
    assert of_monomials.names == of_polynomials.names and of_monomials.order == of_polynomials.order


def test_constants_that_float64_cannot_tell_are_none():
    theory = galvi.theory(Monomials(10), galvi.gauss(11))
    assert theory.friedrichs is None and theory.unseen is None and theory.largest_ratio is None


@pytest.mark.parametrize(("degree", "points", "unseen"), [(3, 2, 1), (6, 2, 4), (2, 1, 1)])
def test_an_ill_posed_pair_is_described(degree, points, unseen):
    theory = galvi.theory(P(degree), galvi.gauss(points))
    assert not theory.well_posed and not theory.consistent and theory.unseen == unseen
    assert theory.friedrichs is None and theory.symmetric is None
    assert str(theory).splitlines()[1] == "ill-posed: a free particle has no unique motion"


def test_an_inconsistent_pair_is_well_posed_with_its_defect():
    theory = galvi.theory(Fourier(2), galvi.gauss(16))
    assert theory.well_posed and theory.unseen == 0 and not theory.consistent
    assert abs(theory.defect - 1.0) < 1e-12  # beta_p = 0: a free particle never moves
    assert theory.order == 0 and theory.names == ()


def test_components_of_different_degrees_have_the_worst_constants_and_no_tableau():
    theory = galvi.theory(galvi.ComponentPolynomials((4, 1)), galvi.lobatto(4), KEPLER, 0.1)
    parts = [galvi.theory(P(degree), galvi.lobatto(4)) for degree in (4, 1)]
    assert theory.friedrichs == max(part.friedrichs for part in parts)
    assert abs(theory.largest_ratio - parts[0].largest_ratio) < 1e-14
    assert theory.order == min(part.order for part in parts) and theory.names == ()
    assert theory.fixed_point_step is None and theory.converges is None
    assert theory.exists is False and "no bound      fixed-point iteration" in str(theory)


def test_a_lagrangian_on_a_vector_space_keeps_the_symmetry():
    theory = method().theory(galvi.problems.double_pendulum(), 0.1)
    assert theory.symmetric is True
    error = galvi.round_trip_error(galvi.problems.double_pendulum(), method(), 0.1, 20)
    assert error < 1e-12  # 2e-14


@pytest.mark.parametrize(
    ("problem", "rule"),
    [(None, 4), (OSCILLATOR, 3), (galvi.problems.free_rigid_body(), 5)],
    ids=["none", "oscillator", "body"],
)
def test_everything_can_be_stored(problem, rule):
    theory = galvi.theory(P(4), galvi.gauss(rule), problem, None if problem is None else 0.1)
    assert json.loads(json.dumps(theory.to_dict()))["names"] == list(theory.names)
    assert all(line == line.rstrip() and len(line) <= 120 for line in str(theory).splitlines())
