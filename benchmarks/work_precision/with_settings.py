"""A reference with fixed settings, as the truth of a study."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from galvi import Problem, Trajectory
from references import Contender, missing_engine


@dataclass(frozen=True, eq=False)
class WithSettings:
    """A contender with ``setting`` added to the study's settings."""

    contender: Contender
    setting: Mapping[str, Any]

    @property
    def name(self) -> str:
        """The contender's name."""
        return self.contender.name

    @property
    def exact(self) -> bool:
        """Whether the contender is exact."""
        return self.contender.exact

    @property
    def missing(self) -> str:
        """Why the contender's engine is missing, or ""."""
        return self.contender.missing

    @property
    def engine(self) -> str:
        """The contender's engine where it is missing, or ""."""
        return missing_engine(self.contender)

    def supports(self, problem: Problem) -> bool:
        """Whether the contender supports the problem."""
        return self.contender.supports(problem)

    def run(self, problem: Problem, duration: float, setting: Mapping[str, Any]) -> Trajectory:
        """See `references.Contender`."""
        return self.contender.run(problem, duration, {**self.setting, **setting})
