"""The truth for a rigid body in weight, kept in references/data, so that a report needs no heyoka.

Integrated by heyoka with quadruple precision; `python -m references.stored_attitude` makes it anew.
A file tells its problem by inertia, mass, centre of mass, weight and start, to the last bit.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import numpy as np

from galvi import Problem, RigidBody, Trajectory, problems
from galvi.arrays import Array, read_only
from references.contender import require
from references.heyoka_engine import engine_name
from references.heyoka_rigid import HEYOKA_RIGID_QUADRUPLE
from references.outcome import outcome
from references.principal_body import is_known_body
from references.setting import check_keys, described, sample_times
from references.truth import FOLDER

CASES: Mapping[str, tuple[Problem, float]] = {  # file: problem, horizon
    "pendulum_3d": (problems.pendulum_3d(), 20.0),
}
EVERY = 0.5  # between states that are kept
TOLERANCE, LOOSER = 1e-28, 1e-25


def table(case: str) -> str:
    """The text of one file; raises ModuleNotFoundError without heyoka's real128."""
    problem, horizon = CASES[case]
    samples = round(horizon / EVERY)
    run, looser = (
        HEYOKA_RIGID_QUADRUPLE.run(problem, horizon, {"samples": samples, "tolerance": tolerance})
        for tolerance in (TOLERANCE, LOOSER)
    )
    entries = np.concatenate([run.q.reshape(samples + 1, 9), run.p], axis=1)
    others = np.concatenate([looser.q.reshape(samples + 1, 9), looser.p], axis=1)
    lines = [
        f"# {problem.name}, the truth",
        f"# source: {engine_name('real128')}, tolerance {TOLERANCE}, high_accuracy",
        f"# accuracy: rounded to double; with {LOOSER} instead, "
        f"{np.count_nonzero(entries != others)} of {entries.size} numbers differ",
        f"# made by: python -m references.stored_attitude {case}",
        f"# units: {problem.units}; t since the start",
        *(f"# {name}: " + " ".join(map(repr, row)) for name, row in _identity(problem).items()),
        "t," + ",".join(f"R{i}{j}" for i in "xyz" for j in "xyz") + ",px,py,pz",
    ]
    for t, row in zip((run.t - problem.t0).tolist(), entries.tolist(), strict=True):
        lines.append(",".join(map(repr, [t, *row])))
    return "\n".join(lines) + "\n"


def _identity(problem: Problem) -> dict[str, list[float]]:
    """What tells one problem from another."""
    system: Any = problem.system
    weight = system.potential
    return {
        "inertia": system.inertia.ravel().tolist(),
        "mass": [float(weight.mass)],
        "centre": np.asarray(weight.centre, dtype=np.float64).tolist(),
        "g": np.asarray(weight.g, dtype=np.float64).tolist(),
        "q0": problem.q0.ravel().tolist(),
        "v0": problem.v0.tolist(),
    }


@dataclass(frozen=True, eq=False)
class Stored:
    """One file: whose it is, times since the start (saved,), q (saved, 3, 3) and p (saved, 3)."""

    identity: Mapping[str, list[float]]
    t: Array
    q: Array
    p: Array

    def of(self, problem: Problem) -> bool:
        """Whether the problem is this one, to the last bit; its t0 is free."""
        heavy = isinstance(problem.system, RigidBody) and problem.system.potential is not None
        return heavy and is_known_body(problem) and _identity(problem) == self.identity


@lru_cache(maxsize=len(CASES))
def stored(case: str) -> Stored:
    """The file of one case."""
    lines = (FOLDER / f"{case}.csv").read_text("ascii").splitlines()
    header = dict(line[2:].split(": ", 1) for line in lines if line[0] == "#" and ": " in line)
    identity = {
        name: [float(x) for x in header[name].split()] for name in _identity(CASES[case][0])
    }
    rows = np.array([[float(x) for x in line.split(",")] for line in lines if line[0].isdigit()])
    arrays = (rows[:, 0], rows[:, 1:10].reshape(-1, 3, 3), rows[:, 10:])
    return Stored(identity, *map(read_only, arrays))


@dataclass(frozen=True)
class StoredAttitude:
    """The states kept in references/data, for exactly the problems that were integrated.

    Setting: samples. Duration and samples must fall on times that are kept, every half unit.
    Accurate to the rounding of the states.
    """

    name: str = "stored truth, rigid bodies"
    exact: bool = True
    missing: str = ""

    def supports(self, problem: Problem) -> bool:
        """By inertia, weight and start, compared bit for bit."""
        return any(stored(case).of(problem) for case in CASES)

    def run(self, problem: Problem, duration: float, setting: Mapping[str, Any]) -> Trajectory:
        """Look up; see `Contender`. ValueError for times that are not kept."""
        require(self, problem)
        check_keys(setting, ("samples",))
        times = sample_times(problem.t0, duration, setting)
        known = next(stored(case) for case in CASES if stored(case).of(problem))
        since = times - problem.t0
        rows = np.argmin(np.abs(since[:, None] - known.t), axis=1)
        lost = since != known.t[rows]
        if np.any(lost):
            raise ValueError(
                f"the stored truth is kept every {EVERY:g} up to {known.t[-1]:g} after the start; "
                f"received a sample at {since[lost][0]:g}. Choose a duration and samples among "
                "these."
            )
        method = described(self.name, setting, f"heyoka, real128, tolerance {TOLERANCE}")
        return outcome(problem, method, times, known.q[rows], p=known.p[rows], counts={"steps": 0})


STORED_ATTITUDE = StoredAttitude()

if __name__ == "__main__":
    import sys

    for name in sys.argv[1:] or CASES:
        (FOLDER / f"{name}.csv").write_text(table(name), encoding="ascii")
        print(f"wrote references/data/{name}.csv")
