"""What is no force, forces that fail or raise, and balances that lack what they need."""

import numpy as np
import pytest

import galvi
from tests.galvi.forced_systems import FOUR, SPRING, START, compiled, lagrangian


@pytest.mark.parametrize(
    ("force", "timed", "error", "words"),
    [
        (3.0, False, TypeError, "force must be a function of (q, v); received 3.0"),
        ("x", True, TypeError, "force must be a function of (q, v, t)"),
        (None, True, ValueError, "timed_force means a force(q, v, t); received no force"),
    ],
)
@pytest.mark.parametrize("kind", ["canonical", "lagrangian", "body"])
def test_what_is_no_force_is_refused_when_the_system_is_made(kind, force, timed, error, words):
    make = {
        "canonical": lambda **more: galvi.Canonical(1.0, SPRING, **more),
        "lagrangian": lambda **more: galvi.Lagrangian(lagrangian, galvi.Rn(2), **more),
        "body": lambda **more: galvi.RigidBody((1, 2, 2), **more),
    }[kind]
    with pytest.raises(error, match=words.replace("(", r"\(").replace(")", r"\)")):
        make(force=force, timed_force=timed)


@pytest.mark.parametrize(
    ("force", "words"),
    [
        (lambda q, v: np.zeros(3), r"force must return an array of shape \(2,\); received"),
        (lambda q, v: v * np.nan, "force must be finite at the start"),
        (lambda q, v: v * 1j, "of real numbers"),
    ],
)  # fmt: skip
def test_a_force_that_returns_what_it_should_not_is_refused_before_the_run(force, words):
    with pytest.raises(ValueError, match=words):
        galvi.integrate(
            galvi.Problem(galvi.Canonical(1.0, SPRING, force=force), *START), FOUR, 0.1, 1
        )


def test_a_force_that_fails_on_the_way_leaves_nan_and_says_so():
    system = galvi.Canonical(1.0, SPRING, force=compiled(failing), timed_force=True)
    run = galvi.integrate(galvi.Problem(system, *START), FOUR, 0.25, 8)
    assert not run.success
    assert run.failed_step == 5
    assert np.all(np.isnan(run.q[5:])) and np.all(np.isfinite(run.q[:5]))
    assert "infinite or NaN" in run.status


def failing(q, v, t):
    return v * (np.nan if t > 1.0 else 0.0)


def test_what_a_force_raises_reaches_the_caller():
    def broken(q, v):
        if q[0] < 0.9:
            raise ArithmeticError("no wind here")
        return 0.0 * v

    with pytest.raises(ArithmeticError, match="no wind here"):
        galvi.integrate(
            galvi.Problem(galvi.Canonical(1.0, SPRING, force=broken), *START), FOUR, 0.1, 9
        )


def test_fixed_point_iteration_is_refused_for_a_force_that_branches():
    system = galvi.Canonical(1.0, SPRING, force=lambda q, v: np.maximum(v, 0.0))
    problem = galvi.Problem(system, *START)
    with pytest.raises(ValueError, match="external force"):
        galvi.integrate(problem, FOUR, 0.1, 1, solver="fixed_point")


@pytest.mark.parametrize(
    ("run", "words"),
    [
        (lambda: galvi.integrate(galvi.problems.free_body_se3(), FOUR, 0.1, 1), "one body"),
        (
            lambda: galvi.integrate(galvi.problems.kepler(0.1), FOUR, 0.1, 4, save_every=2),
            "needs the Galerkin curves",
        ),
        (
            lambda: galvi.integrate(
                galvi.problems.kepler(0.1), FOUR, 0.1, 4, save_every=2, curves=True
            ),
            "every step",
        ),
    ],
)
def test_a_balance_says_what_it_needs(run, words):
    with pytest.raises(ValueError, match=words):
        galvi.momentum_balance(run())
