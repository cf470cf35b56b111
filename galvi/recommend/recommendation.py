"""The degree and step recommended for an error, and the candidates that were tried."""

from __future__ import annotations

import math
from dataclasses import dataclass

from galvi.method import Galerkin


@dataclass(frozen=True)
class Candidate:
    """One degree and step that a scan tried; error and costs are those of the whole duration.

    With a clock, lengths of time are in its units.

    Attributes
    ----------
    degree
        s of Galerkin(Polynomials(s), gauss(s))
    steps, step
        N and h, with N h the duration
    error
        largest distance from a better run at any time, in the problem's unit of length; the
        measured error times (duration / measured)^power; infinite for a failure
    measured
        length of the part over which it was measured
    growth
        power of time with which the measured error grew over its last three quarters
    seconds
        time of one run; for possible choices, measured again in interleaved runs
    evaluations
        evaluations of the force; one of its Jacobian counts as many as there are coordinates
    status
        the reason why the error is unknown; "" where it is known
    newton
        share of the steps that only Newton's method solved: smaller steps may cost less
    parted
        time after which the two compared runs differ too much; infinite if they never do
    stopped
        time at which the run stopped since a force reached its limit; else infinite
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
    newton: float = 0.0
    parted: float = math.inf
    stopped: float = math.inf

    def cost(self, by: str) -> float:
        """Seconds when ``by`` is "time", else evaluations."""
        return self.seconds if by == "time" else self.evaluations


@dataclass(frozen=True)
class Recommendation:
    """The cheapest degree and step found that stay within an error.

    ``galvi.integrate(problem, choice.method, choice.step, duration=choice.duration)`` is the run.

    Attributes
    ----------
    method
        a `galvi.Galerkin`
    step, steps
        h and N, with N h the duration; with a clock h is in its units and N is approximate
    duration
        length of the run
    asked
        the required error
    error
        estimated error over the duration, see ``Candidate``; infinite if unknown
    seconds
        time of the run on this machine
    evaluations
        evaluations of the force in the run, see ``Candidate``
    reached
        whether ``error`` is at most ``asked`` and reliable; if not, this is the most accurate
        candidate found
    status
        a sentence: how the error was obtained, or why it was not reached and the remedy
    measured
        length over which the error was measured; beyond, it is extrapolated
    scanned
        all candidates tried, in order

    Examples
    --------
    >>> problem = galvi.problems.kepler(0.3)
    >>> choice = galvi.recommend(problem, error=1e-6, duration=30.0, by="evaluations")
    >>> run = galvi.integrate(problem, choice.method, choice.step, choice.steps)
    >>> bool(np.isclose(run.t[-1], choice.duration))
    True
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
        unit = "" if self.method.clock is None else " of its clock"
        return (
            f"{self.method.name}, {self.steps} steps of {self.step:.6g}{unit}: "
            f"error {self.error:.1g} after {self.duration:.6g}, "
            f"for {self.evaluations:.2g} force evaluations. {self.status}"
        )
