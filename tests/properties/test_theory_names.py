"""Classical names, each against a tableau built from the literature's coefficients."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.optimize import brentq

import galvi
from galvi.properties.properties import classical_names

OSCILLATOR = galvi.problems.harmonic_oscillator()
R6, R15 = np.sqrt(6.0), np.sqrt(15.0)
# (a of positions, a^ of velocities, b), from Hairer, Lubich, Wanner, Geometric Numerical
# Integration, tables II.1.1 and II.1.2 and section II.2.1, and Hairer and Wanner, Solving ODEs II,
# tables IV.5.1 to IV.5.11 (Gauss, Radau IA and IIA, Lobatto IIIA and IIIB); Radau I and II are
# Butcher's of 1964.
GAUSS_3 = [
    [5 / 36, 2 / 9 - R15 / 15, 5 / 36 - R15 / 30],
    [5 / 36 + R15 / 24, 2 / 9, 5 / 36 - R15 / 24],
    [5 / 36 + R15 / 30, 2 / 9 + R15 / 15, 5 / 36],
]
IIIA_3 = [[0, 0, 0], [5 / 24, 1 / 3, -1 / 24], [1 / 6, 2 / 3, 1 / 6]]
IIIB_3 = [[1 / 6, -1 / 6, 0], [1 / 6, 1 / 3, 0], [1 / 6, 5 / 6, 0]]
IA_3 = [
    [1 / 9, (-1 - R6) / 18, (-1 + R6) / 18],
    [1 / 9, (88 + 7 * R6) / 360, (88 - 43 * R6) / 360],
    [1 / 9, (88 + 43 * R6) / 360, (88 - 7 * R6) / 360],
]
IIA_3 = [
    [(88 - 7 * R6) / 360, (296 - 169 * R6) / 1800, (-2 + 3 * R6) / 225],
    [(296 + 169 * R6) / 1800, (88 + 7 * R6) / 360, (-2 - 3 * R6) / 225],
    [(16 - R6) / 36, (16 + R6) / 36, 1 / 9],
]
B3 = [(16 - R6) / 36, (16 + R6) / 36, 1 / 9]


def symplectic_partner(a, b):
    """a^_kj = b_j (1 - a_jk / b_k), or a from a^: the relation is its own inverse."""
    a, b = np.array(a), np.array(b)
    return b * (1 - a.T / b[:, None])


P = galvi.Polynomials
PAIRS = [
    ("implicit midpoint", P(1), galvi.gauss(1), [[1 / 2]], [[1 / 2]], [1]),
    ("Gauss collocation, 3 stages", P(3), galvi.gauss(3), GAUSS_3, GAUSS_3,
     [5 / 18, 4 / 9, 5 / 18]),
    ("Stormer-Verlet", P(1), galvi.lobatto(2), [[0, 0], [1 / 2, 1 / 2]], [[1 / 2, 0]] * 2,
     [1 / 2, 1 / 2]),
    ("Stormer-Verlet", P(2), galvi.lobatto(2), [[0, 0], [1 / 2, 1 / 2]], [[1 / 2, 0]] * 2,
     [1 / 2, 1 / 2]),
    ("Lobatto IIIA-IIIB, 3 stages", P(2), galvi.lobatto(3), IIIA_3, IIIB_3, [1 / 6, 2 / 3, 1 / 6]),
    ("Lobatto IIIA-IIIB, 3 stages", P(3), galvi.lobatto(3), IIIA_3, IIIB_3, [1 / 6, 2 / 3, 1 / 6]),
    ("symplectic Euler, position first", P(1), galvi.radau(1), [[1]], [[0]], [1]),
    ("symplectic Euler, velocity first", P(1), galvi.radau(1, left=True), [[0]], [[1]], [1]),
    ("Radau IIA-II, 3 stages", P(3), galvi.radau(3), IIA_3, symplectic_partner(IIA_3, B3), B3),
    ("Radau I-IA, 3 stages", P(3), galvi.radau(3, left=True),
     symplectic_partner(IA_3, B3[::-1]), IA_3, B3[::-1]),
]  # fmt: skip


@pytest.mark.parametrize(("name", "space", "rule", "a", "partner", "b"), PAIRS)
def test_a_name_stands_for_the_tableau_of_the_literature(name, space, rule, a, partner, b):
    method = galvi.Galerkin(space, rule)
    a, partner, b = np.array(a), np.array(partner), np.array(b)
    c = a.sum(axis=1)
    assert np.allclose(method.table.c, c, atol=1e-15)
    assert np.allclose(method.table.b, b, atol=1e-15)
    assert np.allclose(method.table.A, a @ partner, atol=1e-15)
    assert np.allclose(method.table.beta, b @ partner, atol=1e-15)
    assert galvi.theory(method, problem=OSCILLATOR).names[0] == name
    minimal = method.table.slope.shape[0] == space.degree
    assert (method.name == name) is minimal and (method.theory().name == name) is minimal


@pytest.mark.parametrize("space", [P(1), P(2)])
def test_the_trapezoid_has_every_name_of_verlets_method(space):
    names = galvi.theory(space, galvi.lobatto(2), OSCILLATOR).names
    assert names == (
        "Stormer-Verlet",
        "velocity Verlet",
        "leapfrog",
        "Newmark, beta = 0, gamma = 1/2",
        "Lobatto IIIA-IIIB, 2 stages",
    )


def newmark(beta, gamma, q, v, h):
    """One step for the force -q^3, stiff enough to tell beta (Newmark 1959)."""
    next_q = q
    for _ in range(200):
        next_q = q + h * v - h * h * ((0.5 - beta) * q**3 + beta * next_q**3)
    return next_q, v - h * ((1 - gamma) * q**3 + gamma * next_q**3)


def test_the_trapezoid_is_newmarks_method_with_beta_0_and_not_with_a_quarter():
    quartic = galvi.Canonical(1.0, lambda q: 0.25 * q[0] ** 4, lambda q: q**3)
    run = galvi.integrate(
        galvi.Problem(quartic, [1.0], [0.3]), galvi.Galerkin(P(1), galvi.lobatto(2)), 0.2, 1
    )
    state = np.array([run.q[-1, 0], run.p[-1, 0]])
    assert np.allclose(state, newmark(0.0, 0.5, 1.0, 0.3, 0.2), atol=1e-15)
    assert np.max(np.abs(state - newmark(0.25, 0.5, 1.0, 0.3, 0.2))) > 1e-4


@pytest.mark.parametrize(("degree", "steps"), [(1, 7), (2, 3), (3, 2)])
def test_pieces_with_a_rule_on_each_are_that_many_steps(degree, steps):
    space, rule = P(degree), galvi.gauss(degree)
    pieces = galvi.PiecewisePolynomials(degree, steps), galvi.composite(rule, steps)
    in_pieces, in_steps = (
        galvi.integrate(galvi.problems.henon_heiles(), galvi.Galerkin(*pair), 0.3 / n, n)
        for pair, n in ((pieces, 1), ((space, rule), steps))
    )
    assert in_pieces.method.name == f"{steps} steps of {in_steps.method.name}"
    assert np.allclose(in_pieces.q[-1], in_steps.q[-1], atol=1e-14)
    assert np.allclose(in_pieces.p[-1], in_steps.p[-1], atol=1e-14)


@pytest.mark.parametrize(
    ("space", "rule", "name"),
    [
        (P(2), galvi.gauss(3), "Galerkin degree 2, Gauss 3"),
        (P(64), galvi.gauss(65), "Galerkin degree 64, Gauss 65"),
        (P(1), galvi.radau(2), "Galerkin degree 1, Radau 2"),
        (P(4), galvi.clenshaw_curtis(4), "Galerkin degree 4, Clenshaw-Curtis 4"),
        (
            galvi.PiecewisePolynomials(1, 2),
            galvi.composite(galvi.gauss(2), 2),
            "Galerkin PiecewisePolynomials(degree=1, pieces=2), Gauss 2 on 2 pieces",
        ),
    ],
)
def test_other_tableaux_have_no_classical_name(space, rule, name):
    assert galvi.theory(space, rule).names == ()
    assert galvi.Galerkin(space, rule).name == name


def test_names_reach_the_highest_degree():
    for rule, name in ((galvi.gauss, "Gauss collocation"), (galvi.lobatto, "Lobatto IIIA-IIIB")):
        assert galvi.theory(P(64), rule(64)).name == f"{name}, 64 stages"
    assert galvi.theory(P(64), galvi.lobatto(65)).name == ""  # not for every Lagrangian


def test_a_tableau_that_is_slightly_wrong_has_no_name():
    for space, rule in ((P(3), galvi.gauss(3)), (P(3), galvi.radau(3)), (P(2), galvi.lobatto(3))):
        table = galvi.Galerkin(space, rule).table
        assert classical_names(table, True)
        assert classical_names(replace(table, A=table.A * (1 + 1e-9)), True) == ()
        assert classical_names(replace(table, b=table.b * (1 + 1e-9)), True) == ()


STRETCHED = galvi.Problem(  # L = (1 + q^2) v^2 / 2 - q^2 / 2, of a mass that depends on q
    galvi.Lagrangian(lambda q, v: (1 + q[0] ** 2) * v[0] ** 2 / 2 - q[0] ** 2 / 2, galvi.Rn(1)),
    [1.0],
    [1.0],
)


def verlet_of_a_stretched_mass(q, p, h):
    """Hairer, Lubich, Wanner, VI.3 (3.5), for H = p^2 / (2 (1 + q^2)) + q^2 / 2."""

    def momentum_equation(x):
        return x - p - 0.5 * h * (x**2 * q / (1 + q**2) ** 2 - q)

    def position_equation(x):
        return x - q - 0.5 * h * half_momentum * (1 / (1 + q**2) + 1 / (1 + x**2))

    half_momentum = brentq(momentum_equation, -10.0, 10.0, xtol=1e-15)
    next_q = brentq(position_equation, -10.0, 10.0, xtol=1e-15)
    return next_q, half_momentum + 0.5 * h * (
        half_momentum**2 * next_q / (1 + next_q**2) ** 2 - next_q
    )


@pytest.mark.parametrize(
    ("degree", "name"), [(1, "Galerkin degree 1, Lobatto 2"), (2, "Stormer-Verlet")]
)
def test_a_method_has_the_name_of_what_it_does_to_every_lagrangian(degree, name):
    """Both are Verlet's method for a constant mass, and only one of them for any."""
    method = galvi.Galerkin(P(degree), galvi.lobatto(2))
    run = galvi.integrate(STRETCHED, method, 0.1, 1)
    position, momentum = verlet_of_a_stretched_mass(1.0, 2.0, 0.1)
    is_verlet = bool(max(abs(run.q[-1, 0] - position), abs(run.p[-1, 0] - momentum)) < 1e-13)
    assert is_verlet is (degree == 2)
    assert method.name == name and bool(galvi.theory(method, problem=STRETCHED).name) is is_verlet
    assert galvi.theory(method, problem=OSCILLATOR).name == "Stormer-Verlet"
