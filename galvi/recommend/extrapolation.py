"""Checks that an error measured over the first part of a duration holds for all of it."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from galvi.arrays import Array
from galvi.diagnostics.invariants import energy
from galvi.recommend.recommendation import Candidate
from galvi.recommend.scan import POWERS, Scan, elapsed
from galvi.trajectory import Trajectory

# Largest ratio of the duration to the part over which an error is extrapolated.
LARGEST_EXTRAPOLATION = 100.0
LEAST_TURNING_POINTS = 6  # of a coordinate in the measured part; a revolution has two
LEAST_RANGE = 1e-3  # range of a coordinate, over the largest range, from which its turns count
LARGEST_SPEED_RATIO = 2.0  # of later speeds to those in the measured part
LARGEST_ENERGY_RATIO = 10.0  # of later energy errors per unit of time to those in the measured part
ENERGY_ROUNDING = 1e-12  # relative energy error that counts as round-off
SLOW_SHARE = 1e-3  # speeds below this share of the fastest body's are not compared
# Limits of the number of saved states, and of that number times the square of the coordinates.
MOST_SAMPLES, FEWEST_SAMPLES, MOST_PAIR_NUMBERS = 4096, 256, 2**24


def extrapolation_objection(scan: Scan, choice: Candidate) -> str:
    """The reason why the extrapolated error of a choice is unreliable; "" if it is reliable.

    The choice is run once over the whole duration, if the budget allows that. This run must be
    completed and must resemble the measured part: no body much faster, no larger energy error.
    """
    duration_ratio = scan.duration / choice.measured
    if duration_ratio > LARGEST_EXTRAPOLATION:
        return f"an error is not extrapolated to {duration_ratio:.3g} times the measured length"
    if choice.growth > POWERS[1]:
        return f"the error grew as t^{choice.growth:.1f}, too fast to extrapolate"
    if scan.spent + choice.cost(scan.by) > scan.budget:
        return "a run over the whole duration does not fit into the budget"
    samples = min(MOST_SAMPLES, max(FEWEST_SAMPLES, MOST_PAIR_NUMBERS // scan.problem.v0.size**2))
    run, _, _ = scan.run(choice.degree, choice.steps, choice.steps, samples=samples)
    if not run.success:
        return f"a run over the whole duration failed. {run.status.rstrip('.')}"
    part_count = int(np.sum(elapsed(run) <= choice.measured * (1.0 + 1e-9)))
    turning_count = turning_points(run.q[:part_count].reshape(part_count, -1))
    if turning_count < LEAST_TURNING_POINTS:
        return (
            f"it contains {turning_count} turning points of a coordinate, and "
            f"{LEAST_TURNING_POINTS} are needed"
        )
    speeds = np.linalg.norm(run.v, axis=-1)
    speeds = speeds.reshape(len(run.t), -1)
    speeds_before = np.maximum(np.max(speeds[:part_count], axis=0), SLOW_SHARE * np.max(speeds))
    speed_ratio = float(
        np.max(np.max(speeds, axis=0) / np.where(speeds_before > 0.0, speeds_before, 1.0))
    )
    if not speed_ratio <= LARGEST_SPEED_RATIO:
        return f"later a body is {speed_ratio:.1f} times as fast"
    energies = _energies(run)
    energy_errors = np.abs(energies - energies[0])
    allowed = LARGEST_ENERGY_RATIO * duration_ratio * np.max(
        energy_errors[:part_count]
    ) + ENERGY_ROUNDING * np.max(np.abs(energies))
    if not np.max(energy_errors) <= allowed:
        return (
            f"later the energy error is {np.max(energy_errors):.1e}, in that part "
            f"{np.max(energy_errors[:part_count]):.1e}"
        )
    return ""


def turning_points(q: Array) -> int:
    """The largest number of turning points of a coordinate; q is (saved, d).

    Coordinates that hardly change are ignored.
    """
    if len(q) < 3:
        return 0
    ranges = np.ptp(q, axis=0)
    changes = np.diff(q[:, ranges >= LEAST_RANGE * np.max(ranges)], axis=0)
    return int(np.max(np.sum(changes[1:] * changes[:-1] < 0.0, axis=0)))


def _energies(run: Trajectory) -> Array:
    """Energies (saved,), one state at a time, since many bodies need much memory."""
    one_by_one = (slice(k, k + 1) for k in range(len(run.t)))
    return np.concatenate(
        [energy(replace(run, t=run.t[k], q=run.q[k], p=run.p[k])) for k in one_by_one]
    )
