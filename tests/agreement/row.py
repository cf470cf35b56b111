"""A row of the table of agreement, a cell of it, and the oracles of its runs.

The general kernel is the oracle of every engine that is faster and solves the same equations. A
moving frame, and a clock in which a body is light, solve other ones: their oracle is short steps of
degree 16 without frame and clock.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any

import numpy as np

import galvi

ROUND_OFF = 2.0**-52
FINE = galvi.Galerkin(galvi.Polynomials(16), galvi.gauss(16))
TIMES = 77  # at which two curves are compared
Oracle = Callable[..., galvi.Trajectory]
# Bounds on the gaps of a row, in units of its `close`. Velocities are momenta divided by masses;
# slopes of a curve differ by as much as rounding does over a part of a step.
SAME_EQUATIONS = {"q": 1, "p": 1, "v": 2, "t": 1, "joints": 1, "curves": 1, "slopes": 4}
# A light body's momentum is rounded with that of the heaviest. The curve of a step in a frame has
# the order s, not 2 s.
SAME_MOTION = {**SAME_EQUATIONS, "p": 40, "curves": 64, "slopes": 40_000}


def in_general_kernel(
    problem: galvi.Problem, method: galvi.Galerkin, step: float, steps: int | None, **options: Any
) -> galvi.Trajectory:
    """The run by the general kernel, which alone has Newton's method."""
    return galvi.integrate(problem, method, step, steps, **{**options, "solver": "newton"})


def in_short_steps(
    problem: galvi.Problem,
    method: galvi.Galerkin,
    step: float,
    steps: int | None,
    duration: float | None = None,
    **options: Any,
) -> galvi.Trajectory:
    """The motion without frame and clock, by eight steps of degree 16 for each.

    With a duration, of a run in a clock, the end alone is a state of both.
    """
    if duration is not None:
        many = 8 * math.ceil(duration / abs(step))
        return galvi.integrate(problem, FINE, math.copysign(duration / many, step), many, **options)
    assert steps is not None
    options = {"save_every": 8, "curves": True} | options
    return galvi.integrate(problem, FINE, step / 8, 8 * steps, **options)


@dataclass(frozen=True)
class Row:
    """A problem and how it is run.

    make      returns the problem
    step      size of a step, in units of the clock if there is one
    engine    `galvi.Trajectory.engine` of its runs
    steps     number of steps of a run; None with a duration
    duration  of a run in a clock, whose last step is shortened
    moving    chart or clock of its methods, by the names of `galvi.Galerkin`
    close     bound on the gaps, in units of ROUND_OFF, see SAME_EQUATIONS
    oracle    what the runs are compared with
    newton    whether the fast run needs Newton's method too
    slow      whether `make test` leaves it out, as its code takes long to compile
    """

    make: Callable[[], galvi.Problem]
    step: float
    engine: str = "lanes"
    steps: int | None = 20
    duration: float | None = None
    moving: Mapping[str, Any] = field(default_factory=dict)
    close: float = 16.0
    oracle: Oracle = in_general_kernel
    newton: bool = False
    slow: bool = False

    @cached_property
    def problem(self) -> galvi.Problem:
        return self.make()

    @property
    def bounds(self) -> dict[str, float]:
        """On each of the `gaps`."""
        shares = SAME_MOTION if self.oracle is in_short_steps else SAME_EQUATIONS
        return {name: share * self.close for name, share in shares.items()}

    def by(self, degree: int, points: int | None = None, **moving: Any) -> Cell:
        """The cell of polynomials of a degree and a rule of Gauss; as many points by default."""
        space, rule = galvi.Polynomials(degree), galvi.gauss(points or degree)
        return self.by_method(space, rule, **moving)

    def by_method(self, space: Any, rule: galvi.Rule, **moving: Any) -> Cell:
        return Cell(self, galvi.Galerkin(space, rule, **{**self.moving, **moving}), self.step)


@dataclass(frozen=True)
class Cell:
    """A row by one method, in steps of one size."""

    row: Row
    method: galvi.Galerkin
    step: float

    @property
    def problem(self) -> galvi.Problem:
        return self.row.problem

    def run(self, **options: Any) -> galvi.Trajectory:
        return galvi.integrate(
            self.problem,
            self.method,
            self.step,
            self.row.steps,
            **{"duration": self.row.duration, **options},
        )

    def truth(self, **options: Any) -> galvi.Trajectory:
        row = self.row
        return row.oracle(
            row.problem, self.method, self.step, row.steps, duration=row.duration, **options
        )

    def backwards(self) -> Cell:
        return replace(self, step=-self.step)

    def of(self, problem: galvi.Problem) -> Cell:
        """The same run of another problem."""
        return replace(self, row=replace(self.row, make=lambda: problem))


def relative_gap(values: Any, truth: Any) -> float:
    """The largest difference, relative to the largest entry of the truth, in units of ROUND_OFF."""
    size = np.max(np.abs(truth)) or 1.0
    return float(np.max(np.abs(values - truth)) / size / ROUND_OFF)


def gaps(run: galvi.Trajectory, truth: galvi.Trajectory) -> dict[str, float]:
    """How far two runs are apart: in the states that both have, else at the end, and on curves.

    joints  how far the curves of the first pass from its states
    """
    rows: Any = slice(None) if len(run.t) == len(truth.t) else [-1]
    times = np.linspace(run.t[0], run.t[-1], TIMES)
    times = np.clip(times, *sorted(truth.t[[0, -1]]))
    states = {
        name: relative_gap(getattr(run, name)[rows], getattr(truth, name)[rows]) for name in "qpvt"
    }
    return states | {
        "joints": relative_gap(run(run.t), run.q),
        "curves": relative_gap(run(times), truth(times)),
        "slopes": relative_gap(run.velocity(times), truth.velocity(times)),
    }


def wide(run: galvi.Trajectory, truth: galvi.Trajectory, row: Row) -> dict[str, float]:
    """The gaps that are wider than the row allows."""
    return {name: gap for name, gap in gaps(run, truth).items() if not gap <= row.bounds[name]}


def check(cell: Cell) -> None:
    """AssertionError unless the row's engine did the run, by passes, and the oracle agrees."""
    run, truth, row = cell.run(), cell.truth(), cell.row
    assert run.success and truth.success, (run.status, truth.status)
    assert run.engine == row.engine, run.engine
    assert row.steps is None or run.counts["steps"] == row.steps, run.counts
    assert run.counts["steps"] <= run.counts["iterations"], run.counts
    assert run.counts["iterations"] <= run.counts["force_evaluations"], run.counts
    assert (run.counts["linear_solves"] > 0) is row.newton, run.counts
    assert not {"newton_steps", "inertial_steps"} & run.counts.keys(), run.counts
    if row.oracle is in_general_kernel:
        assert truth.engine in ("general", "clock") and truth.counts["linear_solves"] > 0
    assert not wide(run, truth, row), wide(run, truth, row)
