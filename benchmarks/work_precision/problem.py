"""A work-precision problem: problem, duration, participants with their settings, and truth."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, NamedTuple

import numpy as np

from galvi import Problem
from galvi.arrays import Array
from references import Contender

Setting = Mapping[str, Any]
POSITION, ATTITUDE, ANGLE = "position", "attitude", "angle"
COORDINATES, MOTION = "coordinates", "attitude and place"
# A coarse error needs no solution to round-off: tolerances, and the settings for which they pay.
EARLY_TOLERANCES = {1e-9: slice(2), 1e-12: slice(3), 1e-14: slice(1, None)}
EPS = float(np.finfo(float).eps)


class Participant(NamedTuple):
    """A contender with its label and settings."""

    label: str
    contender: Contender
    settings: Sequence[Setting]


@dataclass(frozen=True, eq=False)
class Truth:
    """The true configuration at the end.

    Attributes
    ----------
    end
        the configuration
    error
        error of the truth itself, measured by `WorkPrecisionProblem.distance`
    description
        text for the table
    source
        label and settings, as text, of the run that is the truth, which is not compared with
        itself; None for a truth that is no run of a participant
    momenta
        momenta at the end; None where they are unknown
    """

    end: Array
    error: float
    description: str
    source: tuple[str, str] | None = None
    momenta: Array | None = None


def farthest_body(q: Array, truth: Array) -> float:
    """Largest distance of a body from its true position, in the problem's unit of length."""
    return float(np.max(np.linalg.norm(q - truth, axis=-1)))


@dataclass(frozen=True, eq=False)
class WorkPrecisionProblem:
    """One work-precision study.

    Attributes
    ----------
    problem
        the problem
    duration
        duration from the problem's t0, in its unit of time
    participants
        contenders with their settings
    truth
        function that returns the truth
    quantity
        quantity of the error: POSITION, ATTITUDE, ANGLE, COORDINATES or MOTION
    distance
        function (configuration, true configuration) that returns the error
    repeated_run
        whether runs are timed by lengthened runs (`benchmarks.statistics.repeated_run`), since they
        are shorter than the overhead of a call
    notes
        label of a participant -> sentence that is added to the status of its rows
    net_time
        whether the overhead of a call is subtracted instead (`benchmarks.statistics.repeated_run`),
        since later parts of a longer run would take another time: in chaotic motion, or where
        coordinates grow that a tolerance is relative to
    """

    problem: Problem
    duration: float
    participants: tuple[Participant, ...]
    truth: Callable[[], Truth]
    quantity: str = POSITION
    distance: Callable[[Array, Array], float] = farthest_body
    repeated_run: bool = False
    net_time: bool = False
    notes: Mapping[str, str] = field(default_factory=dict)


def largest_difference(q: Array, truth: Array) -> float:
    """The largest magnitude of a difference of entries of two configurations."""
    return float(np.max(np.abs(q - truth)))


def galvi_label(stages: int) -> str:
    """The label of polynomials of degree `stages` with as many Gauss points."""
    return f"galvi degree {stages}, Gauss {stages}"


def frame_label(stages: int, passes: int | None) -> str:
    """The label of collocation in the Kepler frame, with `passes` passes for each step; None: until
    converged."""
    return f"galvi Kepler frame, Gauss {stages}{f', {passes} passes' if passes else ''}"


def fixed(duration: float, steps: int) -> Setting:
    """The setting for `steps` equal steps, keeping the last state."""
    return {"step": duration / steps, "save_every": steps}


def stopped_early_too(settings: Sequence[Setting]) -> list[Setting]:
    """The settings, from coarse to fine, and some again with EARLY_TOLERANCES."""
    return [
        *settings,
        *(
            {**setting, "tolerance": stop}
            for stop, part in EARLY_TOLERANCES.items()
            for setting in settings[part]
        ),
    ]


def adaptive(key: str, values: Sequence[float]) -> list[Setting]:
    """One setting for each value of this key, keeping the last state."""
    return [{"samples": 1, key: value} for value in values]
