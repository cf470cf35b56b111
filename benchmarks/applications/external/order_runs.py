"""Errors of an external integrator at steps that show its order, for `external.check_runs`.

It offers steps as short as it likes; the order p that it declares shows where errors are above
round-off and fall as a power of the step. The search starts from its longest step and doubles or
halves it until the error is between SMALLEST_SPAN^p times the floor and COARSE. The errors that the
order is fitted to begin there, and end where the declared order would reach the floor, or at its
shortest step. Where errors rise repeatedly on the way, as in lower precision, the order is
looked for again from COARSE on.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from functools import cache
from typing import Any

import numpy as np

from benchmarks.applications.external.check_problems import CheckProblem
from benchmarks.applications.external.integrator import ExternalIntegrator
from benchmarks.statistics.convergence_fits import window
from benchmarks.store.frames import failure, row
from galvi.arrays import Array

ORDER = "error in between"
POINTS, LARGEST_RATIO = 9, 2.0  # step sizes: number, and largest ratio
SMALLEST_SPAN, LARGEST_SPAN = (
    4.0,
    8.0,
)  # factor between first and last step: at least, and where errors allow
COARSE, SMALL = 1e-2, 1e-6  # largest error, and smallest, from which the order is looked for
ROOM = 10.0  # of the first error above SMALLEST_SPAN^p times the floor
FEWEST_STEPS = 10  # of a run
RISES = 2  # rises of the error with shorter steps that count as erratic; one is a change of sign
SINGLE = 1e-8  # error above which those that rise and fall may be round-off of single precision
HIGHEST = 100.0  # order from which on the powers above are those of this order

Errors = Callable[[int], tuple[float, str]]  # of a run of so many steps, and why it failed


def order_runs(
    external: ExternalIntegrator,
    check: CheckProblem,
    settings: Sequence[Mapping[str, Any]],
    end: Array,
) -> Iterator[dict[str, Any]]:
    """Rows ORDER at decreasing steps; none where it declares no order, offers no steps, or the
    problem does not show an order. A run that fails at a step outside of those that it offers is no
    fault and has no row."""
    equal = [setting for setting in settings if "step" in setting]
    if external.order is None or external.order < check.ordered or not equal:
        return
    order = min(external.order, HIGHEST)
    longest, shortest = offered_steps(check, equal)
    error = errors_at(external, check, equal, end)
    most_steps = max(shortest, round(LARGEST_SPAN * longest))
    least_error = min(COARSE, max(SMALL, ROOM * check.floor * SMALLEST_SPAN**order))
    numbers = _numbers(
        error, fewest(error, longest, most_steps, least_error), shortest, order, check.floor
    )
    if rises([error(steps)[0] for steps in numbers], max(check.floor, SINGLE)) >= RISES:
        few = fewest(error, longest, most_steps, COARSE)
        numbers = _numbers(error, few, few, order, check.floor)
    for steps in numbers:
        value, status = error(steps)
        if status and not longest <= steps <= shortest:
            continue
        yield row(
            study=check.problem.name,
            quantity=ORDER,
            step=check.duration / steps,
            steps=steps,
            value=value,
            status=status,
        )


def offered_steps(check: CheckProblem, equal: Sequence[Mapping[str, Any]]) -> tuple[int, int]:
    """The fewest and the most steps over the problem's duration at these settings."""
    steps = [max(1, round(check.duration / setting["step"])) for setting in equal]
    return min(steps), max(steps)


def errors_at(
    external: ExternalIntegrator,
    check: CheckProblem,
    equal: Sequence[Mapping[str, Any]],
    end: Array,
) -> Errors:
    """The error of a run by its number of steps, over the problem's size; each is run once. Outside
    of the offered settings (`equal`, each with a step) a failure is no fault."""
    longest, shortest = offered_steps(check, equal)

    @cache
    def error(steps: int) -> tuple[float, str]:
        setting = {**equal[-1], "step": check.duration / steps, "save_every": steps}
        is_trial = not longest <= steps <= shortest
        run = external.checked(check.problem, check.duration, setting, is_trial=is_trial).run
        off = float(np.max(np.abs(run.q[-1] - end))) if run.success else float("nan")
        return off / check.size, failure(run)

    return error


def rises(errors: Sequence[float], floor: float) -> int:
    """The number of errors above round-off that are larger than that of the next longer step."""
    measured = np.asarray(errors, dtype=np.float64)[window(errors, floor=floor)]
    return int(np.sum(np.diff(measured) > 0.0))


def _numbers(error: Errors, few: int, shortest: int, order: float, floor: float) -> tuple[int, ...]:
    """Increasing numbers of steps from `few` on; only `few` where its run fails."""
    first = error(few)[0]
    if np.isnan(first):
        return (few,)
    reach = 2.0 * few * max(first / floor, 1.0) ** (1.0 / order) if first > 0.0 else few
    many = max(SMALLEST_SPAN * few, min(reach, max(LARGEST_SPAN * few, shortest)))
    ratio = min(LARGEST_RATIO, (many / few) ** (1.0 / (POINTS - 1)))
    return tuple(dict.fromkeys(round(few * ratio**k) for k in range(POINTS)))


def fewest(error: Errors, longest: int, most_steps: int, least_error: float) -> int:
    """The number of steps to begin with, of an error of at least `least`; that of its longest step
    where this fails, or is too long and so are all up to `most`."""
    few, now = longest, error(longest)[0]
    while now < least_error and few >= 2 * FEWEST_STEPS:
        longer = error(few // 2)[0]
        if np.isnan(longer):
            return few
        if longer >= least_error:  # between the two
            part = np.log(longer / least_error) / np.log(longer / now) if now > 0.0 else 0.0
            return round((few // 2) * 2.0 ** min(part, 1.0))
        few, now = few // 2, longer
    while now > COARSE and 2 * few <= most_steps:
        shorter = error(2 * few)[0]
        if np.isnan(shorter):
            break
        few, now = 2 * few, shorter
    return longest if now > COARSE else few
