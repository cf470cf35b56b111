"""Mollified impulse and the exponential integrator: exact on springs, of order 2, symplectic."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import galvi
from benchmarks.measures.symplectic_form import canonical_defect
from benchmarks.test_problems.stiff_springs import stiff_springs, stiffness
from references.scipy.ivp import DOP853
from references.textbook.euler import STORMER_VERLET
from references.textbook.trigonometric import (
    Trigonometric,
    exponential_integrator,
    mollified_impulse,
)

MAKERS = (mollified_impulse, exponential_integrator)
each = pytest.mark.parametrize("maker", MAKERS, ids=lambda maker: maker.__name__)


@each
def test_springs_alone_are_exact_at_any_step(maker: Any) -> None:
    spring = galvi.Problem(galvi.Canonical(1.0, galvi.LinearSpring(400.0)), [1.0], [0.0])
    run = maker(np.array([[400.0]])).run(spring, 50.0, {"step": 1.0})
    assert np.max(np.abs(run.q[:, 0] - np.cos(20.0 * run.t))) < 1e-12


@each
def test_the_order_is_two_beyond_the_fast_period(maker: Any) -> None:
    omega = 200.0
    problem = stiff_springs(omega)
    truth = DOP853.run(problem, 1.0, {"samples": 1, "tolerance": 1e-9}).q[-1]
    steps = np.array([20, 28, 40])  # h omega = 10, 7, 5
    errors = [
        np.max(np.abs(maker(stiffness(omega)).run(problem, 1.0, {"step": 1.0 / n}).q[-1] - truth))
        for n in steps
    ]
    assert abs(np.polyfit(np.log(1.0 / steps), np.log(errors), 1)[0] - 2.0) < 0.4


def test_without_springs_it_is_stormer_and_verlet() -> None:
    problem = stiff_springs(3.0)
    ours = mollified_impulse(np.zeros((6, 6))).run(problem, 1.0, {"step": 0.05})
    theirs = STORMER_VERLET.run(problem, 1.0, {"step": 0.05})
    assert np.allclose(ours.q, theirs.q, rtol=0.0, atol=1e-13)


def derivative(method: Trigonometric) -> Any:
    """D of a step of h omega = 4, by central differences of order four."""
    problem, nudge = stiff_springs(50.0), 1e-3
    start = np.concatenate([problem.q0, problem.v0])

    def end(x: Any) -> Any:
        begin = problem.with_initial_state(x[:6], x[6:])
        run = method.run(begin, 0.08, {"step": 0.08})
        return np.concatenate([run.q[-1], run.p[-1]])

    columns = []
    for unit in np.eye(12) * nudge * np.array([1.0] * 3 + [0.02] * 3 + [1.0] * 6):
        near, far = (end(start + k * unit) - end(start - k * unit) for k in (1, 2))
        columns.append((8.0 * near - far) / (12.0 * np.max(unit)))
    return np.array(columns).T


def test_mollified_impulse_is_symplectic_and_the_exponential_integrator_is_not() -> None:
    springs = stiffness(50.0)
    assert canonical_defect(derivative(mollified_impulse(springs))) < 1e-9
    assert canonical_defect(derivative(exponential_integrator(springs))) > 1e-7
