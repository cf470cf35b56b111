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
TURNS = 6  # turning points of a coordinate, two a revolution, that the part must contain
MOVES = 1e-3  # smallest range of a coordinate, over the largest range, whose turning points count
LARGEST_SPEED_RATIO = 2.0  # of later speeds to those in the measured part
LARGEST_ENERGY_RATIO = 10.0  # of later energy errors per unit of time to those in the measured part
ENERGY_ROUNDING = 1e-12  # relative energy error that counts as round-off
FAST = 1e-3  # speeds below this share of the fastest body's are not compared
# Saved states; total number of pairs of coordinates.
MOST_SAMPLES, FEWEST_SAMPLES, MOST_PAIR_NUMBERS = 4096, 256, 2**24


def extrapolation_objection(scan: Scan, choice: Candidate) -> str:
    """The reason why the extrapolated error of a choice is unreliable; empty if it is reliable.

    If the budget allows, the choice is run once over the whole duration; the run has to complete
    and to resemble the measured part: no body much faster, no larger energy error.
    """
    times = scan.duration / choice.measured
    if times > LARGEST_EXTRAPOLATION:
        return f"an error is not extrapolated to {times:.3g} times the measured length"
    if choice.growth > POWERS[1]:
        return f"the error grew as t^{choice.growth:.1f}, too fast to extrapolate"
    if scan.spent + choice.cost(scan.by) > scan.budget:
        return "a run over the whole duration does not fit into the budget"
    samples = min(MOST_SAMPLES, max(FEWEST_SAMPLES, MOST_PAIR_NUMBERS // scan.problem.v0.size**2))
    run, _, _ = scan.run(choice.degree, choice.steps, choice.steps, samples=samples)
    if not run.success:
        return f"a run over the whole duration failed. {run.status.rstrip('.')}"
    part = int(np.sum(elapsed(run) <= choice.measured * (1.0 + 1e-9)))
    turns = turning_points(run.q[:part].reshape(part, -1))
    if turns < TURNS:
        return f"it contains {turns} turning points of a coordinate, and {TURNS} are needed"
    speeds = np.linalg.norm(run.v, axis=-1)
    speeds = speeds.reshape(len(run.t), -1)
    before = np.maximum(np.max(speeds[:part], axis=0), FAST * np.max(speeds))
    faster = float(np.max(np.max(speeds, axis=0) / np.where(before > 0.0, before, 1.0)))
    if not faster <= LARGEST_SPEED_RATIO:
        return f"later a body is {faster:.1f} times as fast"
    energies = _energies(run)
    off = np.abs(energies - energies[0])
    allowed = LARGEST_ENERGY_RATIO * times * np.max(off[:part]) + ENERGY_ROUNDING * np.max(
        np.abs(energies)
    )
    if not np.max(off) <= allowed:
        return f"later the energy error is {np.max(off):.1e}, in that part {np.max(off[:part]):.1e}"
    return ""


def turning_points(q: Array) -> int:
    """The largest number of turning points of a coordinate; q is (saved, d).

    Coordinates that hardly change are ignored.
    """
    if len(q) < 3:
        return 0
    moves = np.ptp(q, axis=0)
    ahead = np.diff(q[:, moves >= MOVES * np.max(moves)], axis=0)
    return int(np.max(np.sum(ahead[1:] * ahead[:-1] < 0.0, axis=0)))


def _energies(run: Trajectory) -> Array:
    """Energies (saved,), one state at a time, since many bodies need much memory."""
    one_by_one = (slice(k, k + 1) for k in range(len(run.t)))
    return np.concatenate(
        [energy(replace(run, t=run.t[k], q=run.q[k], p=run.p[k])) for k in one_by_one]
    )
