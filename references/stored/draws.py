"""Burrau's problem from starts that differ by 1e-15, and where each ends at t = 63, by heyoka in
quadruple precision: `python -m references.stored.draws`.

Close triples multiply a rounding by 1e8: the error of one run is one draw from a distribution.
"""

from __future__ import annotations

from functools import lru_cache
from typing import NamedTuple

import numpy as np

from galvi import Problem
from galvi.arrays import Array, read_only
from references.contender import require
from references.heyoka.engine import QUADRUPLE, engine_name
from references.heyoka.taylor import HEYOKA_QUADRUPLE
from references.stored.encounters import burrau
from references.stored.planets import FOLDER, TOLERANCE

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
    problem = burrau()
    require(HEYOKA_QUADRUPLE, problem)
    lines = [
        f"# Burrau's problem from {DRAWS} starts that differ by {SIZE:g}, at t = {DURATION:g}",
        f"# source: {engine_name('real128')}, tolerance {TOLERANCE}, high_accuracy",
        "# made by: python -m references.stored.draws",
        ",".join([f"{x}{i}{at}" for at in ("", "_end") for i in range(3) for x in "xy"]),
    ]
    for k in range(DRAWS):
        off = np.random.Generator(np.random.Philox(k)).normal(size=(3, 2))
        start = problem.with_initial_state(problem.q0 * (1.0 + SIZE * off), problem.v0)
        options = {**QUADRUPLE, "tolerance": TOLERANCE}
        states = HEYOKA_QUADRUPLE.states(start, np.array([0.0, DURATION]), options)[0]
        end = states[1].reshape(3, 6)[:, :2].astype(np.float64)
        lines.append(",".join(map(repr, [*start.q0.ravel().tolist(), *end.ravel().tolist()])))
    return "\n".join(lines) + "\n"


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
