"""Errors of an external integrator at steps that show its order, for `external.check_runs`.

An integrator may offer steps of any size; the order p that it declares shows where errors are above
round-off and fall as a power of the step. The search starts from its longest step and doubles or
halves it until the error is between SMALLEST_SPAN^p times the floor and LARGEST_FIRST_ERROR. The
fitted errors begin there, and end where the declared order would reach the floor, or at the
shortest step. Where errors rise repeatedly, as in lower precision, the search is repeated from
LARGEST_FIRST_ERROR on.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from functools import cache
from typing import Any

import numpy as np

from benchmarks.applications.external.check_problems import CheckProblem
from benchmarks.applications.external.integrator import ExternalIntegrator
from benchmarks.statistics.convergence_fits import window
from benchmarks.store.tables import failure, row
from galvi.arrays import Array

ORDER = "error in between"
STEP_SIZES, LARGEST_RATIO = 9, 2.0  # step sizes: number, and largest ratio
SMALLEST_SPAN = 4.0  # least ratio of the longest to the shortest step
LARGEST_SPAN = 8.0  # the same where the errors stay above round-off
LARGEST_FIRST_ERROR, SMALLEST_FIRST_ERROR = 1e-2, 1e-6  # the fit begins in between
FIRST_ERROR_FACTOR = 10.0  # least ratio of the first error to SMALLEST_SPAN^p times the floor
FEWEST_STEPS = 10  # of a run
ERRATIC_RISES = (
    2  # rises of the error with shorter steps that count as erratic; one is a change of sign
)
SINGLE = 1e-8  # error above which those that rise and fall may be round-off of single precision
HIGHEST_ORDER = 100.0  # higher orders are treated as this one, so that the powers stay finite

Errors = Callable[[int], tuple[float, str]]  # number of steps -> error, reason of a failure or ""


def order_runs(
    external: ExternalIntegrator,
    check: CheckProblem,
    settings: Sequence[Mapping[str, Any]],
    end: Array,
) -> Iterator[dict[str, Any]]:
    """Rows ORDER at decreasing steps.

    No rows where the integrator declares no order, or a lower one than the problem can show, or
    offers no steps. A run that fails at a step outside the offered range is no fault and has no
    row.
    """
    equal = [setting for setting in settings if "step" in setting]
    if external.order is None or external.order < check.ordered or not equal:
        return
    order = min(external.order, HIGHEST_ORDER)
    fewest_offered, most_offered = offered_steps(check, equal)
    error = errors_at(external, check, equal, end)
    most_steps = max(most_offered, round(LARGEST_SPAN * fewest_offered))
    least_error = min(
        LARGEST_FIRST_ERROR,
        max(SMALLEST_FIRST_ERROR, FIRST_ERROR_FACTOR * check.floor * SMALLEST_SPAN**order),
    )
    numbers = _step_numbers(
        error,
        first_steps(error, fewest_offered, most_steps, least_error),
        most_offered,
        order,
        check.floor,
    )
    if rises([error(steps)[0] for steps in numbers], max(check.floor, SINGLE)) >= ERRATIC_RISES:
        few = first_steps(error, fewest_offered, most_steps, LARGEST_FIRST_ERROR)
        numbers = _step_numbers(error, few, few, order, check.floor)
    for steps in numbers:
        value, status = error(steps)
        if status and not fewest_offered <= steps <= most_offered:
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
    """The smallest and the largest number of steps over the duration at these settings."""
    steps = [max(1, round(check.duration / setting["step"])) for setting in equal]
    return min(steps), max(steps)


def errors_at(
    external: ExternalIntegrator,
    check: CheckProblem,
    equal: Sequence[Mapping[str, Any]],
    end: Array,
) -> Errors:
    """A function of the number of steps that runs once and returns the error over the problem's
    size, and the reason of a failure.

    Outside the range of the offered settings (`equal`, each with a step) a failure is no fault.
    """
    fewest_offered, most_offered = offered_steps(check, equal)

    @cache
    def error(steps: int) -> tuple[float, str]:
        setting = {**equal[-1], "step": check.duration / steps, "save_every": steps}
        is_trial = not fewest_offered <= steps <= most_offered
        run = external.checked(check.problem, check.duration, setting, is_trial=is_trial).run
        error_at_end = float(np.max(np.abs(run.q[-1] - end))) if run.success else float("nan")
        return error_at_end / check.size, failure(run)

    return error


def rises(errors: Sequence[float], floor: float) -> int:
    """The number of errors above `floor` that are larger than that of the next longer step."""
    measured = np.asarray(errors, dtype=np.float64)[window(errors, floor=floor)]
    return int(np.sum(np.diff(measured) > 0.0))


def _step_numbers(
    error: Errors, few: int, most_offered: int, order: float, floor: float
) -> tuple[int, ...]:
    """Increasing numbers of steps from `few` on; only `few` where the run with these fails."""
    first_error = error(few)[0]
    if np.isnan(first_error):
        return (few,)
    reach = 2.0 * few * max(first_error / floor, 1.0) ** (1.0 / order) if first_error > 0.0 else few
    many = max(SMALLEST_SPAN * few, min(reach, max(LARGEST_SPAN * few, most_offered)))
    ratio = min(LARGEST_RATIO, (many / few) ** (1.0 / (STEP_SIZES - 1)))
    return tuple(dict.fromkeys(round(few * ratio**k) for k in range(STEP_SIZES)))


def first_steps(error: Errors, fewest_offered: int, most_steps: int, least_error: float) -> int:
    """The number of steps from which the order is measured.

    It is halved while the error is below `least_error`, and doubled up to `most_steps` while the
    error is above LARGEST_FIRST_ERROR. Returns `fewest_offered` where that run fails or no number
    of steps reaches LARGEST_FIRST_ERROR.
    """
    few, error_at_few = fewest_offered, error(fewest_offered)[0]
    while error_at_few < least_error and few >= 2 * FEWEST_STEPS:
        error_at_half = error(few // 2)[0]
        if np.isnan(error_at_half):
            return few
        if (
            error_at_half >= least_error
        ):  # the error is reached between half as many steps and these
            fraction = (
                np.log(error_at_half / least_error) / np.log(error_at_half / error_at_few)
                if error_at_few > 0.0
                else 0.0
            )
            return round((few // 2) * 2.0 ** min(fraction, 1.0))
        few, error_at_few = few // 2, error_at_half
    while error_at_few > LARGEST_FIRST_ERROR and 2 * few <= most_steps:
        error_at_double = error(2 * few)[0]
        if np.isnan(error_at_double):
            break
        few, error_at_few = 2 * few, error_at_double
    return fewest_offered if error_at_few > LARGEST_FIRST_ERROR else few
