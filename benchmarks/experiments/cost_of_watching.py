"""What a run costs besides its steps, and how much of a run judging its energy takes.

python -m benchmarks.experiments.cost_of_watching

Processor time: the least of interleaved calls, so that other load counts little.
"""

from __future__ import annotations

import time
from functools import partial

import numpy as np

import galvi
from galvi.run.integrate import prepared

ROUNDS = 200


def double(q, v):
    """A double pendulum's Lagrangian, as a user writes it."""
    kinetic = v[0] ** 2 + 0.5 * v[1] ** 2 + v[0] * v[1] * np.cos(q[0] - q[1])
    return kinetic + 9.81 * (2.0 * np.cos(q[0]) + np.cos(q[1]))


def gauss(points):
    """Collocation."""
    return galvi.Galerkin(galvi.Polynomials(points), galvi.gauss(points))


def cases():
    """Name -> problem, method, step and number of steps."""
    own = galvi.Problem(galvi.Lagrangian(double, galvi.Rn(2)), [1.0, 0.5], [0.0, 0.0])
    return {
        "oscillator": (galvi.problems.harmonic_oscillator(), gauss(4), 0.1, 100),
        "outer solar system": (galvi.problems.outer_solar_system(), gauss(8), 500.0, 1000),
        "free rigid body": (galvi.problems.free_rigid_body(), gauss(6), 0.2, 1000),
        "double pendulum": (galvi.problems.double_pendulum(), gauss(8), 0.05, 1000),
        "a user's double pendulum": (own, gauss(8), 0.05, 1000),
    }


def seconds(call):
    """Processor time of one call."""
    begin = time.process_time()
    call()
    return time.process_time() - begin


def least(*calls):
    """The least time of each of some calls, interleaved."""
    times = [[seconds(call) for call in calls] for _ in range(ROUNDS)]
    return np.min(times, axis=0)


def main():
    """Print a line for each case."""
    print("case: us of a run of one step, of the whole run, of judging it, and its share")
    for name, (problem, method, step, steps) in cases().items():
        whole = prepared(problem, method, step, steps)
        one, watched, other = least(
            partial(galvi.integrate, problem, method, step, 1), whole, partial(whole, watched=False)
        )
        judging = watched - other
        print(
            f"{name:25s} {1e6 * one:6.0f} {1e6 * watched:7.0f} {1e6 * judging:6.0f} "
            f"{judging / watched:7.1%}"
        )


if __name__ == "__main__":
    main()
