"""The truth for chains of links, kept in references/data, so that a report needs no heyoka.

Integrated by heyoka with quadruple precision; `python -m references.stored_chain` makes it anew.
A file tells its problem by links, gravity and start, to the last bit.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import numpy as np

from galvi import Problem, Trajectory, problems
from galvi.arrays import Array, read_only
from references.chain_equations import is_chain
from references.contender import require
from references.heyoka_chain import HEYOKA_CHAIN_QUADRUPLE
from references.heyoka_engine import engine_name
from references.outcome import outcome
from references.setting import check_keys, described, sample_times
from references.stored_attitude import LOOSER, TOLERANCE
from references.truth import FOLDER

CASES: Mapping[str, tuple[Problem, float]] = {  # file: problem, horizon
    "double_pendulum": (problems.double_pendulum(), 10.0),
    "planar_chain": (problems.planar_chain(), 10.0),
}
EVERY = 0.5  # between states that are kept


def table(case: str) -> str:
    """The text of one file; raises ModuleNotFoundError without heyoka's real128."""
    problem, horizon = CASES[case]
    samples = round(horizon / EVERY)
    run, looser = (
        HEYOKA_CHAIN_QUADRUPLE.run(problem, horizon, {"samples": samples, "tolerance": tolerance})
        for tolerance in (TOLERANCE, LOOSER)
    )
    n = problem.q0.size
    entries, others = (np.concatenate([made.q, made.p], axis=1) for made in (run, looser))
    lines = [
        f"# {problem.name}, the truth",
        f"# source: {engine_name('real128')}, tolerance {TOLERANCE}, high_accuracy",
        f"# accuracy: rounded to double; with {LOOSER} instead, "
        f"{np.count_nonzero(entries != others)} of {entries.size} numbers differ",
        f"# made by: python -m references.stored_chain {case}",
        f"# units: {problem.units}; t since the start",
        *(f"# {name}: " + " ".join(map(repr, row)) for name, row in _identity(problem).items()),
        ",".join(["t", *(f"{x}{i}" for x in "qp" for i in range(n))]),
    ]
    for t, row in zip((run.t - problem.t0).tolist(), entries.tolist(), strict=True):
        lines.append(",".join(map(repr, [t, *row])))
    return "\n".join(lines) + "\n"


def _identity(problem: Problem) -> dict[str, list[float]]:
    """What tells one problem from another."""
    system: Any = problem.system
    chain = system.function
    return {
        "masses": chain.masses.tolist(),
        "lengths": chain.lengths.tolist(),
        "gravity": [float(chain.gravity)],
        "rods": [float(chain.rods)],
        "q0": problem.q0.tolist(),
        "v0": problem.v0.tolist(),
    }


@dataclass(frozen=True, eq=False)
class Stored:
    """One file: whose it is, times since the start (saved,), q and p (saved, n)."""

    identity: Mapping[str, list[float]]
    t: Array
    q: Array
    p: Array

    def of(self, problem: Problem) -> bool:
        """Whether the problem is this one, to the last bit; its t0 is free."""
        return is_chain(problem) and _identity(problem) == self.identity


@lru_cache(maxsize=len(CASES))
def stored(case: str) -> Stored:
    """The file of one case."""
    lines = (FOLDER / f"{case}.csv").read_text("ascii").splitlines()
    header = dict(line[2:].split(": ", 1) for line in lines if line[0] == "#" and ": " in line)
    identity = {
        name: [float(x) for x in header[name].split()] for name in _identity(CASES[case][0])
    }
    rows = np.array([[float(x) for x in line.split(",")] for line in lines if line[0].isdigit()])
    q, p = np.split(rows[:, 1:], 2, axis=1)
    return Stored(identity, *map(read_only, (rows[:, 0], q, p)))


@dataclass(frozen=True)
class StoredChain:
    """The states kept in references/data, for exactly the problems that were integrated.

    Setting: samples. Duration and samples must fall on times that are kept, every half unit.
    Accurate to the rounding of the states.
    """

    name: str = "stored truth, chains"
    exact: bool = True
    missing: str = ""

    def supports(self, problem: Problem) -> bool:
        """By links, gravity and start, compared bit for bit."""
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


STORED_CHAIN = StoredChain()

if __name__ == "__main__":
    import sys

    for name in sys.argv[1:] or CASES:
        (FOLDER / f"{name}.csv").write_text(table(name), encoding="ascii")
        print(f"wrote references/data/{name}.csv")
