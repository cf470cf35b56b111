"""A run to be compared, as plain data, so that a process with another revision can run it too."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

STEP, TRAJECTORY, ROUND_OFF, LONG = "step", "trajectory", "round-off", "long"
UNTIMED = (ROUND_OFF, LONG)
DISCRETISATION_TOLERANCE, ROUNDING_TOLERANCE = 0.01, 3.0  # tolerances for an error, see Case
ROUNDING_GROWTH = 1e-13  # tolerated absolute growth of an error, of a motion of size 1


@dataclass(frozen=True)
class Thresholds:
    """Growths of times and errors of an integrator that count as worse; see `Case`.

    Attributes
    ----------
    slower
        relative growth of a median time; for several benchmarks together half of it
    less_accurate
        relative growth of an error
    """

    slower: float = 0.10
    less_accurate: float = DISCRETISATION_TOLERANCE


@dataclass(frozen=True)
class Case:
    """A run of galvi, or of another integrator: its counts, and its error where a truth is named.

    It is timed unless its kind is in UNTIMED.

    Attributes
    ----------
    name
        unique, for tables and command lines
    kind
        STEP: one call; TRAJECTORY: many steps; ROUND_OFF: so many steps that rounding dominates the
        error, given as RMS over `starts` runs; LONG: one run of many steps, whose end is compared
    problem, arguments
        name of a function in galvi.problems, and its arguments
    degree
        degree of the polynomials
    points, rule
        number of points of the rule, and the name of the function of galvi that makes it
    chart
        name of a chart class of galvi, on groups or a frame, "" for the default
    step, steps
        step size, in the problem's unit of time, and number of steps; only the ends are kept
    truth
        name of a reference; "" if there is none
    truth_tolerance
        tolerance of the reference; 0.0 for its default
    starts
        number of runs, from configurations that differ by about 1e-3, relatively
    quick
        whether it belongs to the quick benchmarks and comparisons
    error_tolerance
        tolerated relative growth of the error: 0.01 for discretisation errors; for rounding errors
        3.0, fourfold, or less for the mean over many starts
    rounding
        absolute growth of an error that is tolerated besides, as rounding of the run or the truth
    count_tolerance
        tolerated relative growth of each count; 0, since counts are exact on one build and machine
    slower
        relative growth of the median time required for an alarm besides the rank test
    contender
        "package.module:Class" of another integrator, run at `setting` over step * steps in place of
        galvi's method; see `benchmarks.applications.external.integrator`
    defined_at
        file, from the root of the repository, and line of that class; "" and 0 where not known
    setting
        setting of the contender, see `references.contender`; empty for galvi
    """

    name: str
    kind: str
    problem: str
    degree: int
    points: int
    step: float
    steps: int
    truth: str = ""
    arguments: Mapping[str, Any] = field(default_factory=dict)
    rule: str = "gauss"
    chart: str = ""
    starts: int = 1
    quick: bool = False
    truth_tolerance: float = 0.0
    error_tolerance: float = DISCRETISATION_TOLERANCE
    rounding: float = ROUNDING_GROWTH
    count_tolerance: float = 0.0
    slower: float = Thresholds.slower
    contender: str = ""
    defined_at: tuple[str, int] = ("", 0)
    setting: Mapping[str, Any] = field(default_factory=dict)

    def tolerated(self, error: float) -> float:
        """The largest error that does not count as worse than `error`."""
        return error * (1.0 + self.error_tolerance) + self.rounding
