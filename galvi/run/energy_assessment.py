"""Assesses the energy of a run: one evaluator for equal steps and clocks, with forces and without.

Where all forces have a potential, each sample should have the energy of the start. Where the work
of other forces since the start is known, as in a clock, which integrates it along the run, the
energy should have grown by that work. Where the work is known only in some steps
(galvi.run.work_of_forces), the errors of these steps are assessed.

The measure of an error since the start is the larger of the kinetic energy at the start and the
range of the potential energy over the samples up to the last good one, whose error is at most 1 %
of that measure; where forces do work, also the kinetic energy at these samples and the work. So a
fall of any depth is measured by its depth, but a run that goes astray is not measured by the states
it reaches: a sample whose error exceeds the measure of those before it is not good. If no sample is
good and the run starts at rest, the measure is the kinetic energy that the forces at the start give
in a step, see `galvi.run.energies.kick_energy`. A run is ruined by steps whose error exceeds its
measure. A change of the energy that a change of the position by its round-off would cause is not an
error.

The thresholds, each with one name:

TOLERATED           1 %, of the measure, above which an error is reported; a run is ruined from
                    100 % on
ENERGY_ROUND_OFF    2^-40 of |T| + |V|: the rounding of their sum, after many steps
POSITION_CHANGE, POSITION_CHANGE_AT_REST
                    of galvi.run.energies: the rounding of a position, and its growth from rest
MOMENTUM_TOLERANCE  of galvi.run.energies: 3 %, the error of a velocity whose energy is known to
                    0.1 %
REST_SHARE          1e-9 of what a step gives, below which a kinetic energy is none

They were chosen, and hold where they were tried: right runs are called good, and planted faults are
found, in test_ruined_runs.py and test_work_of_forces.py of tests/properties, and in clocks with
forces in test_energy_in_a_clock.py.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np

from galvi.arrays import Array, read_only
from galvi.checkpoint import NOTHING
from galvi.kernels.energy_errors import (
    ROWS,
    TOLERATED_SHARE,
    WORST,
    assess_errors,
    errors_since_start,
)
from galvi.problem import Problem
from galvi.run.energies import (
    Raised,
    Start,
    States,
    energies,
    energy_of_position_error,
    kick_energy,
    start_energies,
)


class Samples(NamedTuple):
    """n states of a run at which its energy is assessed.

    Attributes
    ----------
    steps : array, shape (n,)
        numbers of the steps that end there, since the problem's start
    states
        the states, with their times
    energy : array, shape (n,)
        expected energies without those of forces: that of the start plus the work of all forces
        since then; None where every force has a potential, whose energy is included
    """

    steps: Any
    states: States
    energy: Array | None = None

    def rows(self, rows: Any) -> Samples:
        """The samples at these rows."""
        states = States(*(part[rows] for part in self.states))
        return Samples(self.steps[rows], states, None if self.energy is None else self.energy[rows])


class EnergyReport(NamedTuple):
    """The assessment of a run by its energies.

    Attributes
    ----------
    error
        largest error of the energy, over its measure
    measure
        the measure of errors
    worst
        number of the step with the largest error, since the problem's start
    ruined
        number of the step of the first ruined sample; 0 where an earlier part of a continued run
        was ruined; None without one
    unknown
        whether the energy is NaN at a sample; if it was finite at the start, such a sample is
        ruined
    energies : array, shape (4,)
        for `Checkpoint`, of all steps since the problem's start: least and greatest potential
        energy, measure, largest error
    unassessed
        a clause on where and why the energy could not be evaluated; "" where it could
    driven
        whether the error is that of the energy less the work of all forces since the start
    clauses
        clauses on other defects of the run
    remedy
        what to do about these; "" for the remedy of `galvi.run.status`
    any_step
        whether the defect remains for smaller steps
    """

    error: float = 0.0
    measure: float = 0.0
    worst: int | None = None
    ruined: int | None = None
    unknown: bool = False
    energies: Array = NOTHING
    unassessed: str = ""
    driven: bool = False
    clauses: tuple[str, ...] = ()
    remedy: str = ""
    any_step: bool = False

    @property
    def is_doubtful(self) -> bool:
        """Whether the error exceeds TOLERATED, or an energy is NaN."""
        return not self.error <= TOLERATED_SHARE or self.unknown


def assess_energy(
    problem: Problem,
    samples: Samples,
    so_far: Array,
    step: Callable[[], float],
    kept_before: Callable[[int], Samples] | None = None,
) -> EnergyReport:
    """The energy report of a run.

    Parameters
    ----------
    so_far
        `Checkpoint.energies` of the steps before the samples; empty before the first
    step
        () -> length of the first step, in time
    kept_before
        (number of a ruined step) -> further samples up to it; the first ruined one among them
        becomes ``ruined``

    Notes
    -----
    Samples at which the user's functions raise are left out, and ``unassessed`` names the first.
    """
    if len(samples.steps) == 0:
        return EnergyReport(energies=so_far)
    with np.errstate(all="ignore"):
        try:
            start = start_energies(problem, include_forces=samples.energy is None)
        except Exception as error:
            return EnergyReport(energies=so_far, unassessed=clause_of_exception(error, problem.t0))
        report = _assess(problem, samples, so_far, start)
        if not report.is_doubtful:
            return report
        try:
            excused = energy_of_position_error(problem), kick_energy(problem, step())
        except Exception as error:
            return EnergyReport(energies=so_far, unassessed=clause_of_exception(error, problem.t0))
        report = _assess(problem, samples, so_far, start, excused)
        if not report.ruined or kept_before is None:
            return report
        between = kept_before(report.ruined)
        kinetic, potential = energies(
            problem, between.states, solve_velocities=True, raised={}, include_forces=True
        )
        errors = np.abs(kinetic + potential - start.total)
        ruined = between.steps[errors > max(report.measure, excused[0])]
        return report._replace(ruined=int(ruined[0])) if ruined.size else report


def _assess(
    problem: Problem,
    samples: Samples,
    so_far: Array,
    start: Start,
    excused: tuple[float, float] | None = None,
) -> EnergyReport:
    """The energy report, with or without excused errors.

    Parameters
    ----------
    excused
        the largest error that is round-off, and the kinetic energy that the forces at the start
        give in a step; None: nothing is excused, and nearly right velocities suffice
    """
    raised: Raised = {}
    kinetic, potential = energies(
        problem, samples.states, excused is not None, raised, include_forces=samples.energy is None
    )
    unassessed = ""
    if raised:
        first = min(raised)
        unassessed = clause_of_exception(raised[first], float(samples.states.t[first]))
        rows = np.array([k for k in range(len(kinetic)) if k not in raised], dtype=np.int64)
        if not rows.size:
            return EnergyReport(energies=so_far, unassessed=unassessed)
        samples, kinetic, potential = samples.rows(rows), kinetic[rows], potential[rows]
    expected = np.array([start.total]) if samples.energy is None else samples.energy
    so_far, table = so_far if so_far.size else start.fresh, np.empty((ROWS, len(kinetic)))
    kinetic, potential = np.ascontiguousarray(kinetic), np.ascontiguousarray(potential)
    errors_since_start(
        kinetic, potential, expected, samples.energy is not None, start.total, start.kinetic, table
    )
    floor, kick = excused or (0.0, 0.0)
    return report_on(
        samples.steps,
        table,
        False,
        so_far,
        start.kinetic,
        floor,
        kick,
        unassessed,
        samples.energy is not None,
    )


def assess_steps(
    problem: Problem, steps: Any, table: Array, so_far: Array, step: float
) -> EnergyReport:
    """The report on the errors of single steps; exceptions of user functions pass through.

    Parameters
    ----------
    steps : array, shape (n,)
        their numbers since the problem's start
    table : array, shape (8, n)
        their errors, see galvi.kernels.energy_errors
    so_far
        `Checkpoint.energies` of the steps before
    step
        length of a step, in time
    """
    start = start_energies(problem, include_forces=True)
    so_far = so_far if so_far.size else start.fresh
    report = report_on(steps, table, True, so_far, start.kinetic)
    if report.is_doubtful:
        excused = energy_of_position_error(problem), kick_energy(problem, step)
        report = report_on(steps, table, True, so_far, start.kinetic, *excused)
    return report


def report_on(
    steps: Any,
    table: Array,
    single: bool,
    so_far: Array,
    kinetic: float,
    floor: float = 0.0,
    kick: float = 0.0,
    unassessed: str = "",
    driven: bool = False,
) -> EnergyReport:
    """The report on a table of errors, see `galvi.kernels.energy_errors.assess_errors`.

    Parameters
    ----------
    unassessed, driven
        as in `EnergyReport`
    """
    energies_after, error_before = so_far.copy(), so_far[WORST]
    relative_error, worst, ruined, unknown, measure = assess_errors(
        table, single, kinetic, floor, kick, energies_after
    )
    first_ruined = int(steps[ruined]) if ruined >= 0 else None
    if error_before > measure:
        first_ruined = 0
    worst_step = int(steps[worst]) if len(steps) else None
    return EnergyReport(
        relative_error,
        measure,
        worst_step,
        first_ruined,
        unknown,
        read_only(energies_after),
        unassessed,
        driven,
    )


def clause_of_exception(error: Exception, time: float) -> str:
    return f"at t = {time:.10g}, where it raised {description_of(error)}"


def description_of(error: Exception) -> str:
    """The type of an exception, and its message on one line."""
    reason = " ".join(str(error).split())
    return f"{type(error).__name__}{': ' if reason else ''}{reason}"
