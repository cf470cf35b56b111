"""An integrator that Python hands over as a class or an instance, as a contender."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from benchmarks.applications.external.loading import (
    METHODS,
    ContenderError,
    describe_error,
    is_positive,
)
from benchmarks.applications.external.timed_run import TimedRun
from benchmarks.applications.external.validation import valid_settings
from benchmarks.applications.external.worker import timed_run
from galvi import Problem, Trajectory


@dataclass(frozen=True, eq=False)
class OwnIntegrator:
    """A contender that runs in this process.

    Its runs are checked like those of `external.integrator.ExternalIntegrator`; where it raises,
    the run is a failed one.
    """

    name: str
    integrator: Any
    exact: bool = False
    missing: str = ""

    @classmethod
    def of(cls, name: str, integrator: Any) -> OwnIntegrator:
        """The contender of a class or an instance.

        Raises ContenderError for a class that cannot be constructed or lacks a required member.
        """
        if isinstance(integrator, type):
            try:
                integrator = integrator()
            except Exception as error:
                raise ContenderError(
                    f"the integrator {name!r} raised {describe_error(error)}"
                ) from None
        lacking = [word for word in METHODS if not callable(getattr(integrator, word, None))]
        if lacking:
            raise ContenderError(
                f"the integrator {name!r} lacks {' and '.join(map(repr, lacking))}; it must have "
                "supports(problem) and run(problem, duration, setting)"
            )
        return cls(name, integrator)

    @property
    def order(self) -> float | None:
        """The declared order; None where there is none or it is no positive number."""
        order = getattr(self.integrator, "order", None)
        return float(order) if is_positive(order) else None

    def supports(self, problem: Problem) -> bool:
        """Whether the integrator supports the problem.

        Raises
        ------
        ContenderError
            Where it raises.
        """
        try:
            return bool(self.integrator.supports(problem))
        except Exception as error:
            raise ContenderError(
                f"the integrator {self.name!r}, asked whether it supports the problem, raised "
                f"{describe_error(error)}"
            ) from None

    def settings(
        self, problem: Problem, duration: float, fewest: int
    ) -> Sequence[Mapping[str, Any]]:
        """The offered settings, coarse to fine; `fewest` equal steps where none are offered."""
        if not hasattr(self.integrator, "settings"):
            return [{"step": duration / fewest, "save_every": fewest}]
        return valid_settings(list(self.integrator.settings(problem, duration)), duration)

    def timed(self, problem: Problem, duration: float, setting: Mapping[str, Any]) -> TimedRun:
        """A run that measures its own time."""

        def ask(repeats: int) -> Any:
            try:
                return timed_run(self.integrator, problem, duration, setting, repeats)
            except ContenderError:
                raise
            except Exception as error:
                raise ContenderError(f"It raised {describe_error(error)}.") from None

        return TimedRun(self.name, problem, duration, dict(setting), ask, lambda why: None)

    def run(self, problem: Problem, duration: float, setting: Mapping[str, Any]) -> Trajectory:
        """A run at a setting."""
        return self.timed(problem, duration, setting)()
