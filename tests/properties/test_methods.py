"""Methods: identities and accuracy of their tables, and how they are shown and compared."""

import mpmath
import numpy as np
import pytest

import galvi
from galvi.rules import RULES
from galvi.spaces import SPACES

POINTS = {galvi.radau: 13, galvi.newton_cotes: 8}
TESTED_SPACES = [space for make in SPACES for n in (1, 3, 9) if (space := make(n)).degree > 0]


def on_pieces(space):
    """A rule that is exact for the kinetic energy of a space."""
    pieces = getattr(space, "pieces", 1)
    return galvi.composite(galvi.gauss(max(4, space.degree) if pieces > 1 else 17), pieces)


@pytest.mark.parametrize(
    ("space", "rule"),
    [(space, on_pieces(space)) for space in TESTED_SPACES]
    + [(galvi.Polynomials(4), rule(POINTS.get(rule, 5))) for rule in RULES]
    + [(galvi.Polynomials(24), galvi.lobatto(50)), (galvi.Polynomials(1), galvi.lobatto(2))],
)
def test_every_table_is_consistent_symplectic_symmetric_and_well_conditioned(space, rule):
    method = galvi.Galerkin(space, rule)
    table = method.table
    stages = table.psi @ table.velocity_coefficients
    assert np.allclose(stages, table.c, rtol=0, atol=1e-15)  # 3e-16
    assert abs(table.end @ table.velocity_coefficients - 1.0) < 1e-15
    # b_i (beta_j - A_ij) = b_j (beta_i - A_ji): the condition of a symplectic Nystrom method.
    symplectic_products = table.b[:, None] * (table.beta - table.A)
    assert np.allclose(symplectic_products, symplectic_products.T, rtol=0, atol=1e-17)
    assert np.linalg.cond(table.K) < max(30.0, 2.0 * space.degree)  # 26.9: PiecewiseHermite(1)
    assert method.symmetric is rule.symmetric


def test_the_table_is_correct_to_the_last_bit():
    """Gauss collocation in 60 digits, by another formula: A = B^2, B the collocation matrix."""
    s = 8
    rule = galvi.gauss(s)
    with mpmath.workdps(60):
        c = [mpmath.mpf(str(x)) for x in rule.exact_nodes]
        powers = mpmath.matrix(s, s)
        integrals = mpmath.matrix(s, s)
        for k in range(s):
            for j in range(s):
                powers[k, j] = c[k] ** j
                integrals[k, j] = c[k] ** (j + 1) / (j + 1)
        B = integrals * powers**-1
        expected = np.array((B * B).tolist(), dtype=float)
    assert np.array_equal(galvi.Galerkin(galvi.Polynomials(s), rule).table.A, expected)


def test_a_method_a_rule_and_a_problem_are_shown_in_one_short_line():
    method = galvi.Galerkin(galvi.Polynomials(8), galvi.gauss(8), galvi.Exponential())
    assert repr(method) == "Galerkin(Polynomials(degree=8), Rule('Gauss 8'), Exponential())"
    assert repr(galvi.problems.kepler(0.6)) == "Problem('kepler e=0.6', q0 of shape (2,))"


def test_methods_are_values():
    first, second = (galvi.Galerkin(galvi.Polynomials(3), galvi.gauss(4)) for _ in range(2))
    assert first == second and hash(first) == hash(second) and first.table is second.table
