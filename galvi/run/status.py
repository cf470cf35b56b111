"""The outcome of a run: how it ended, and whether its states can be used."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import cast

import numpy as np

from galvi.kernels.energy_errors import TOLERATED_SHARE, WORST
from galvi.kernels.nystrom.solve import SOLVED
from galvi.outcome import End, Outcome
from galvi.problem import Problem
from galvi.run.energies import conserves_energy
from galvi.run.energy_assessment import EnergyReport
from galvi.run.point_masses import encounters
from galvi.run.stepper import Formulation, Stepper
from galvi.systems.lagrangian import Lagrangian

MEASURE = "the larger of the kinetic energy at the start and the range of the potential energy"
SMALLER_STEP = "Use a smaller step or a higher degree"
EstimateMasslessError = Callable[[], encounters.MasslessError | None]


def outcome_of(
    stepper: Stepper,
    code: int,
    report: EnergyReport,
    counts: Mapping[str, int],
    massless: EstimateMasslessError,
) -> Outcome:
    """The outcome of a run in equal steps whose last kernel call returned ``code``.

    Parameters
    ----------
    report
        the assessment of its energy
    massless
        () -> the error of massless bodies; called for a completed run without other clauses
    """
    request, work = stepper.request, stepper.work
    problem, step, steps = request.problem, request.step, cast(int, request.steps)
    if work.steps_done < steps:
        end, reason = End.INTERRUPTED, ""
        if code != SOLVED:
            end, reason = End.STEP_FAILED, stepper.failure(code).removesuffix(".")
        t = problem.t0 + (request.checkpoint.first + work.steps_done) * step
        notes = notes_on_energy(report, request.checkpoint.first, lambda k: problem.t0 + k * step)
        return Outcome(end, work.steps_done + 1, t, reason, notes, steps)
    passage = encounters.unresolved_passage(problem, step, work.passage, request.method.in_frame)
    remedy = SMALLER_STEP
    if passage and encounters.needs_clock(problem, step, work.passage):
        remedy = encounters.USE_CLOCK
    return outcome_of_completed(
        problem,
        report,
        request.checkpoint.first,
        passage,
        massless,
        remedy,
        steps,
        notes_on_second_kernel(stepper.formulation, counts),
    )


def notes_on_second_kernel(formulation: Formulation, counts: Mapping[str, int]) -> tuple[str, ...]:
    """A note on the number of steps that the second kernel did; () for none."""
    name, text = formulation.in_other_way
    return (text.format(left=counts[name], steps=counts["steps"]),) if name in counts else ()


def outcome_of_completed(
    problem: Problem,
    report: EnergyReport,
    first: int,
    passage: str,
    massless: EstimateMasslessError,
    remedy: str = SMALLER_STEP,
    steps: int | None = None,
    second_kernel_notes: tuple[str, ...] = (),
) -> Outcome:
    """The outcome of a run that did all its steps.

    Parameters
    ----------
    first
        number of steps from the problem's start to the start of this run
    passage
        a clause on the worst unresolved passage of two point masses; "" for none
    massless
        as for `outcome_of`
    remedy
        the remedy where the report has none
    steps
        number of requested steps; None for a run to a time
    exceptions
        notes for a run without clauses and with a known energy
    """
    clauses = _error_clauses(report)
    if report.unknown:
        undefined = "the energy is not a number"
        if isinstance(problem.system, Lagrangian) and conserves_energy(problem.system):
            undefined += ": L is undefined there, or no velocity has the momentum"
        clauses.append(undefined)
    clauses += [passage] if passage else []
    clauses = clauses or massless_clauses(problem, massless())
    unassessed = f"energy could not be assessed {report.unassessed}" if report.unassessed else ""
    if not clauses:
        return (
            Outcome(End.DOUBTFUL, reason=f"the {unassessed}", steps=steps)
            if unassessed
            else Outcome(notes=second_kernel_notes, steps=steps)
        )
    if not report.remedy and _has_derivatives(problem):
        remedy += ", and check that the derivatives are those of the energy"
    reason, remedy = "; ".join(clauses), report.remedy or remedy
    notes = (f"The {unassessed}.",) if unassessed else ()
    if report.ruined is not None:
        ruined = max(report.ruined - first, 1)
        return Outcome(End.RUINED, ruined, None, reason, notes, steps, remedy)
    if not report.any_step:
        reason += ": the step is too large for this motion"
    return Outcome(End.DOUBTFUL, None, None, reason, notes, steps, remedy)


def notes_on_energy(
    report: EnergyReport, first: int, time_of: Callable[[int], float]
) -> tuple[str, ...]:
    """Notes on the energy of a run that ended early.

    Parameters
    ----------
    first
        number of steps from the problem's start to the start of this run
    time_of
        (number of a step since the problem's start) -> the time at which it ends
    """
    notes = []
    if report.ruined is not None:
        t = time_of(max(report.ruined, first + 1))
        notes.append(f"It was ruined from t = {t:.10g} on: {'; '.join(_error_clauses(report))}.")
    if report.unassessed:
        notes.append(f"Its energy could not be assessed {report.unassessed}.")
    return tuple(notes)


def _error_clauses(report: EnergyReport) -> list[str]:
    """Clauses on the defects of a run: the error of its energy, and those of the report."""
    return [*([_energy_clause(report)] if report.error > TOLERATED_SHARE else []), *report.clauses]


def _energy_clause(report: EnergyReport) -> str:
    change, measure = "the energy changed", MEASURE
    if report.driven:
        change, measure = "the energy and the work of the forces differ", "the largest energy"
    if np.isfinite(report.error):
        return f"{change} by {report.error:.2g} times {measure}"
    return (
        f"{change} by {report.energies[WORST]:.2g}, and no step kept it to "
        f"{TOLERATED_SHARE:g} times {measure}"
    )


def massless_clauses(problem: Problem, error: encounters.MasslessError | None) -> list[str]:
    """A clause on the massless body whose energy a step changes most, if by more than
    RESOLVED_ENERGY_CHANGE; [] otherwise."""
    if error is None or not error.share > encounters.RESOLVED_ENERGY_CHANGE:
        return []
    body = encounters.body_names(problem, len(problem.q0))[error.body]
    return [
        f"a step changes the energy of the massless body {body} by about {error.share:.1g} of "
        f"v^2 / 2 + G M / r (an estimate, from {error.states} of the steps)"
    ]


def _has_derivatives(problem: Problem) -> bool:
    """Whether the user gave derivatives, which may contradict the energy."""
    derivatives = (getattr(problem.system, name, None) for name in ("gradient", "slopes"))
    return any(function is not None for function in derivatives)
