"""Errors of a run against a reference, and of its invariants.

``truth`` is a trajectory of a reference at evenly spaced times, the same number in each step of
``run``, step ends included. Each function returns a number, or an array over time where noted; NaN
for a failed run.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from benchmarks.measures import independent_invariants
from galvi import Trajectory
from galvi.arrays import Array

PER_STEP = 20


def one_step_error(run: Trajectory, truth: Trajectory) -> float:
    """Largest component of |q - q_true| over all step ends, in the problem's unit of length."""
    per_step = (len(truth.t) - 1) // (len(run.t) - 1)
    return largest(run.q - truth.q[::per_step])


def curve_error(run: Trajectory, truth: Trajectory) -> float:
    """Largest component of |q(t) - q_true(t)| along the Galerkin curve, at the truth's times."""
    return largest(run(truth.t) - truth.q)


def curve_times(run: Trajectory, per_step: int = PER_STEP) -> Array:
    """Evenly spaced times along the run, (steps per_step + 1,)."""
    steps = len(run.t) - 1
    return np.linspace(run.t[0], run.t[-1], steps * per_step + 1)


def energy_errors(run: Trajectory, t: Any = None) -> Array:
    """(H - H(t0)) / |H(t0)| at step ends, (steps + 1,), or along the curve at t."""
    problem = run.problem
    exact = float(independent_invariants.energy(problem, problem.q0[None], problem.v0[None])[0])
    return (independent_invariants.energy(problem, *_motion(run, t)) - exact) / abs(exact)


def angular_momentum_errors(run: Trajectory, t: Any = None) -> Array:
    """|L - L(t0)| / |L(t0)| at step ends, (steps + 1,), or along the curve at t; signed in 2-D."""
    problem = run.problem
    exact = independent_invariants.angular_momentum(problem, problem.q0[None], problem.v0[None])[0]
    change = independent_invariants.angular_momentum(problem, *_motion(run, t)) - exact
    if np.ndim(exact):
        change = np.linalg.norm(change, axis=-1)
    return change / np.linalg.norm(exact)


def largest_energy_error(run: Trajectory, truth: Any = None) -> float:
    """Largest relative energy error over step ends, from (q, p)."""
    return largest(energy_errors(run))


def largest_energy_error_on_curve(run: Trajectory, truth: Any = None) -> float:
    """Largest relative energy error along the Galerkin curve, from (q, q')."""
    return largest(energy_errors(run, curve_times(run)))


def largest_angular_momentum_error(run: Trajectory, truth: Any = None) -> float:
    """Largest relative angular momentum error over step ends, from (q, p)."""
    return largest(angular_momentum_errors(run))


def largest_angular_momentum_error_on_curve(run: Trajectory, truth: Any = None) -> float:
    """Largest relative angular momentum error along the Galerkin curve, from (q, q')."""
    return largest(angular_momentum_errors(run, curve_times(run)))


def _motion(run: Trajectory, t: Any) -> tuple[Array, Array]:
    """(q, v) at step ends, from (q, p), or along the curve at t (k,)."""
    if t is None:
        return run.q, run.v
    return run(t), run.velocity(t)


def largest(differences: Array) -> float:
    """The largest magnitude of any entry."""
    return float(np.max(np.abs(differences)))


QUANTITIES = {
    "one-step error": one_step_error,
    "curve error": curve_error,
    "energy error": largest_energy_error,
    "energy error along the curve": largest_energy_error_on_curve,
    "angular momentum error": largest_angular_momentum_error,
    "angular momentum error along the curve": largest_angular_momentum_error_on_curve,
}
