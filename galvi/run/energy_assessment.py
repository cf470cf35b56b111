"""Assesses the energy of a run: one evaluator for equal steps and clocks, with forces and without.

Where the forces have a potential, the energy of each sample is that of the start. Where the work of
other forces since then is known, as in a clock, which integrates it along the run, it is that much
more. Where it is known in some steps alone (galvi.run.work_of_forces), these are assessed.

The measure of an error since the start is the larger of the kinetic energy at the start and the
range of the potential energy over the samples up to the last good one, whose error is below 1 % of
that measure; where forces do work, also the kinetic energy there and their work. So a fall of any
depth is measured by its depth, but a run that goes astray not by where it went: a sample whose
error exceeds the measure of those before it is not good. If none is good and the run starts at
rest, the measure is the kinetic energy that the force at the start gives in a step, or the
potential energy that is lost on that way if it is less, since a coarse step may come to rest again.
A run is ruined by steps whose error exceeds its measure. What a change of the position by its
round-off would do to the energy is not an error.

The thresholds, each with one name:

TOLERATED  1 %, of the measure, above which an error is reported; a run is ruined from 100 % on
ROUND_OFF  2^-40 of |T| + |V|: the rounding of their sum, after many steps
NUDGE, NUDGE_AT_REST  of galvi.run.energies: the rounding of a position, and its growth from rest
CLOSE      of galvi.run.energies: 3 %, the error of a velocity whose energy is known to 0.1 %
REST       1e-9 of what a step gives, below which a kinetic energy is none

They were chosen, and hold where they were tried: right runs are called good, and planted faults are
found, in tests/galvi/test_ruined_runs.py and test_work_of_forces.py, and in clocks with forces in
test_energy_in_a_clock.py.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np

from galvi.arrays import Array, read_only
from galvi.checkpoint import NOTHING
from galvi.kernels.energy_errors import MEASURE, ROUND_OFF, TOLERATED, WORST, measure_errors
from galvi.problem import Problem
from galvi.run.energies import Raised, Start, States, energies, kick_energy, noise, start_energies

REST = 1e-9


class Samples(NamedTuple):
    """Some states of a run.

    steps   (n,) numbers of the steps that end there, since the problem's start
    states  n of them, with their times
    energy  (n,) what it should be, of L or V alone: that of the start and the work of all forces
            since then; None: there are none but such with a potential, whose energy counts
    """

    steps: Any
    states: States
    energy: Array | None = None

    def rows(self, rows: Any) -> Samples:
        """Some of them."""
        states = States(*(part[rows] for part in self.states))
        return Samples(self.steps[rows], states, None if self.energy is None else self.energy[rows])


class EnergyReport(NamedTuple):
    """What the energies say of a run.

    error       largest error of the energy so far, over its measure
    measure     that measure
    worst       number of the step where it is, since the problem's start
    ruined      number of the first step seen to be ruined; None: none is
    unknown     whether the energy is not a number at some step; if it was one at the start, such a
                step is ruined
    energies    (4,) of the steps so far, for `Checkpoint`: least and greatest potential energy,
                measure, largest error
    unassessed  why the energy of some steps is not known, as a clause; "" where that of all is
    clauses     what else is wrong
    remedy      for these; "": that of `galvi.run.status`
    """

    error: float = 0.0
    measure: float = 0.0
    worst: int | None = None
    ruined: int | None = None
    unknown: bool = False
    energies: Array = NOTHING
    unassessed: str = ""
    clauses: tuple[str, ...] = ()
    remedy: str = ""

    @property
    def is_doubtful(self) -> bool:
        """Whether an error is to be reported."""
        return not self.error <= TOLERATED or self.unknown


class EnergyErrors(NamedTuple):
    """Errors of the energy: at n samples since the start, or in n ``single`` steps.

    steps      (n,) numbers of the steps at whose ends they are
    errors     (n,)
    ruining    (n,) the part of an error that ruins a run if it exceeds the measure
    sizes      (n,) by which an error is measured, if they exceed the range of V
    lowest, highest  (n,) V
    round_off  (n,) errors up to which are none
    """

    steps: Any
    errors: Array
    ruining: Array
    sizes: Array
    lowest: Array
    highest: Array
    round_off: Array
    single: bool = False


def assess_energy(
    problem: Problem,
    samples: Samples,
    so_far: Array,
    step: float,
    kept_before: Callable[[int], Samples] | None = None,
    named_after: int = 0,
) -> EnergyReport:
    """The report on a run so far.

    so_far       `Checkpoint.energies` of the steps before the samples; empty before the first
    step         the first one, in time
    kept_before  (a ruined step) -> further samples before it, among which the first ruined one is
                 looked for
    named_after  how many steps precede the run that a sentence counts

    Samples at which the user's functions raise are left out, and ``unassessed`` names the first.
    """
    if len(samples.steps) == 0:
        return EnergyReport(energies=so_far)
    with np.errstate(all="ignore"):
        try:
            start = start_energies(problem, forces=samples.energy is None)
        except Exception as error:
            return EnergyReport(energies=so_far, unassessed=raised_at(error, 0))
        report = _assess(problem, samples, so_far, start, named_after)
        if not report.is_doubtful:
            return report
        try:
            excused = noise(problem), kick_energy(problem, step)
        except Exception as error:
            return EnergyReport(energies=so_far, unassessed=raised_at(error, 0))
        report = _assess(problem, samples, so_far, start, named_after, excused)
        if not report.ruined or kept_before is None:
            return report
        between = kept_before(report.ruined)
        off = np.abs(_excess(problem, between, start, True, {})[0])
        ruined = between.steps[off > max(report.measure, excused[0])]
        return report._replace(ruined=int(ruined[0])) if ruined.size else report


def _excess(
    problem: Problem, samples: Samples, start: Start, sharp: bool, raised: Raised
) -> tuple[Array, Array, Array]:
    """H less what it should be, T and V, (n,) each."""
    kinetic, potential = energies(
        problem, samples.states, sharp, raised, forces=samples.energy is None
    )
    expected = start.total if samples.energy is None else samples.energy
    return kinetic + potential - expected, kinetic, potential


def _assess(
    problem: Problem,
    samples: Samples,
    so_far: Array,
    start: Start,
    named_after: int,
    excused: tuple[float, float] | None = None,
) -> EnergyReport:
    """As `assess_energy`.

    excused  errors up to which are round-off, and the kinetic energy that the force at the start
             gives in a step; None: not yet known, and nearly right velocities will do
    """
    raised: Raised = {}
    excess, kinetic, potential = _excess(problem, samples, start, excused is not None, raised)
    unassessed = ""
    if raised:
        first = min(raised)
        unassessed = raised_at(raised[first], int(samples.steps[first]) - named_after)
        rows = np.array([k for k in range(len(excess)) if k not in raised], dtype=np.int64)
        if not rows.size:
            return EnergyReport(energies=so_far, unassessed=unassessed)
        samples = samples.rows(rows)
        excess, kinetic, potential = (part[rows] for part in (excess, kinetic, potential))
    errors, sizes = np.abs(excess), np.full(len(excess), start.kinetic)
    if samples.energy is not None:
        work = samples.energy - start.total
        sizes = np.fmax(sizes, np.fmax(np.abs(kinetic), np.abs(work)))
    lost = np.isnan(errors) & np.isfinite(start.total)
    since_start = EnergyErrors(
        samples.steps,
        errors,
        np.where(lost, np.inf, errors),
        sizes,
        potential,
        potential,
        ROUND_OFF * (np.abs(kinetic) + np.abs(potential)),
    )
    so_far = so_far if so_far.size else start.fresh
    report = report_on(since_start, so_far, start.kinetic, *(excused or (0.0, 0.0)))
    return report._replace(unassessed=unassessed)


def assess_steps(
    problem: Problem, step_errors: EnergyErrors, so_far: Array, step: float
) -> EnergyReport:
    """The report on errors of single steps after the steps ``so_far``; what the user's functions
    raise passes through."""
    start = start_energies(problem, forces=True)
    so_far = so_far if so_far.size else start.fresh
    report = report_on(step_errors, so_far, start.kinetic)
    if report.is_doubtful:
        excused = noise(problem), kick_energy(problem, step)
        report = report_on(step_errors, so_far, start.kinetic, *excused)
    return report


@np.errstate(all="ignore")
def report_on(
    energy_errors: EnergyErrors,
    so_far: Array,
    kinetic: float,
    floor: float = 0.0,
    kick: float = 0.0,
) -> EnergyReport:
    """The report on errors after the steps ``so_far``.

    kinetic  energy at the start
    floor    errors up to which are round-off
    kick     kinetic energy that the forces at the start give in a step
    """
    steps, errors, ruining, sizes, lowest, highest, round_off, single = energy_errors
    if not len(steps):
        ruined_before = bool(so_far[WORST] > so_far[MEASURE])
        return EnergyReport(energies=so_far, ruined=0 if ruined_before else None)
    errors, after = errors.copy(), so_far.copy()
    largest, measures = np.empty((2, len(errors)))
    measure_errors(
        errors,
        np.fmax(round_off, floor),
        sizes,
        np.ascontiguousarray(lowest),
        np.ascontiguousarray(highest),
        single,
        after,
        largest,
        measures,
    )
    measure, before = float(after[MEASURE]), float(so_far[WORST])
    if single:
        measures = np.maximum(measures, kick if kinetic <= REST * kick else 0.0)
    else:
        measure = kick if measure <= kinetic <= REST * kick else measure
        largest[:] = measures[:] = measure
        after[WORST] = np.fmax(np.fmax.reduce(errors), before)
    ruins = np.flatnonzero((ruining > measures) & ~(errors <= TOLERATED * largest))
    k = int(np.argmax(np.where(errors > 0.0, errors / largest, 0.0)))
    error, limit = (errors[k], largest[k]) if single else (after[WORST], measure)
    if single and ruins.size:
        k, after[WORST] = int(ruins[0]), np.inf
        error, limit = errors[k], measures[k]
    ruined = int(steps[ruins[0]]) if ruins.size else None
    return EnergyReport(
        0.0 if error == 0.0 else float(error / limit) if limit > 0.0 else np.inf,
        measure,
        int(steps[k]),
        0 if before > measure else ruined,
        bool(np.isnan(errors).any()),
        read_only(after),
    )


def raised_at(error: Exception, step: int) -> str:
    return f"at step {step}, where it raised {in_words(error)}"


def in_words(error: Exception) -> str:
    """The kind of an exception, and its message on one line."""
    reason = " ".join(str(error).split())
    return f"{type(error).__name__}{': ' if reason else ''}{reason}"
