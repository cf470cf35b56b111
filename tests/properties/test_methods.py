"""Methods: their tables, identities, names, orders, and the pairs that are refused."""

import time

import mpmath
import numpy as np
import pytest

import galvi
from galvi.tableau import assemble, tabulate
from tests.properties.own_spaces import Monomials

PAIRS = [
    (degree, rule(points))
    for rule in (galvi.gauss, galvi.lobatto, galvi.clenshaw_curtis)
    for degree, points in [(1, 2), (2, 3), (3, 4), (3, 5), (6, 8), (8, 16), (24, 50)]
]


@pytest.mark.parametrize(("degree", "rule"), PAIRS)
def test_every_table_is_consistent_symplectic_and_symmetric(degree, rule):
    method = galvi.Galerkin(galvi.Polynomials(degree), rule)
    table = method.table
    assert np.allclose(table.psi @ table.velocity_coefficients, table.c, atol=1e-15)
    assert abs(table.end @ table.velocity_coefficients - 1.0) < 1e-15
    # b_i (beta_j - A_ij) = b_j (beta_i - A_ji): the condition of a symplectic Nystrom method.
    left = table.b[:, None] * (table.beta - table.A)
    assert np.allclose(left, left.T, atol=1e-17)
    assert method.symmetric


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


@pytest.mark.parametrize(
    ("degree", "rule", "name"),
    [
        (1, galvi.gauss(1), "implicit midpoint"),
        (2, galvi.lobatto(2), "Stormer-Verlet"),
        (5, galvi.gauss(5), "Gauss collocation, 5 stages"),
        (4, galvi.lobatto(4), "Lobatto IIIA-IIIB, 4 stages"),
        (3, galvi.lobatto(4), "Galerkin degree 3, Lobatto 4"),
        (3, galvi.gauss(6), "Galerkin degree 3, Gauss 6"),
        (4, galvi.clenshaw_curtis(6), "Galerkin degree 4, Clenshaw-Curtis 6"),
    ],
)
def test_known_methods_are_recognised_by_their_numbers(degree, rule, name):
    assert galvi.Galerkin(galvi.Polynomials(degree), rule).name == name


@pytest.mark.parametrize(
    ("degree", "rule", "order"),
    [
        (3, galvi.gauss(3), 6),
        (3, galvi.gauss(6), 6),
        (3, galvi.lobatto(4), 6),
        (3, galvi.lobatto(3), 4),
        (4, galvi.clenshaw_curtis(5), 6),
        (4, galvi.clenshaw_curtis(4), 2),
        (6, galvi.clenshaw_curtis(7), 6),
    ],
)
def test_the_order_is_that_of_the_space_or_of_the_rule_whichever_is_less(degree, rule, order):
    assert galvi.Galerkin(galvi.Polynomials(degree), rule).order == order


def test_a_users_space_of_the_same_functions_makes_the_same_method():
    mine = galvi.Galerkin(Monomials(4), galvi.gauss(4))
    ours = galvi.Galerkin(galvi.Polynomials(4), galvi.gauss(4))
    assert np.allclose(mine.table.A, ours.table.A, atol=1e-14)
    problem = galvi.problems.kepler(0.3)
    runs = [galvi.integrate(problem, method, 0.2, 20) for method in (mine, ours)]
    assert np.allclose(runs[0].q, runs[1].q, atol=1e-12)
    assert np.allclose(runs[0](0.31), runs[1](0.31), atol=1e-12)


def test_a_method_a_rule_and_a_problem_are_shown_in_one_short_line():
    method = galvi.Galerkin(galvi.Polynomials(8), galvi.gauss(50))
    assert repr(method) == "Galerkin(Polynomials(degree=8), Rule('Gauss 50'))"
    on_groups = galvi.Galerkin(galvi.Polynomials(8), galvi.gauss(8), galvi.Exponential())
    assert repr(on_groups) == "Galerkin(Polynomials(degree=8), Rule('Gauss 8'), Exponential())"
    assert repr(galvi.problems.kepler(0.6)) == "Problem('kepler e=0.6', q0 of shape (2,))"


def test_methods_are_values():
    one, two = (galvi.Galerkin(galvi.Polynomials(3), galvi.gauss(4)) for _ in range(2))
    assert one == two
    assert hash(one) == hash(two)
    assert one.table is two.table


def test_a_table_of_degree_64_takes_well_under_a_second_of_processor_time():
    assemble.cache_clear()
    galvi.gauss(64)
    best = min(timed_table(points) for points in (64, 65, 66))
    assert best < 1.0, f"{best:.2f} s; 0.17 s when this was written"


def timed_table(points):
    start = time.process_time()
    tabulate(galvi.Polynomials(64), galvi.gauss(points))
    return time.process_time() - start
