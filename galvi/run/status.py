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
Massless = Callable[[], encounters.MasslessError | None]


def outcome_of(
    stepper: Stepper,
    code: int,
    report: EnergyReport,
    counts: Mapping[str, int],
    massless: Massless,
) -> Outcome:
    """The outcome of a run in equal steps whose last kernel call returned ``code``.

    Parameters
    ----------
    report
        the assessment of its energy
    massless
        () -> the error of massless bodies; called where all else is well
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
    if passage and encounters.asks_for_a_clock(problem, step, work.passage):
        remedy = encounters.ADAPT
    return completed(
        problem,
        report,
        request.checkpoint.first,
        passage,
        massless,
        remedy,
        steps,
        notes_on_exceptions(stepper.formulation, counts),
    )


def notes_on_exceptions(formulation: Formulation, counts: Mapping[str, int]) -> tuple[str, ...]:
    """A note on the number of steps that the second kernel did; () for none."""
    name, text = formulation.in_other_way
    return (text.format(left=counts[name], steps=counts["steps"]),) if name in counts else ()


def completed(
    problem: Problem,
    report: EnergyReport,
    first: int,
    passage: str,
    massless: Massless,
    remedy: str = SMALLER_STEP,
    steps: int | None = None,
    exceptions: tuple[str, ...] = (),
) -> Outcome:
    """The outcome of a run that did all its ``steps``.

    Parameters
    ----------
    first
        steps since the problem's start before this run
    passage
        the worst one of two point masses that no step resolved, as a clause; "" for none
    remedy
        where the report has none
    exceptions
        notes of a run without doubts
    """
    clauses = _wrong(report)
    if report.unknown:
        undefined = "the energy is not a number"
        if isinstance(problem.system, Lagrangian) and conserves_energy(problem.system):
            undefined += ": L is undefined there, or no velocity has the momentum"
        clauses.append(undefined)
    clauses += [passage] if passage else []
    clauses = clauses or off_without_mass(problem, massless())
    unassessed = f"energy could not be assessed {report.unassessed}" if report.unassessed else ""
    if not clauses:
        return (
            Outcome(End.DOUBTFUL, reason=f"the {unassessed}", steps=steps)
            if unassessed
            else Outcome(notes=exceptions, steps=steps)
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
        steps since the problem's start before this run
    time_of
        (number of a step since then) -> the time at which it ends
    """
    notes = []
    if report.ruined is not None:
        t = time_of(max(report.ruined, first + 1))
        notes.append(f"It was ruined from t = {t:.10g} on: {'; '.join(_wrong(report))}.")
    if report.unassessed:
        notes.append(f"Its energy could not be assessed {report.unassessed}.")
    return tuple(notes)


def _wrong(report: EnergyReport) -> list[str]:
    """Clauses on what is wrong with a run."""
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


def off_without_mass(problem: Problem, error: encounters.MasslessError | None) -> list[str]:
    """A clause on the massless body whose energy steps change too much; [] for none."""
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
