"""Starts drawn at random, and where each ends, by heyoka in quadruple precision.

Burrau's problem from starts that differ by 1e-15: close triples multiply a rounding by 1e8, so that
the error of one run is one draw from a distribution. Binaries that meet a star, at any phase and
distance: each is another encounter. `python -m references.stored.draws NAME` makes a file.
"""

from __future__ import annotations

import math
import sys
from collections.abc import Callable, Mapping
from functools import lru_cache
from typing import Any, NamedTuple

import numpy as np

from galvi import Problem
from galvi.arrays import Array, read_only
from references.contender import require
from references.heyoka.engine import QUADRUPLE, engine_name
from references.heyoka.taylor import HEYOKA_QUADRUPLE
from references.stored.encounters import binary_meets_star, burrau
from references.stored.planets import FOLDER, LOOSER, TOLERANCE

DRAWS, SIZE = 100, 1e-15


class Drawn(NamedTuple):
    """A problem whose start is drawn: a generator's draw, in words, and the time at the end."""

    start: Callable[[np.random.Generator], Problem]
    words: str
    duration: float


def _moved(random: np.random.Generator) -> Problem:
    problem = burrau()
    off = random.normal(size=(3, 2))
    return problem.with_initial_state(problem.q0 * (1.0 + SIZE * off), problem.v0)


def _flight(random: np.random.Generator) -> Problem:
    phase, aside, above = random.uniform([0.0, -2.0, -1.0], [math.tau, 2.0, 1.0])
    return binary_meets_star(phase, aside, above)


BURRAU, BINARY = "burrau_draws", "binary_draws"
DRAWN: Mapping[str, Drawn] = {
    BURRAU: Drawn(_moved, f"from {DRAWS} starts that differ by {SIZE:g}", 63.0),
    BINARY: Drawn(_flight, f"at {DRAWS} phases of the binary and places of the star", 60.0),
}


class Draws(NamedTuple):
    """The first problem; starts, velocities and places at the end, (draws, 3, d), of all."""

    first: Problem
    starts: Array
    velocities: Array
    ends: Array

    def problem(self, k: int) -> Problem:
        """The k-th problem."""
        return self.first.with_initial_state(self.starts[k], self.velocities[k])


def table(name: str) -> str:
    """The text of a file; raises ModuleNotFoundError without heyoka's real128."""
    drawn, first = DRAWN[name], _start(name, 0)
    require(HEYOKA_QUADRUPLE, first)
    d = first.q0.shape[1]
    apart = np.abs(_end(name, first, TOLERANCE) - _end(name, first, LOOSER))
    lines = [
        f"# {first.name[0].upper()}{first.name[1:]} {drawn.words}, at t = {drawn.duration:g}",
        f"# source: {engine_name('real128')}, tolerance {TOLERANCE}, high_accuracy",
        f"# accuracy: with {LOOSER} instead, the first one's end differs by "
        f"{apart.astype(np.float64).max():.1e}",
        f"# made by: python -m references.stored.draws {name}",
        ",".join(
            f"{of}{x}{i}{at}"
            for of, at in (("", ""), ("v", ""), ("", "_end"))
            for i in range(3)
            for x in "xyz"[:d]
        ),
    ]
    for k in range(DRAWS):
        start = _start(name, k)
        end = _end(name, start, TOLERANCE).astype(np.float64)
        values = np.concatenate([start.q0, start.v0, end]).ravel().tolist()
        lines.append(",".join(map(repr, values)))
    return "\n".join(lines) + "\n"


def _start(name: str, k: int) -> Problem:
    return DRAWN[name].start(np.random.Generator(np.random.Philox(k)))


def _end(name: str, start: Problem, tolerance: float) -> Any:
    """Places at the end, (3, d), in quadruple precision."""
    options, times = {**QUADRUPLE, "tolerance": tolerance}, np.array([0.0, DRAWN[name].duration])
    states = HEYOKA_QUADRUPLE.states(start, times, options)[0]
    return states[1].reshape(3, 6)[:, : start.q0.shape[1]]


@lru_cache
def draws(name: str) -> Draws:
    """The contents of a file."""
    first = _start(name, 0)
    lines = (FOLDER / f"{name}.csv").read_text("ascii").splitlines()
    rows = np.array([line.split(",") for line in lines if not line.startswith(("#", "x"))], float)
    parts = rows.reshape(-1, 3, *first.q0.shape).transpose(1, 0, 2, 3)
    return Draws(first, *(read_only(part.copy()) for part in parts))


if __name__ == "__main__":
    for asked in sys.argv[1:] or DRAWN:
        (FOLDER / f"{asked}.csv").write_text(table(asked), encoding="ascii")
        print(f"wrote references/stored/data/{asked}.csv")
