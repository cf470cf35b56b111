"""Settings of contenders, which are mappings: their keys, and the steps and times of a run."""

from __future__ import annotations

import difflib
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from galvi import input_checks
from galvi.arrays import Array

COUNT_TOLERANCE = 1e-9  # largest relative distance of duration / step from a whole number


def nearest(word: str, choices: Iterable[str]) -> str:
    """The choice most similar to a word, ignoring case; choices that contain it come first."""
    folded, ordered = word.casefold(), sorted(choices)

    def likeness(choice: str) -> float:
        return difflib.SequenceMatcher(None, choice.casefold(), folded).ratio()

    return max(
        [choice for choice in ordered if folded in choice.casefold()] or ordered, key=likeness
    )


def check_keys(setting: Mapping[str, Any], allowed: Iterable[str]) -> None:
    """ValueError, with the most similar allowed key, for a key of the setting that is not
    allowed."""
    allowed = tuple(allowed)
    for key in setting:
        if key not in allowed:
            raise ValueError(
                f"a setting here may hold {', '.join(allowed)}; received {key!r}. "
                f"Did you mean {nearest(str(key), allowed)!r}?"
            )


def described(name: str, setting: Mapping[str, Any], engine: str = "") -> str:
    """The run's method in one line, e.g. 'REBOUND WHFast step=4 corrector=17 (rebound 5.2.2)'."""
    parts = [name, *(f"{key}={value}" for key, value in setting.items())]
    return " ".join([*parts, f"({engine})"] if engine else parts)


@dataclass(frozen=True, eq=False)
class FixedSteps:
    """Equal steps of a run, and the states to save.

    Attributes
    ----------
    step
        h, the duration of one step; negative backwards
    count
        n, so that n h is the duration
    saved : array, shape (saved,)
        numbers of the saved steps: 0, k, 2k, ... and the last
    """

    step: float
    count: int
    saved: Any

    def times(self, t0: float) -> Array:
        """t0 + j h of the saved states, (saved,)."""
        return t0 + self.saved * self.step


def fixed_steps(duration: float, setting: Mapping[str, Any]) -> FixedSteps:
    """The steps of a run, from 'step' and 'save_every' (default 1) of a setting.

    Raises
    ------
    ValueError
        Without a step, and unless duration / step is a positive whole number.
    """
    duration = _duration(duration)
    if "step" not in setting:
        raise ValueError(
            f"a fixed-step contender needs a 'step' in its setting; received {dict(setting)!r}."
        )
    step = input_checks.real("step", setting["step"])
    steps = duration / step if step else float("nan")
    count = max(1, round(steps)) if np.isfinite(steps) else 1
    if not abs(steps - count) <= COUNT_TOLERANCE * count:
        raise ValueError(
            f"step must divide the duration {duration!r} into a whole number of steps; received "
            f"{setting['step']!r}, {steps:.6g} steps. Choose step = duration / {count}."
        )
    save_every = input_checks.whole("save_every", setting.get("save_every", 1))
    saved = np.append(np.arange(0, count, save_every), count)
    return FixedSteps(step=step, count=count, saved=saved)


def sample_times(t0: float, duration: float, setting: Mapping[str, Any]) -> Array:
    """t0 + duration j / n for j = 0 .. n, (n + 1,), with n the setting's 'samples' (default 1)."""
    samples = input_checks.whole("samples", setting.get("samples", 1))
    return t0 + _duration(duration) * (np.arange(samples + 1) / samples)


def _duration(duration: float) -> float:
    duration = input_checks.real("duration", duration)
    if duration == 0.0:
        raise ValueError("duration must not be zero; received 0. Give the time to cover.")
    return duration
