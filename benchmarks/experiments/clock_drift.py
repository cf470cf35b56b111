"""Does g (H - E0) drift in a clock? `python -m benchmarks.experiments.clock_drift`.

K = g (H - E0) is 0 along the motion, and steps in `galvi.DynamicalTime` keep it up to rounding: it
should grow like the square root of their number. Shown is its mean change in a step, in units of
its size at the start, g |E0|, with the standard error, for several tolerances of the iteration,
with and without the mean of the last two passes (`galvi.fast.clock_stepper`).
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

import numpy as np
import pandas as pd

import galvi
from galvi.fast import clock_stepper

METHOD = galvi.Galerkin(galvi.Polynomials(8), galvi.gauss(8), clock=galvi.DynamicalTime())
STEP, BLOCKS, IN_BLOCK = 0.4, 100, 2000
WAYS = tuple((power, mean) for power in (52, 56, 60, 64) for mean in (True, False))


@contextmanager
def stopped_at(tolerance: float, noise: float) -> Iterator[None]:
    """The tolerance of the iteration; the change below which the mean of two passes is taken."""
    usual = clock_stepper.TOLERANCE, clock_stepper.NOISE
    clock_stepper.TOLERANCE, clock_stepper.NOISE = tolerance, noise
    try:
        yield
    finally:
        clock_stepper.TOLERANCE, clock_stepper.NOISE = usual


def drift(problem: galvi.Problem, blocks: int = BLOCKS, steps: int = IN_BLOCK) -> dict[str, float]:
    """The mean change of K in a step, its standard error, and passes of a step."""
    system: Any = problem.system
    motion = clock_stepper.motion_in_lanes(problem, METHOD, None)
    assert motion is not None
    state = motion.at(problem.q0, problem.v0, problem.t0)
    masses = clock_stepper.masses_in_clock(system, problem.q0.shape[1])
    K, passes = [0.0], 0
    for _ in range(blocks):
        found = motion.advance(state, STEP, steps, None, False)
        state, passes = found.after, passes + int(found.taken.counts[0])
        energy = clock_stepper.energy_of(masses, state.state.reshape(4, *problem.q0.shape))
        K.append(float(motion.rate(state.state[0])) * float(np.sum(energy - state.clock[2:])))
    size = float(motion.rate(problem.q0.ravel())) * abs(state.clock[2])
    changes = np.diff(K) / (steps * size)
    return {
        "K a step": float(np.mean(changes)),
        "standard error": float(np.std(changes, ddof=1) / np.sqrt(blocks)),
        "passes": passes / (blocks * steps),
    }


def drift_table(problem: galvi.Problem, blocks: int = BLOCKS) -> pd.DataFrame:
    """A row for each tolerance, with and without the mean."""
    rows = []
    for power, mean in WAYS:
        with stopped_at(2.0**-power, clock_stepper.NOISE if mean else 0.0):
            rows.append({"tolerance": f"2^-{power}", "mean": mean, **drift(problem, blocks)})
    return pd.DataFrame(rows)


def binary(eccentricity: float = 0.9) -> galvi.Problem:
    """Two bodies of masses 3/4 and 1/4, at pericentre, in a plane through no axis."""
    e, m = eccentricity, np.array([[-0.25], [0.75]])
    x, y = np.array([0.8, 0.36, 0.48]), np.array([-0.6, 0.48, 0.64])
    return galvi.Problem(
        galvi.NBody([0.75, 0.25]), m * (1.0 - e) * x, m * np.sqrt((1.0 + e) / (1.0 - e)) * y
    )


if __name__ == "__main__":
    with pd.option_context("display.float_format", "{:.2g}".format):
        print(drift_table(binary()).to_string(index=False))
