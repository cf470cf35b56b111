"""Somebody else's contenders without a process of their own, so that tests of what is made of their
answers are quick; `tests/suite/benchmarks/test_contender_process.py` has the processes.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

import galvi
from benchmarks.applications.external.check_problems import CHECK_PROBLEMS
from benchmarks.applications.external.checks import contender_checks
from benchmarks.applications.external.integrator import ExternalIntegrator
from benchmarks.applications.external.loading import ContenderError, describe_error, metadata
from benchmarks.applications.external.worker import ANSWERS


@dataclass(eq=False)
class Inside(ExternalIntegrator):
    """An external integrator whose contender is at hand; its memory, which is that of the tests, is
    looked at where `watched`."""

    contender: Any = None
    watched: bool = False

    @classmethod
    def of(cls, contender: Any) -> Inside:
        """Like `ExternalIntegrator.open`."""
        external = cls("inside:It", contender=contender)
        external._declare(metadata(contender))
        return external

    def _ask(self, question: str, *arguments: Any, tried: bool = False) -> Any:
        if question == "memory growth" and not self.watched:
            return 0.0  # of this process, and a second or two
        try:
            return ANSWERS[question](self.contender, *arguments)
        except ContenderError:
            raise
        except Exception as error:
            raise ContenderError(f"It raised {describe_error(error)}.") from None


class Gauss:
    """galvi's, as if somebody else's; supports everything."""

    name, order = "a gauss", 4
    conserves = {"energy": 1e-3, "angular momentum": 1e-11}  # noqa: RUF012

    def supports(self, problem: galvi.Problem) -> bool:
        return True

    def settings(self, problem: galvi.Problem, duration: float) -> list[dict[str, Any]]:
        short = duration / 40 if duration < 10.0 else 0.15 if duration < 1e3 else 20.0
        steps = max(1, round(duration / short))
        return [{"step": duration / n, "save_every": n} for n in (steps, 2 * steps)]

    def run(self, problem: galvi.Problem, duration: float, setting: Any) -> galvi.Trajectory:
        method = galvi.Galerkin(galvi.Polynomials(2), galvi.gauss(2))
        steps, every = round(duration / setting["step"]), setting["save_every"]
        return galvi.integrate(problem, method, setting["step"], steps, save_every=every)


class Raising(Gauss):
    name = "raising"

    def run(self, problem: galvi.Problem, duration: float, setting: Any) -> galvi.Trajectory:
        raise RuntimeError("no, thanks")


class Flat(Gauss):
    name = "flat"

    def run(self, problem: galvi.Problem, duration: float, setting: Any) -> galvi.Trajectory:
        run = super().run(problem, duration, setting)
        return galvi.Trajectory(problem, run.t, run.q.reshape(len(run.t), -1, 1), run.p)


class Silent(Gauss):
    """Its states are not finite, and it says nothing of that."""

    name = "silent"

    def run(self, problem: galvi.Problem, duration: float, setting: Any) -> galvi.Trajectory:
        run = super().run(problem, duration, setting)
        return galvi.Trajectory(problem, run.t, run.q * np.nan, run.p)


class Failing(Gauss):
    """It says that it failed, and why."""

    name = "failing"

    def run(self, problem: galvi.Problem, duration: float, setting: Any) -> galvi.Trajectory:
        run = super().run(problem, duration, setting)
        return galvi.Trajectory(
            problem, run.t, run.q * np.nan, run.p * np.nan, success=False, status="Out of luck."
        )


BROKEN = {
    Raising: "It raised RuntimeError: no, thanks.",
    Flat: "Its q must have the shape",
    Silent: "It says that it succeeded, and its states are not finite.",
    Failing: "Out of luck.",
}
ORBIT, SWING = (
    next(one for one in CHECK_PROBLEMS if one.problem.name.startswith(name))
    for name in ("kepler", "planar pendulum")
)


def checked(contender, *check_problems):
    """A contender's rows, those of them that differ from what is expected, and itself."""
    external = Inside.of(contender)
    (claim,) = contender_checks([external], check_problems or (ORBIT,))
    rows = claim.judge(claim.study(galvi.Galerkin, True, lambda sentence: None))
    assert {row.id for row in rows} == {claim.id} and len({row.quantity for row in rows}) == len(
        rows
    )
    return rows, [row for row in rows if row.verdict != row.expected], external
