"""The length of a run as a number of steps."""

from __future__ import annotations

import math

from galvi import input_checks

LARGEST_SLACK = 0.25  # steps by which a time may differ from a whole number of them


def number_of_steps(step: float, steps: int | None, duration: float | None) -> int:
    """``steps``, or the duration over the step; ValueError unless a whole number."""
    if (steps is None) == (duration is None):
        raise ValueError(
            "give either steps or duration; received " + ("neither." if steps is None else "both.")
        )
    if steps is not None:
        return input_checks.whole("steps", steps)
    length = input_checks.positive("duration", duration, "For backwards, make the step negative.")
    ratio = length / abs(step)
    if ratio > input_checks.LARGEST:
        input_checks.whole("duration over step", ratio)
    whole, sign = round(ratio), math.copysign(1.0, step)
    if whole < 1 or abs(ratio - whole) > min(1e-9 * whole, LARGEST_SLACK):
        raise ValueError(
            f"duration must be a whole number of steps; received {length!r} with step {step!r}, "
            f"{ratio:.6g} steps. Choose step={length / max(1, math.ceil(ratio)) * sign!r}"
            + (f" or {length / math.floor(ratio) * sign!r}." if ratio >= 1.0 else ".")
        )
    return whole


def steps_until(until: float, t0: float, step: float, done: int) -> int:
    """Steps from step number ``done`` to the time ``until``; ValueError unless a whole number."""
    ratio = (input_checks.real("until", until) - t0) / step
    whole = round(ratio) if abs(ratio) <= input_checks.LARGEST else 0
    slack = 1e-9 + 4.0 * math.ulp(max(abs(t0), abs(until))) / abs(step)  # of such times
    if whole <= done or abs(whole - ratio) > min(slack, LARGEST_SLACK):
        raise ValueError(
            f"until must be a whole number of steps after t = {t0 + done * step!r}, where the run "
            f"ends; received {until!r} with step {step!r}. Choose {t0!r} + n * {step!r}."
        )
    return whole - done
