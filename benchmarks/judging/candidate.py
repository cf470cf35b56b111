"""The parts of a judgement: sources of truth, the user's own setting, and candidates."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from galvi import Problem, Trajectory
from references import Contender


@dataclass(frozen=True)
class Source:
    """A contender whose runs may be the truth, at this setting."""

    label: str
    contender: Contender
    setting: Mapping[str, Any]


@dataclass(frozen=True)
class Own:
    """The user's integrator; ``step`` is None where it chooses its own."""

    label: str
    contender: Contender
    options: Mapping[str, Any]
    step: float | None


@dataclass(frozen=True)
class Candidate:
    """One setting of an integrator; ``steps`` of the whole duration, None where it chooses them."""

    label: str
    contender: Contender
    options: Mapping[str, Any]
    steps: int | None

    def setting(self, duration: float, samples: int) -> dict[str, Any]:
        """With so many states, or a divisor of it; steps are rounded up to a multiple of that."""
        if self.steps is None:
            return {"samples": samples, **self.options}
        count = -(-self.steps // samples) * samples
        return {"step": duration / count, "save_every": count // samples, **self.options}

    def run(self, problem: Problem, duration: float, samples: int) -> Trajectory:
        """The run with these states."""
        return self.contender.run(problem, duration, self.setting(duration, samples))
