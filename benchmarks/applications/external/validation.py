"""Validate the answers of an external integrator, inside its process.

The values that are returned are plain numbers, texts and arrays, which can be unpickled without the
integrator's code. Invalid answers raise ContenderError with a sentence.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from benchmarks.applications.external.loading import (
    ContenderError,
    describe_error,
    is_positive,
    plain_text,
)
from benchmarks.store.foreign_texts import visible
from galvi import Problem, Trajectory
from galvi.arrays import Array
from references.setting import fixed_steps, sample_times

MOST_STEPS, MOST_STATES = 10**10, 10**7  # limits of a run
# Tolerance of a time, relative to the duration, and of the first state, relative to the largest
# component of all states.
RELATIVE_TOLERANCE = 1e-9


def saved_times(problem: Problem, duration: float, setting: Mapping[str, Any]) -> Array:
    """The times (saved,) of the states of a run at this setting.

    Raises the exceptions of `references.setting.fixed_steps` and `sample_times`.
    """
    if "step" in setting:
        return fixed_steps(duration, setting).times(problem.t0)
    return sample_times(problem.t0, duration, setting)


def valid_settings(offered: Sequence[Any], duration: float) -> list[dict[str, Any]]:
    """The settings as plain values.

    Raises ContenderError unless there is one at least, steps are positive, and the numbers of steps
    and states are within bounds. Where the settings differ by their steps alone, the last step must
    not be longer than the first.
    """
    if not offered or not all(isinstance(mapping, Mapping) for mapping in offered):
        raise ContenderError(f"Its settings must be mappings, one at least; received {offered!r}.")
    settings = [
        {plain_text(name): _plain(plain_text(name), value) for name, value in mapping.items()}
        for mapping in offered
    ]
    for setting in settings:
        _check_bounds(setting, duration)
    steps = [mapping["step"] for mapping in settings if "step" in mapping]
    other_options = {
        repr(sorted((k, v) for k, v in mapping.items() if k not in ("step", "save_every")))
        for mapping in settings
    }
    if len(steps) == len(settings) and len(other_options) == 1 and steps[-1] > steps[0]:
        raise ContenderError(
            f"Its settings must go from coarse to fine; received steps from {steps[0]:g} to "
            f"{steps[-1]:g}."
        )
    return settings


def _plain(name: str, value: Any) -> Any:
    value = value.item() if isinstance(value, np.generic) else value
    if value is not None and type(value) not in (bool, int, float, str):
        raise ContenderError(
            f"Its settings must hold numbers, words, True, False or None; {name} is a "
            f"{type(value).__name__}."
        )
    return value


def _check_bounds(setting: Mapping[str, Any], duration: float) -> None:
    states = setting.get("samples", 0)
    if "step" in setting:
        step, save_every = setting["step"], setting.get("save_every", 1)
        if not is_positive(step):
            raise ContenderError(
                f"Its settings' step must be a positive number; received {step!r}."
            )
        if abs(duration) > MOST_STEPS * step:
            raise ContenderError(
                f"Its settings may ask for {MOST_STEPS:,} steps at most; received a step of "
                f"{step!r} for a duration of {duration:g}."
            )
        states = abs(duration) / step / save_every if is_positive(save_every) else 0
    if isinstance(states, (int, float)) and states > MOST_STATES:
        raise ContenderError(
            f"Its settings may ask for {MOST_STATES:,} states at most; received {dict(setting)!r}."
        )


def valid_claim(claimed: Any) -> float:
    """The claimed error as a float; ContenderError unless it is a positive number."""
    if not is_positive(claimed):
        raise ContenderError(
            f"The error that it claims must be a positive number; received {claimed!r}."
        )
    return float(claimed)


def valid_run(
    run: Any, problem: Problem, duration: float, setting: Mapping[str, Any]
) -> dict[str, Any]:
    """t, q, p, success, status and counts of a run, checked against the request."""
    if not isinstance(run, Trajectory):
        raise ContenderError(
            f"Its run must return a galvi.Trajectory; received {type(run).__name__}."
        )
    t, q, p = (_numbers(name, getattr(run, name)) for name in ("t", "q", "p"))
    _check_times(t, problem, duration, setting)
    for name, states, start in (("q", q, problem.q0), ("p", p, problem.v0)):
        if states.shape != (len(t), *start.shape):
            raise ContenderError(
                f"Its {name} must have the shape {(len(t), *start.shape)}; received {states.shape}."
            )
    success, status = bool(run.success), visible(plain_text(run.status))
    if not success and not status.strip():
        raise ContenderError("It says that it failed, and its status does not say why.")
    if success:
        _check_states(q, p, problem)
    try:
        counts = {plain_text(name): int(count) for name, count in dict(run.counts).items()}
    except (TypeError, ValueError):
        raise ContenderError(
            f"Its counts must be whole numbers by their names; received {run.counts!r}."
        ) from None
    return {"t": t, "q": q, "p": p, "success": success, "status": status, "counts": counts}


def _numbers(name: str, part: Any) -> Array:
    """A copy of the array as float64; ContenderError unless it has real numbers."""
    try:
        dtype = np.asarray(part).dtype
        if dtype.kind in "biufO":
            return np.array(part, dtype=np.float64)
        why = f"received {dtype}"
    except (TypeError, ValueError) as error:
        why = str(error)
    raise ContenderError(f"Its {name} must be an array of real numbers; {why}.")


def _check_times(t: Array, problem: Problem, duration: float, setting: Mapping[str, Any]) -> None:
    try:
        times = saved_times(problem, duration, setting)
    except (TypeError, ValueError, OverflowError, MemoryError) as error:
        raise ContenderError(
            "Its settings must say at which times a run has states, as step and save_every or as "
            f"samples; received {dict(setting)!r} ({describe_error(error)})."
        ) from None
    if t.shape != times.shape or not np.allclose(
        t, times, rtol=0.0, atol=RELATIVE_TOLERANCE * abs(duration)
    ):
        received = (
            f"{len(t)} from {t[0]:g} to {t[-1]:g}"
            if t.ndim == 1 and t.size
            else (f"an array of shape {t.shape}")
        )
        raise ContenderError(
            f"Its times must be the {len(times)} from {times[0]:g} to {times[-1]:g} that its "
            f"setting asks for; received {received}."
        )


def _check_states(q: Array, p: Array, problem: Problem) -> None:
    """Raise ContenderError unless states are finite and begin with the problem's start."""
    if not (np.isfinite(q).all() and np.isfinite(p).all()):
        raise ContenderError("It says that it succeeded, and its states are not finite.")
    for name, states, start in (("q", q, problem.q0), ("p", p, problem.p0)):
        difference = np.max(np.abs(states[0] - start))
        if difference > RELATIVE_TOLERANCE * max(np.max(np.abs(states)), np.max(np.abs(start))):
            raise ContenderError(
                f"Its first {name} must be the problem's start, {_one_line(start)}; received "
                f"{_one_line(states[0])}."
            )


def _one_line(state: Array) -> str:
    text = np.array2string(np.ravel(state), precision=6, threshold=6, separator=", ")
    return text.replace("\n", "")
