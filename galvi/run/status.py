"""How a run ended: one sentence saying why, with a remedy, and whether it can be used."""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from galvi.arrays import Array
from galvi.kernels.energy_errors import TOLERATED, WORST
from galvi.kernels.nystrom.solve import SOLVED
from galvi.problem import Problem
from galvi.run.energies import conserves_energy
from galvi.run.energy_assessment import EnergyReport
from galvi.run.gimbal_lock import LOCKED
from galvi.run.plan import LEFT_OVER, Engine, Run, RunArrays
from galvi.run.point_masses import encounters
from galvi.systems.lagrangian import Lagrangian
from galvi.trajectory import COMPLETED

MEASURE = "the larger of the kinetic energy at the start and the range of the potential energy"


class Ending(NamedTuple):
    """The end of a run.

    success, status, failed_step  see `galvi.Trajectory`
    energies                      see `Checkpoint`
    """

    success: bool
    status: str
    failed_step: int | None
    energies: Array


def ending(
    engine: Engine, run: Run, work: RunArrays, code: int, found: EnergyReport,
    light: Callable[[], encounters.MasslessError | None],
) -> Ending:  # fmt: skip
    """The end of a run whose last kernel call returned ``code``.

    found  what its energies say
    light  () -> what a step does to bodies without mass; asked where all else is well
    """
    done, start, before, total = work.done, run.start, run.before, run.total or run.steps
    ruined = None if found.ruined is None else max(found.ruined - start.first, 1) + before
    failed = ruined if done == run.steps else before + done + 1
    if done == run.steps:
        status = _completed(engine, run, work, found, ruined, light)
    else:
        t = run.problem.t0 + (start.first + done) * run.step
        where = f"at step {failed} of {total}, from t = {t:.10g}"
        if code == SOLVED:
            status = f"Interrupted {where}; what was computed is kept."
        else:
            reason = engine.failure(run, code, work)
            status = f"Stopped {where}: {reason}"
        if ruined is not None:
            status += f" It was ruined from step {ruined} on: {'; '.join(_wrong(found))}."
        if found.unassessed:
            status += f" Its energy {_unjudged(found)}."
    return Ending(failed is None, status, failed, found.energies)


def _completed(
    engine: Engine, run: Run, work: RunArrays, found: EnergyReport, ruined: int | None,
    light: Callable[[], encounters.MasslessError | None],
) -> str:  # fmt: skip
    """COMPLETED, or what the energy, the passages of point masses and those without mass say."""
    problem, step, steps = run.problem, run.step, run.total or run.steps
    passage = encounters.unresolved_passage(problem, step, work.passage, run.method.in_frame)
    reasons = _wrong(found)
    if found.unknown:
        undefined = "the energy is not a number"
        if isinstance(problem.system, Lagrangian) and conserves_energy(problem.system):
            undefined += ": L is undefined there, or no velocity has the momentum"
        reasons.append(undefined)
    if passage:
        reasons.append(passage)
    if not reasons:
        reasons = off_without_mass(problem, light())
    if not reasons:
        if found.unassessed:
            return f"Completed, but the energy {_unjudged(found)}."
        left = int(work.counts[LEFT_OVER])
        said = engine.exceptions[1].format(left=left, steps=steps)
        return f"{COMPLETED} {said}" if left else COMPLETED
    remedy = "Use a smaller step or a higher degree"
    if passage and encounters.asks_for_a_clock(problem, step, work.passage):
        remedy = encounters.ADAPT
    if found.remedy:
        remedy = found.remedy
    elif _given(problem):
        remedy += ", and check that the derivatives are those of the energy"
    if found.unassessed:
        remedy += f". The energy {_unjudged(found)}"
    if ruined is not None:
        return f"Ruined from step {ruined} of {steps} on: {'; '.join(reasons)}. {remedy}."
    cause = "" if LOCKED in found.clauses else ": the step is too large for this motion"
    return f"Completed, but {'; '.join(reasons)}{cause}. {remedy}."


def _unjudged(found: EnergyReport) -> str:
    return f"could not be judged {found.unassessed}"


def _wrong(found: EnergyReport) -> list[str]:
    """What is wrong with a run, in clauses."""
    return [*([energy_clause(found)] if found.error > TOLERATED else []), *found.clauses]


def energy_clause(found: EnergyReport) -> str:
    if np.isfinite(found.error):
        return f"the energy changed by {found.error:.2g} times {MEASURE}"
    return (
        f"the energy changed by {found.energies[WORST]:.2g}, and no step kept it to {TOLERATED:g} "
        f"times {MEASURE}"
    )


def off_without_mass(problem: Problem, found: encounters.MasslessError | None) -> list[str]:
    """That steps change the energy of a body without mass, or nothing."""
    if found is None or not found.share > encounters.COARSE:
        return []
    body = encounters.body_names(problem, len(problem.q0))[found.body]
    return [
        f"a step changes the energy of the massless body {body} by about {found.share:.1g} of "
        f"v^2 / 2 + G M / r (an estimate, from {found.states} of the steps)"
    ]


def _given(problem: Problem) -> bool:
    """Whether the user gave derivatives, which may contradict the energy."""
    given = (getattr(problem.system, name, None) for name in ("gradient", "slopes"))
    return any(function is not None for function in given)
