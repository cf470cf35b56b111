"""Rows and cells of the table of agreement, and the oracles of their runs.

The general kernel is the oracle of every engine that is faster and solves the same equations. A
moving frame, and a clock of light bodies, discretise other equations: their oracle takes short
steps of degree 16 without frame and clock.
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
COMPARED_TIMES = 77  # number of times at which two curves are compared
Oracle = Callable[..., galvi.Trajectory]
# Bounds on the gaps of a row, in units of its `gap_bound`. Velocities are momenta divided by
# masses; slopes of a curve differ by rounding errors divided by a part of a step.
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
    """The run without frame and clock, in eight steps of degree 16 for each `step`.

    With a duration (of a run in a clock), only the last state is also one of the run in the clock.
    """
    if duration is not None:
        short_steps = 8 * math.ceil(duration / abs(step))
        return galvi.integrate(
            problem, FINE, math.copysign(duration / short_steps, step), short_steps, **options
        )
    assert steps is not None
    options = {"save_every": 8, "curves": True} | options
    return galvi.integrate(problem, FINE, step / 8, 8 * steps, **options)


@dataclass(frozen=True)
class Row:
    """A problem and the settings of its runs.

    make      function that returns the problem
    step      size of a step, in units of the clock if there is one
    engine    `galvi.Trajectory.engine` of its runs
    steps     number of steps of a run; None with a duration
    duration  length of a run in a clock, whose last step is shortened; else None
    moving    chart or clock of its methods, by the names of `galvi.Galerkin`
    gap_bound bound on the gaps, in units of ROUND_OFF, see SAME_EQUATIONS
    oracle    function that makes the reference run
    newton    whether the run that is checked uses Newton's method too
    slow      whether `make test` leaves the row out, as its code takes long to compile
    """

    make: Callable[[], galvi.Problem]
    step: float
    engine: str = "lanes"
    steps: int | None = 20
    duration: float | None = None
    moving: Mapping[str, Any] = field(default_factory=dict)
    gap_bound: float = 16.0
    oracle: Oracle = in_general_kernel
    newton: bool = False
    slow: bool = False

    @cached_property
    def problem(self) -> galvi.Problem:
        return self.make()

    @property
    def bounds(self) -> dict[str, float]:
        """Bounds on each of the `gaps`, in units of ROUND_OFF."""
        factors = SAME_MOTION if self.oracle is in_short_steps else SAME_EQUATIONS
        return {name: factor * self.gap_bound for name, factor in factors.items()}

    def by_gauss(self, degree: int, points: int | None = None, **moving: Any) -> Cell:
        """The cell with polynomials and Gauss's rule, by default of `degree` points."""
        space, rule = galvi.Polynomials(degree), galvi.gauss(points or degree)
        return self.by_method(space, rule, **moving)

    def by_method(self, space: Any, rule: galvi.Rule, **moving: Any) -> Cell:
        return Cell(self, galvi.Galerkin(space, rule, **{**self.moving, **moving}), self.step)


@dataclass(frozen=True)
class Cell:
    """A row with a method and a step size."""

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

    def reference(self, **options: Any) -> galvi.Trajectory:
        row = self.row
        return row.oracle(
            row.problem, self.method, self.step, row.steps, duration=row.duration, **options
        )

    def backwards(self) -> Cell:
        return replace(self, step=-self.step)

    def with_problem(self, problem: galvi.Problem) -> Cell:
        """The same cell of another problem."""
        return replace(self, row=replace(self.row, make=lambda: problem))


def relative_gap(values: Any, reference: Any) -> float:
    """Largest difference, relative to the reference's largest entry, in units of ROUND_OFF."""
    size = np.max(np.abs(reference)) or 1.0
    return float(np.max(np.abs(values - reference)) / size / ROUND_OFF)


def gaps(run: galvi.Trajectory, reference: galvi.Trajectory) -> dict[str, float]:
    """Gaps between two runs: at all states if their numbers agree, else at the last; and on curves.

    joints  gap between the curves of `run` and its own states
    """
    rows: Any = slice(None) if len(run.t) == len(reference.t) else [-1]
    times = np.linspace(run.t[0], run.t[-1], COMPARED_TIMES)
    times = np.clip(times, *sorted(reference.t[[0, -1]]))
    states = {
        name: relative_gap(getattr(run, name)[rows], getattr(reference, name)[rows])
        for name in "qpvt"
    }
    return states | {
        "joints": relative_gap(run(run.t), run.q),
        "curves": relative_gap(run(times), reference(times)),
        "slopes": relative_gap(run.velocity(times), reference.velocity(times)),
    }


def excessive_gaps(
    run: galvi.Trajectory, reference: galvi.Trajectory, row: Row
) -> dict[str, float]:
    """The gaps that exceed the bounds of the row."""
    return {name: gap for name, gap in gaps(run, reference).items() if not gap <= row.bounds[name]}


def check(cell: Cell) -> None:
    """Assert that the row's engine did the run, no step left to Newton, and the oracle agrees."""
    run, reference, row = cell.run(), cell.reference(), cell.row
    assert run.success and reference.success, (run.status, reference.status)
    assert run.engine == row.engine, run.engine
    assert row.steps is None or run.counts["steps"] == row.steps, run.counts
    assert run.counts["steps"] <= run.counts["iterations"], run.counts
    assert run.counts["iterations"] <= run.counts["force_evaluations"], run.counts
    assert (run.counts["linear_solves"] > 0) is row.newton, run.counts
    assert not {"newton_steps", "inertial_steps"} & run.counts.keys(), run.counts
    if row.oracle is in_general_kernel:
        assert reference.engine in ("general", "clock") and reference.counts["linear_solves"] > 0
    assert not excessive_gaps(run, reference, row), excessive_gaps(run, reference, row)
