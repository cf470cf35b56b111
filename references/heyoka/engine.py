"""What the heyoka references share: availability, settings and the run of one integrator."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from galvi import input_checks
from galvi.arrays import Array
from references.as_trajectory import Failure
from references.engine_clock import engine_time

DOUBLE: Mapping[str, Any] = {"tolerance": 2.0**-52, "high_accuracy": False, "compact_mode": False}
# 1e-25 is far below the errors that are compared; compact mode compiles faster.
QUADRUPLE: Mapping[str, Any] = {"tolerance": 1e-25, "high_accuracy": True, "compact_mode": True}


def missing(precision: str) -> str:
    """Why heyoka cannot be used here with "double" or "real128"; empty when it can."""
    try:
        import heyoka
    except ImportError as error:
        return f"{error}. Install heyoka, which has wheels for Linux on x86-64."
    if precision != "double" and not hasattr(heyoka, precision):
        return f"heyoka {heyoka.__version__} has no {precision} on this machine."
    return ""


def number_type(precision: str) -> Any:
    """The scalar type of a precision, "double" or "real128"."""
    import heyoka

    return heyoka.real128 if precision == "real128" else float


def engine_name(precision: str) -> str:
    """Name and version of the engine, and the precision."""
    import heyoka

    return f"heyoka {heyoka.__version__}, {precision}"


def options(setting: Mapping[str, Any], precision: str) -> dict[str, Any]:
    """tolerance, high_accuracy and compact_mode, from the setting or the precision's defaults."""
    defaults = DOUBLE if precision == "double" else QUADRUPLE
    return {**defaults, **{key: setting[key] for key in DOUBLE if key in setting}}


def checked_options(values: Mapping[str, Any]) -> tuple[float, bool, bool]:
    """(tolerance, high_accuracy, compact_mode); ValueError unless the tolerance is positive."""
    tolerance = input_checks.positive("tolerance", values["tolerance"])
    return tolerance, bool(values["high_accuracy"]), bool(values["compact_mode"])


def propagate(
    integrator: Any, state: Any, times: Array, t0: float, cause: str
) -> tuple[Any, int, Failure | None]:
    """Integrate from a state to each of some times.

    Parameters
    ----------
    integrator : heyoka.taylor_adaptive
        its time and state are overwritten
    state : array, shape (n,)
        at the start
    times : array, shape (saved,)
        from the start on; times[0] = 0
    t0
        the time of the start, for the message of a failure only
    cause
        what a failure means, a sentence

    Returns
    -------
    states : array, shape (saved, n)
        NaN from a failure on
    steps
        number of steps done
    failure
        None where the last time was reached
    """
    import heyoka

    number = type(integrator.time)
    states = np.full((len(times), integrator.state.size), np.nan).astype(integrator.state.dtype)
    states[0] = state
    integrator.time = number(0.0)
    integrator.state[:] = state
    steps_done = 0
    for row, t in enumerate(times.tolist()[1:], start=1):
        with engine_time:
            outcome, _, _, steps, *_ = integrator.propagate_until(number(t))
        steps_done += int(steps)
        if outcome != heyoka.taylor_outcome.time_limit:  # heyoka's name for: the time was reached
            where = f"heyoka stopped before t = {t0 + t:.6g} ({outcome})"
            why = f"{where}: {cause} End the run earlier."
            return states, steps_done, Failure(row=row, step=row, why=why)
        states[row] = integrator.state
    return states, steps_done, None
