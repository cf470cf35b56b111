"""What the status of a completed run on a Lagrangian says of its energy."""

from __future__ import annotations

import math

import numpy as np
import pytest
from numba import njit

import galvi

PENDULUM = galvi.PlanarChain([1.0], [1.0], 1.0)


def falling(q, v):
    """-sqrt(f - v^2 / f), f = 1 - 2 / q: undefined beyond the speed of light."""
    f = 1.0 - 2.0 / q[0]
    return -math.sqrt(f - v[0] ** 2 / f)


@njit
def falling_slopes(q, v):
    """Its derivatives by v and q."""
    f, slope = 1.0 - 2.0 / q[0], 2.0 / q[0] ** 2
    r = np.sqrt(f - v[0] ** 2 / f)
    return np.array([v[0] / f / r, -0.5 * (slope + v[0] ** 2 / f**2 * slope) / r])


def gauss(points):
    """Collocation."""
    return galvi.Galerkin(galvi.Polynomials(points), galvi.gauss(points))


@pytest.mark.parametrize("share", [0.9, 0.99, 0.999])
@pytest.mark.parametrize("step", [0.02, 0.1, 0.2])
def test_a_lagrangian_that_is_not_defined_for_a_near_velocity_does_not_end_a_run(share, step):
    system = galvi.Lagrangian(falling, galvi.Rn(1), falling_slopes)
    problem = galvi.Problem(system, [6.0], [-share * (1.0 - 2.0 / 6.0)])
    run = galvi.integrate(problem, gauss(2), step, round(4.0 / step))
    assert run.status == "Completed."


def test_a_changed_energy_is_told_however_large_the_step():
    rng = np.random.default_rng(0)
    told = 0
    for _ in range(200):
        start = rng.normal(scale=1.5, size=2)
        problem = galvi.Problem(galvi.Lagrangian(PENDULUM, galvi.Rn(1)), start[:1], start[1:])
        run = galvi.integrate(problem, gauss(2), rng.uniform(0.3, 6.0), int(rng.integers(1, 5)))
        if not run.success:
            continue
        size = abs(start[1] ** 2) + abs(0.5 * start[1] ** 2 + math.cos(start[0]))
        q, v = run.q[-1], run.p[-1]
        end = 0.5 * v[0] ** 2 - math.cos(q[0])
        change = abs(end - 0.5 * start[1] ** 2 + math.cos(start[0])) / size
        told += change > 0.12
        if abs(change - 0.1) > 0.01:
            assert ("the energy changed" in run.status) == (change > 0.1), (run.status, change)
    assert told > 20
