"""The settings that somebody else's contender offers, examined before it is run with any."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from benchmarks.external.loading import Fault, is_positive

MOST_STEPS, MOST_STATES = 10**10, 10**7  # that a run may take, and hold


def plain_ladder(offered: Sequence[Mapping[Any, Any]], duration: float) -> list[dict[str, Any]]:
    """They as plain mappings. Fault when they are none, ask for too much or get coarser."""
    plain = [
        {str(name): _plain(str(name), value) for name, value in one.items()} for one in offered
    ]
    for one in plain:
        if "step" in one and not is_positive(one["step"]):
            raise Fault(f"Its settings' step must be a positive number; received {one['step']!r}.")
        _bounded(one, duration)
    steps = [one["step"] for one in plain if "step" in one]
    apart = {
        repr(sorted((k, v) for k, v in one.items() if k not in ("step", "save_every")))
        for one in plain
    }
    if len(steps) == len(plain) and len(apart) == 1 and steps[-1] > steps[0]:
        raise Fault(
            f"Its settings must go from coarse to fine; received steps from {steps[0]:g} to "
            f"{steps[-1]:g}."
        )
    return plain


def _bounded(setting: Mapping[str, Any], duration: float) -> None:
    """Fault for a setting that asks for more steps or states than a run can have here."""
    states = setting.get("samples", 0)
    if "step" in setting:
        if abs(duration) > MOST_STEPS * float(setting["step"]):
            raise Fault(
                f"Its settings may ask for {MOST_STEPS:,} steps at most; received a step of "
                f"{setting['step']!r} for a duration of {duration:g}."
            )
        every = setting.get("save_every", 1)
        if is_positive(every):
            states = abs(duration) / setting["step"] / every
    if not isinstance(states, str) and states is not None and states > MOST_STATES:
        raise Fault(
            f"Its settings may ask for {MOST_STATES:,} states at most; received {dict(setting)!r}."
        )


def _plain(name: str, value: Any) -> Any:
    """A value that another process can take without running code of the contender's."""
    value = value.item() if isinstance(value, np.generic) else value
    if value is not None and type(value) not in (bool, int, float, str):
        raise Fault(
            f"Its settings must hold numbers, words, True, False or None; {name} is a "
            f"{type(value).__name__}."
        )
    return value
