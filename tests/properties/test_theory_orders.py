"""Predicted orders at step ends and along the curve, pinned from both sides on Kepler's problem."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import galvi
from galvi.properties.properties import exactness
from galvi.rules.rule import composite, newton_cotes, radau
from galvi.spaces.fourier import PolynomialFourier
from galvi.spaces.piecewise import PiecewiseHermite, PiecewisePolynomials

P = galvi.Polynomials
SPACE, FORCE, KINETIC = "space", "rule for the force", "rule for the kinetic energy"
PROBLEM = galvi.problems.kepler(0.3)
LENGTH = 4.0
TIMES = np.linspace(0.0, LENGTH, 301)


@pytest.fixture(scope="module")
def truth():
    """Positions and velocities at TIMES, (4, 301)."""

    def right(t, y):
        return np.concatenate([y[2:], -y[:2] / np.hypot(y[0], y[1]) ** 3])

    start = np.concatenate([PROBLEM.q0, PROBLEM.v0])
    return solve_ivp(
        right, (0, LENGTH), start, method="DOP853", rtol=3e-14, atol=1e-15, t_eval=TIMES
    ).y


# pair, fewest and most steps, orders at step ends and on the curve, what limits the first
CASES = [
    (P(1), radau(1), (400, 1200), 1, 1, FORCE),
    (P(1), radau(2), (96, 256), 2, 2, SPACE),
    (P(2), radau(2, left=True), (48, 160), 3, 3, FORCE),
    (P(3), radau(3), (32, 96), 5, 4, FORCE),
    (P(3), radau(4), (20, 64), 6, 4, SPACE),
    (P(2), galvi.lobatto(2), (96, 256), 2, 2, FORCE),
    (P(3), galvi.lobatto(3), (40, 128), 4, 3, FORCE),
    (P(3), newton_cotes(4), (40, 128), 4, 3, FORCE),
    (P(4), newton_cotes(4), (96, 256), 2, 2, KINETIC),
    (P(4), galvi.clenshaw_curtis(5), (20, 80), 6, 4, FORCE),
    (P(4), galvi.gauss(5), (12, 32), 8, 5, SPACE),
    (PiecewisePolynomials(2, 2), composite(galvi.gauss(2), 2), (32, 128), 4, 3, SPACE),
    (PiecewisePolynomials(1, 2), galvi.gauss(2), (64, 256), 2, 2, FORCE),
    (PiecewiseHermite(2), composite(galvi.gauss(3), 2), (12, 40), 6, 4, SPACE),
    (PiecewiseHermite(2), composite(galvi.lobatto(3), 2), (20, 64), 4, 3, FORCE),
    (galvi.ComponentPolynomials((4, 2)), galvi.gauss(4), (24, 96), 4, 3, SPACE),
    (galvi.ComponentPolynomials((3, 4)), galvi.clenshaw_curtis(4), (96, 256), 2, 2, KINETIC),
    (PolynomialFourier(1, 1), galvi.gauss(12), (64, 256), 2, 2, SPACE),
    (PolynomialFourier(2, 1), galvi.gauss(12), (24, 96), 4, 3, SPACE),
]


def slopes(space, rule, span, truth):
    """Least-squares slopes of the errors at the end and along the curve over the step."""
    method = galvi.Galerkin(space, rule)
    counts = np.unique(np.geomspace(*span, 5).round().astype(int))
    errors = []
    for steps in counts:
        run = galvi.integrate(PROBLEM, method, LENGTH / steps, int(steps))
        assert run.success, run.status
        at_end = np.concatenate([run.q[-1], run.p[-1]]) - truth[:, -1]
        errors.append([np.max(np.abs(at_end)), np.max(np.abs(run(TIMES).T - truth[:2]))])
    return np.polyfit(np.log(LENGTH / counts), np.log(errors), 1)[0]


@pytest.mark.parametrize(
    ("space", "rule", "span", "at_steps", "on_curve", "limit"),
    CASES,
    ids=[f"{case[0]}, {case[1].name}" for case in CASES],
)
def test_the_orders_are_as_stated_no_less_and_no_more(
    space, rule, span, at_steps, on_curve, limit, truth
):
    said = galvi.theory(space, rule)
    assert (said.order, said.curve_order, said.limited_by) == (at_steps, on_curve, limit)
    measured = slopes(space, rule, span, truth)
    assert np.max(np.abs(measured - [at_steps, on_curve])) < 0.4, measured


def test_an_order_that_is_one_too_high_would_be_seen(truth):
    measured = slopes(P(3), galvi.lobatto(3), (40, 128), truth)
    assert measured[0] < 6 - 0.4 and measured[1] < 4 - 0.4


@pytest.mark.parametrize(
    ("space", "rule"),
    [(P(3), galvi.gauss(2)), (PiecewisePolynomials(1, 2), galvi.gauss(5))],
)
def test_a_refused_pair_has_order_0(space, rule):
    said = galvi.theory(space, rule)
    assert (said.order, said.curve_order, said.limited_by) == (0, 0, "")


@pytest.mark.parametrize("rule", [galvi.gauss(2), galvi.lobatto(3), radau(3), galvi.lobatto(2)])
@pytest.mark.parametrize("pieces", [1, 2, 5])
def test_a_repeated_rule_is_as_exact_on_each_piece_as_the_rule(rule, pieces):
    assert exactness(PiecewiseHermite(pieces), composite(rule, pieces)) == rule.degree


def test_a_rule_that_ignores_the_joints_is_less_exact_than_it_says():
    assert exactness(PiecewisePolynomials(1, 2), galvi.gauss(2)) == 0
    assert exactness(PiecewisePolynomials(1, 2), galvi.gauss(3)) == 0
    assert exactness(PiecewisePolynomials(1, 3), galvi.gauss(4)) == -1
