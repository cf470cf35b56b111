"""Shared by the heyoka references: availability, settings and one run of an integrator."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from galvi import input_checks
from galvi.arrays import Array
from references.as_trajectory import Failure
from references.engine_clock import engine_time

DEFAULT: Mapping[str, Any] = {"tolerance": 2.0**-52, "high_accuracy": False, "compact_mode": False}
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


def kind(precision: str) -> Any:
    """The type of numbers of a precision, "double" or "real128"."""
    import heyoka

    return heyoka.real128 if precision == "real128" else float


def engine_name(precision: str) -> str:
    """Name and version of the engine, and the precision."""
    import heyoka

    return f"heyoka {heyoka.__version__}, {precision}"


def options(setting: Mapping[str, Any], precision: str) -> dict[str, Any]:
    """tolerance, high_accuracy and compact_mode, from the setting or the precision's defaults."""
    defaults = DEFAULT if precision == "double" else QUADRUPLE
    return {**defaults, **{key: setting[key] for key in DEFAULT if key in setting}}


def switches(options: Mapping[str, Any]) -> tuple[float, bool, bool]:
    """(tolerance, high_accuracy, compact_mode); ValueError unless the tolerance is positive."""
    tolerance = input_checks.positive("tolerance", options["tolerance"])
    return tolerance, bool(options["high_accuracy"]), bool(options["compact_mode"])


def propagated(
    engine: Any, start: Any, times: Array, t0: float, why: str
) -> tuple[Any, int, Failure | None]:
    """States (saved, n) at times since the start, the first 0; NaN past a failure.

    Also the number of steps, and the failure, whose reason is ``why``; t0 only enters its sentence.
    """
    import heyoka

    number = type(engine.time)
    states = np.full((len(times), engine.state.size), np.nan).astype(engine.state.dtype)
    states[0] = start
    engine.time = number(0.0)
    engine.state[:] = start
    steps_done = 0
    for row, t in enumerate(times.tolist()[1:], start=1):
        with engine_time:
            ended, _, _, steps, *_ = engine.propagate_until(number(t))
        steps_done += int(steps)
        if ended != heyoka.taylor_outcome.time_limit:
            why = f"heyoka stopped before t = {t0 + t:.6g} ({ended}): {why} End the run earlier."
            return states, steps_done, Failure(row=row, step=row, why=why)
        states[row] = engine.state
    return states, steps_done, None
