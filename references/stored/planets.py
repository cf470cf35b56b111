"""Stored truths of point masses, by heyoka in quadruple precision: `python -m
references.stored.planets`.

Each case is stored at T j / 10 and at T j / 100, j = 1 .. 10: ten samples to its horizon T or to
T / 10, or the end of T / 100. Numbers have 25 significant digits; the file's header states their
difference from those at a looser tolerance.
"""

from __future__ import annotations

import sys
import time
from collections.abc import Mapping
from dataclasses import dataclass
from decimal import Decimal
from functools import cache
from pathlib import Path
from typing import Any, ClassVar

import numpy as np

from galvi import NBody, Problem, Trajectory, problems
from galvi.arrays import Array, read_only
from references.as_trajectory import as_trajectory
from references.contender import require, times_of_run
from references.heyoka.engine import QUADRUPLE, engine_name
from references.heyoka.taylor import HEYOKA_QUADRUPLE
from references.setting import described
from references.stored.encounters import ENCOUNTERS

FOLDER = Path(__file__).parent / "data"
TOLERANCE, LOOSER_TOLERANCE = 1e-28, 1e-25  # of the stored run, and of the run compared with it
TIME_ROUNDING = 4.0 * 2.0**-52  # largest relative difference of two roundings of one time
# Largest difference of a start computed on two processors, relative to its largest entry.
START_ROUNDING = 1e-14


def sampled(horizon: float) -> Array:
    """The stored times since the start, 0 included, (20,)."""
    tenths = horizon * np.arange(1, 11) / 10
    return np.array([0.0, *(horizon * np.arange(1, 10) / 100), *tenths])


def table(case: str) -> str:
    """The text of one file; raises ModuleNotFoundError without heyoka's real128."""
    problem, horizon = CASES[case]
    require(HEYOKA_QUADRUPLE, problem)
    times, began = sampled(horizon), time.perf_counter()
    states, looser = (
        HEYOKA_QUADRUPLE.states(problem, times, {**QUADRUPLE, "tolerance": tolerance})[0]
        for tolerance in (TOLERANCE, LOOSER_TOLERANCE)
    )
    differences = (states - looser).astype(np.float64).reshape(len(times), -1, 2, 3)[:, :, 0]
    system: Any = problem.system
    lines = [
        f"# {problem.name}, the truth",
        f"# source: {engine_name('real128')}, tolerance {TOLERANCE}, high_accuracy",
        f"# accuracy: with {LOOSER_TOLERANCE} instead, positions differ by at most "
        f"{np.abs(differences).max():.1e}",
        f"# made by: python -m references.stored.planets {case} "
        f"({time.perf_counter() - began:.0f} s)",
        f"# units: {problem.units}; t since the start",
        "# masses: " + " ".join(map(repr, system.masses.tolist())),
        f"# G: {system.G!r}",
        "t,body,x,y,z,vx,vy,vz",
    ]
    for t, row in zip(times.tolist(), states.reshape(len(times), -1, 6), strict=True):
        for body, numbers in enumerate(row):
            digits = [f"{Decimal(str(x)):.24e}" for x in numbers]
            lines.append(",".join([repr(t), str(body), *digits]))
    return "\n".join(lines) + "\n"


@dataclass(frozen=True, eq=False)
class Stored:
    """One file: G, masses (bodies,), times since the start (saved,), q and v there (saved, ...)."""

    G: float
    masses: Array
    t: Array
    q: Array
    v: Array

    def of(self, problem: Problem) -> bool:
        """Whether the problem equals this one bit for bit, except for t0."""
        system = problem.system
        return (
            isinstance(system, NBody)
            and not system.forces
            and system.G == self.G
            and np.array_equal(system.masses, self.masses)
            and np.array_equal(problem.q0, self.q[0])
            and np.array_equal(problem.v0, self.v[0])
        )


@cache
def stored(case: str) -> Stored:
    """The file of one case, each number rounded once to double."""
    lines = (FOLDER / f"{case}.csv").read_text("ascii").splitlines()
    header = dict(line[2:].split(": ", 1) for line in lines if line[0] == "#" and ": " in line)
    rows = [[float(x) for x in line.split(",")] for line in lines if line[0].isdigit()]
    masses = np.array([float(m) for m in header["masses"].split()])
    numbers = np.array(rows).reshape(-1, masses.size, 8)
    size = 3 if numbers[:, :, [4, 7]].any() else 2  # of a motion in the plane
    q, v = numbers[:, :, 2 : 2 + size], numbers[:, :, 5 : 5 + size]
    arrays = (masses, numbers[:, 0, 0], q, v)
    return Stored(float(header["G"]), *map(read_only, arrays))


def with_stored_start(case: str, problem: Problem) -> Problem:
    """The problem with the start of its file, since sines and sums differ in their last bits
    between processors. ValueError for a larger difference."""
    truth = stored(case)
    for computed, start in ((problem.q0, truth.q[0]), (problem.v0, truth.v[0])):
        if np.max(np.abs(computed - start)) > START_ROUNDING * np.max(np.abs(start)):
            raise ValueError(
                f"the start of {problem.name} must be that of {case}.csv, to {START_ROUNDING:g}; "
                f"received {computed.tolist()}. Make the file anew."
            )
    return problem.with_initial_state(truth.q[0], truth.v[0])


CASES: Mapping[str, tuple[Problem, float]] = {  # file: problem, T in its unit of time
    "outer_solar_system": (problems.outer_solar_system(), 3_652_500.0),
    "applegate": (problems.applegate(), 10_000.0),
    "solar_system": (problems.solar_system(), 10_000.0),
    "solar_system_without_pluto": (problems.solar_system(pluto=False), 73_050.0),
    **{
        case: (with_stored_start(case, make()), horizon)
        for case, (make, horizon) in ENCOUNTERS.items()
    },
}


@dataclass(frozen=True)
class StoredTruth:
    """Stored states of the planets, for exactly the problems that were integrated.

    Setting: samples. Duration and samples must fall on stored times (see the module). Accurate to
    the rounding of positions and times: a time that differs from the stored one by rounding moves
    the bodies along their velocity. The bodies are Newton's point masses.
    """

    fixed_step: ClassVar[bool] = False

    name: str = "stored truth"
    exact: bool = True
    missing: str = ""

    def supports(self, problem: Problem) -> bool:
        """A problem whose masses, G and start equal those of a file bit for bit."""
        return any(stored(case).of(problem) for case in CASES)

    def run(self, problem: Problem, duration: float, setting: Mapping[str, Any]) -> Trajectory:
        """Look up; see `Contender`. ValueError for times that are not stored."""
        times = times_of_run(self, problem, duration, setting)
        truth = next(stored(case) for case in CASES if stored(case).of(problem))
        since = times - problem.t0
        rows = np.argmin(np.abs(since[:, None] - truth.t), axis=1)
        late = since - truth.t[rows]
        not_stored = np.abs(late) > TIME_ROUNDING * np.abs(times)
        if np.any(not_stored):
            stored_times = ", ".join(f"{t:g}" for t in truth.t[1:])
            raise ValueError(
                f"the truth is stored at {stored_times} after the start; received a sample at "
                f"{since[not_stored][0]:g}. Choose a duration and samples among these."
            )
        q = truth.q[rows] + truth.v[rows] * late[:, None, None]
        method = described(self.name, setting, f"heyoka, real128, tolerance {TOLERANCE}")
        return as_trajectory(problem, method, times, q, truth.v[rows], counts={"steps": 0})


STORED_TRUTH = StoredTruth()

if __name__ == "__main__":
    for name in sys.argv[1:] or CASES:
        (FOLDER / f"{name}.csv").write_text(table(name), encoding="ascii")
        print(f"wrote references/stored/data/{name}.csv")
