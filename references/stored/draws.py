"""Burrau's problem from starts that differ by 1e-15, and where each ends at t = 63, by heyoka in
quadruple precision: `python -m references.stored.draws burrau_draws`.

Close triples multiply a rounding by 1e8: the error of one run is one draw from a distribution.
"""

from __future__ import annotations

from functools import lru_cache
from typing import Any, NamedTuple

import numpy as np

from galvi import Problem
from galvi.arrays import Array, read_only
from references.contender import require
from references.heyoka.engine import QUADRUPLE, engine_name
from references.heyoka.taylor import HEYOKA_QUADRUPLE
from references.stored.encounters import burrau
from references.stored.planets import FOLDER, LOOSER, TOLERANCE

DRAWS, DURATION, SIZE = 100, 63.0, 1e-15
FILE = FOLDER / "burrau_draws.csv"


class Draws(NamedTuple):
    """Starts (draws, 3, 2), at rest, and the places at the end (draws, 3, 2)."""

    starts: Array
    ends: Array

    def problem(self, k: int) -> Problem:
        """The k-th problem."""
        return burrau().with_initial_state(self.starts[k], np.zeros((3, 2)))


def table() -> str:
    """The text of the file; raises ModuleNotFoundError without heyoka's real128."""
    require(HEYOKA_QUADRUPLE, burrau())
    first = _start(0)
    apart = np.abs(_end(first, TOLERANCE) - _end(first, LOOSER)).astype(np.float64).max()
    lines = [
        f"# Burrau's problem from {DRAWS} starts that differ by {SIZE:g}, at t = {DURATION:g}",
        f"# source: {engine_name('real128')}, tolerance {TOLERANCE}, high_accuracy",
        f"# accuracy: with {LOOSER} instead, the first one's end differs by {apart:.1e}",
        f"# made by: python -m references.stored.draws {FILE.stem}",
        ",".join([f"{x}{i}{at}" for at in ("", "_end") for i in range(3) for x in "xy"]),
    ]
    for k in range(DRAWS):
        start = _start(k)
        end = _end(start, TOLERANCE).astype(np.float64)
        lines.append(",".join(map(repr, [*start.q0.ravel().tolist(), *end.ravel().tolist()])))
    return "\n".join(lines) + "\n"


def _start(k: int) -> Problem:
    problem = burrau()
    off = np.random.Generator(np.random.Philox(k)).normal(size=(3, 2))
    return problem.with_initial_state(problem.q0 * (1.0 + SIZE * off), problem.v0)


def _end(start: Problem, tolerance: float) -> Any:
    """Places at the end, (3, 2), in quadruple precision."""
    options = {**QUADRUPLE, "tolerance": tolerance}
    states = HEYOKA_QUADRUPLE.states(start, np.array([0.0, DURATION]), options)[0]
    return states[1].reshape(3, 6)[:, :2]


@lru_cache(maxsize=1)
def burrau_draws() -> Draws:
    """The file."""
    lines = FILE.read_text("ascii").splitlines()
    rows = np.array([line.split(",") for line in lines if not line.startswith(("#", "x"))], float)
    starts, ends = rows.reshape(-1, 2, 3, 2).transpose(1, 0, 2, 3)
    return Draws(read_only(starts.copy()), read_only(ends.copy()))


if __name__ == "__main__":
    FILE.write_text(table(), encoding="ascii")
    print(f"wrote references/stored/data/{FILE.name}")
