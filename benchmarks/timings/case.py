"""A run to be timed, as plain data: another process, with another revision, can build it too."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

STEP, TRAJECTORY, ROUND_OFF = "step", "trajectory", "round-off"
DISCRETE, ROUNDED = 0.01, 3.0  # tolerances of an error, see Case


@dataclass(frozen=True)
class Case:
    """A run of galvi that is repeated, counted and compared with the truth.

    name       unique, for tables and command lines
    kind       STEP: what a caller waits for; TRAJECTORY: many steps; ROUND_OFF: so many that the
               error is that of rounding, as its RMS over several starts
    problem    of galvi.problems, called with the arguments
    degree     of the polynomials
    points     of the rule, the name of a function of galvi
    chart      the name of a class of galvi on groups, "" for the default
    step, steps  of the run, of which only the ends are kept
    truth      the name of a reference; "" where none is known
    truth_tolerance  its tolerance, 0.0 for its default
    starts     runs, from configurations that differ by some 1e-3
    quick      whether it is among the few that a quick bench and a quick comparison take
    error_tolerance  relative growth of the error that is no alarm: little where the discretisation
               makes the error, a factor where rounding does
    rounding   an error below this is rounding, of the run or of the truth, and no alarm
    count_tolerance  the same of each count; 0, since counts are exact on one build and machine
    slower     relative growth of the median time that an alarm needs besides the rank test
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
    error_tolerance: float = DISCRETE
    rounding: float = 1e-13
    count_tolerance: float = 0.0
    slower: float = 0.10
