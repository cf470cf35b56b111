"""A reference with the settings that make it the truth of a study."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from galvi import Problem, Trajectory
from references import Contender


@dataclass(frozen=True, eq=False)
class WithSettings:
    """A contender with ``setting`` added to whatever a study asks for."""

    contender: Contender
    setting: Mapping[str, Any]

    @property
    def name(self) -> str:
        """The contender's."""
        return self.contender.name

    @property
    def exact(self) -> bool:
        """The contender's."""
        return self.contender.exact

    @property
    def missing(self) -> str:
        """The contender's."""
        return self.contender.missing

    def supports(self, problem: Problem) -> bool:
        """The contender's."""
        return self.contender.supports(problem)

    def run(self, problem: Problem, duration: float, setting: Mapping[str, Any]) -> Trajectory:
        """See `references.Contender`."""
        return self.contender.run(problem, duration, {**self.setting, **setting})
