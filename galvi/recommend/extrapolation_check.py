"""Checks an extrapolated error by one full-length run."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from galvi.arrays import Array
from galvi.diagnostics.invariants import energy
from galvi.recommend.recommendation import Candidate
from galvi.recommend.scan import POWERS, Scan
from galvi.systems.velocities import velocity_at
from galvi.trajectory import Trajectory

FARTHEST = 100.0  # times as long as was measured: beyond, an error is not extrapolated
TURNS = 6  # turning points of a coordinate, two a revolution, that the part must hold
MOVES = 1e-3  # of the widest coordinate, from which the turning points of another one count
FASTER = 2.0  # than in the part, from which the rest is another motion
WORSE = 10.0  # energy errors than in the part, per length
ROUNDING = 1e-12  # of the energy
FAST = 1e-3  # of the fastest body's speed, below which those of others are not compared
MOST, FEWEST, ROOM = 4096, 256, 2**24  # saved states; pairs of coordinates in all of them


def extrapolation_objection(scan: Scan, choice: Candidate) -> str:
    """Why the extrapolated error of a choice cannot be relied on; empty when it can.

    The choice is run once over the whole duration, if the budget allows; it has to complete, and to
    be there what it was in the part: no body much faster, its energy as good.
    """
    times = scan.duration / choice.measured
    if times > FARTHEST:
        return f"no error is taken to {times:.3g} times what was measured"
    if choice.growth > POWERS[1]:
        return f"it grew as t^{choice.growth:.1f}, too fast to extrapolate it"
    if scan.spent + choice.cost(scan.by) > scan.budget:
        return "one run over all of it does not fit into the budget"
    samples = min(MOST, max(FEWEST, ROOM // scan.problem.v0.size**2))
    run, _, _ = scan.run(choice.degree, choice.steps, choice.steps, samples=samples)
    if not run.success:
        return f"a run over all of it failed. {run.status.rstrip('.')}"
    part = int(np.sum(np.abs(run.t - run.t[0]) <= choice.measured * (1.0 + 1e-9)))
    turns = turning_points(run.q[:part].reshape(part, -1))
    if turns < TURNS:
        return f"it holds {turns} turning points of a coordinate, and {TURNS} are needed"
    speeds = np.linalg.norm(velocity_at(run.problem.system, run.q, run.p, run.t), axis=-1)
    speeds = speeds.reshape(len(run.t), -1)
    before = np.maximum(np.max(speeds[:part], axis=0), FAST * np.max(speeds))
    faster = float(np.max(np.max(speeds, axis=0) / np.where(before > 0.0, before, 1.0)))
    if not faster <= FASTER:
        return f"later a body is {faster:.1f} times as fast"
    energies = _energies(run)
    off = np.abs(energies - energies[0])
    allowed = WORSE * times * np.max(off[:part]) + ROUNDING * np.max(np.abs(energies))
    if not np.max(off) <= allowed:
        return f"later the energy is off by {np.max(off):.1e}, in it by {np.max(off[:part]):.1e}"
    return ""


def turning_points(q: Array) -> int:
    """How often the coordinate turns that turns most often; q is (saved, d).

    Coordinates that hardly move do not count.
    """
    if len(q) < 3:
        return 0
    moves = np.ptp(q, axis=0)
    ahead = np.diff(q[:, moves >= MOVES * np.max(moves)], axis=0)
    return int(np.max(np.sum(ahead[1:] * ahead[:-1] < 0.0, axis=0)))


def _energies(run: Trajectory) -> Array:
    """(saved,), one state at a time, since many bodies need much memory."""
    one_by_one = (slice(k, k + 1) for k in range(len(run.t)))
    return np.concatenate(
        [energy(replace(run, t=run.t[k], q=run.q[k], p=run.p[k])) for k in one_by_one]
    )
