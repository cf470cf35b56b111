"""The degree and step recommended for an error, and the candidates that were tried."""

from __future__ import annotations

from dataclasses import dataclass

from galvi.method import Galerkin


@dataclass(frozen=True)
class Candidate:
    """One degree and step that a scan tried; error and costs are those of the whole duration.

    degree       s of Galerkin(Polynomials(s), gauss(s))
    steps, step  N and h, with N h the duration
    error        largest distance from a better run at any time, in the problem's unit of length;
                 what was measured, times (duration / measured)^power; infinite for a failure
    measured     how much of the duration was run to find it
    growth       power of time that the measured error grew with over its last three quarters
    seconds      of one run; measured once, and by interleaved runs for those that could be chosen
    evaluations  of the force; one of its Jacobian counts as many as there are coordinates
    status       empty, or why it has no error
    """

    degree: int
    steps: int
    step: float
    error: float
    measured: float
    growth: float
    seconds: float
    evaluations: float
    status: str = ""

    def cost(self, by: str) -> float:
        """Seconds when ``by`` is "time", else evaluations."""
        return self.seconds if by == "time" else self.evaluations


@dataclass(frozen=True)
class Recommendation:
    """The cheapest way that was found to stay within an error.

    ``galvi.integrate(problem, choice.method, choice.step, choice.steps)`` is the run.

    method       a `galvi.Galerkin`
    step, steps  h and N, with N h the duration
    duration     length of time that it is meant for
    asked        the error asked for
    error        estimated, over the duration, see `Candidate`; infinite where nothing is known
    seconds      that the run takes on this machine
    evaluations  of the force in the run, see `Candidate`
    reached      whether ``error`` is at most ``asked`` and can be relied on; if not, this is the
                 most accurate found
    status       a sentence: what the error rests on, or why it was not reached and the remedy
    measured     how much of the duration the error was measured over, the rest is extrapolated
    scanned      all that was tried, in order
    """

    method: Galerkin
    step: float
    steps: int
    duration: float
    asked: float
    error: float
    seconds: float
    evaluations: float
    reached: bool
    status: str
    measured: float
    scanned: tuple[Candidate, ...]

    def __str__(self) -> str:
        return (
            f"{self.method.name}, {self.steps} steps of {self.step:.6g}: error {self.error:.1g} "
            f"after {self.duration:.6g}, for {self.evaluations:.2g} force evaluations. "
            f"{self.status}"
        )
