"""What every way of solving a problem offers, so that nothing downstream asks which one it is."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, Protocol, runtime_checkable

from galvi import Problem, Trajectory


@runtime_checkable
class Contender(Protocol):
    """A named way to solve a `galvi.Problem`.

    Fixed-step contenders take {"step": h, "save_every": k, ...}: states at t0 + j h, where the time
    is j h and never the engine's own clock. The others choose their steps and take
    {"samples": n, ...}: states at t0 + j duration / n, j = 0 .. n.
    """

    @property
    def name(self) -> str:
        """For titles and tables; unique among the references."""

    @property
    def exact(self) -> bool:
        """Whether it is fit to be the truth for others."""

    @property
    def missing(self) -> str:
        """One sentence saying why its engine cannot be used here; empty when it can."""

    def supports(self, problem: Problem) -> bool:
        """Whether it solves this problem, decided by types and fields, never by the name."""

    def run(self, problem: Problem, duration: float, setting: Mapping[str, Any]) -> Trajectory:
        """Solve from t0 to t0 + duration, in the problem's units of time.

        Raises ValueError for a problem it does not support, an unknown key in the setting or a
        value out of range, ModuleNotFoundError when the engine is missing. A run that fails returns
        with ``success`` False, a sentence, and NaN past the failure.
        """


def require(contender: Contender, problem: Problem) -> None:
    """Raise unless the contender can solve the problem here; errors as in `Contender.run`."""
    if not contender.supports(problem):
        raise ValueError(
            f"{contender.name} does not solve this kind of problem; received {problem!r} with a "
            f"{type(problem.system).__name__} system. Ask supports(problem) first."
        )
    if contender.missing:
        raise ModuleNotFoundError(f"{contender.name} cannot run: {contender.missing}")
