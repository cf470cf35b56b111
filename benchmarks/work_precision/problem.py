"""Work-precision problems: what is solved, how long, by whom with which settings, the truth."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from galvi import Problem
from galvi.arrays import Array
from references import Contender

Setting = Mapping[str, Any]
POSITION, ATTITUDE, ANGLE = "position", "attitude", "angle"
EPS = float(np.finfo(float).eps)


class Participant(NamedTuple):
    """A contender with its label and the settings that it is run with."""

    label: str
    contender: Contender
    settings: Sequence[Setting]


@dataclass(frozen=True, eq=False)
class Truth:
    """The true configuration at the end.

    end          (...,) in the configuration's shape
    error        of it, as `WorkPrecisionProblem.distance` measures errors
    description  for the table
    source       label of the contenders that it comes from, which are not judged by it
    """

    end: Array
    error: float
    description: str
    source: str = ""

    def is_from(self, contender: str) -> bool:
        """Whether the contender would be compared with itself."""
        return bool(self.source) and contender.startswith(self.source)


def farthest_body(q: Array, truth: Array) -> float:
    """Largest distance of a body from where it should be, in the problem's unit of length."""
    return float(np.max(np.linalg.norm(q - truth, axis=-1)))


@dataclass(frozen=True, eq=False)
class WorkPrecisionProblem:
    """One work-precision study.

    problem       what is solved
    duration      from its t0, in its unit of time
    participants  who solves it
    truth         computes the truth
    quantity      whose error it is: POSITION, ATTITUDE or ANGLE
    distance      of two configurations: the error
    repeated_run  whether runs are timed by going on, as `benchmarks.statistics.repeated_run` does:
                  for durations that a contender covers before its call has properly begun
    """

    problem: Problem
    duration: float
    participants: tuple[Participant, ...]
    truth: Callable[[], Truth]
    quantity: str = POSITION
    distance: Callable[[Array, Array], float] = farthest_body
    repeated_run: bool = False


def galvi_label(stages: int) -> str:
    """Of polynomials of this degree with as many Gauss points."""
    return f"galvi degree {stages}, Gauss {stages}"


def fixed(duration: float, steps: int) -> Setting:
    """So many equal steps, of which the last state is kept."""
    return {"step": duration / steps, "save_every": steps}


def adaptive(key: str, values: Sequence[float]) -> list[Setting]:
    """One setting for each value of this key; the last state is kept."""
    return [{"samples": 1, key: value} for value in values]
