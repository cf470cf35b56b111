"""Users' contenders, correct and wrong, that run in this process, so that tests of the checks are
quick; `test_contender_process.py` tests contenders in processes of their own.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np

import galvi
from benchmarks.applications.external.check_problems import CHECK_PROBLEMS
from benchmarks.applications.external.checks import contender_checks
from benchmarks.applications.external.integrator import ExternalIntegrator
from benchmarks.applications.external.loading import ContenderError, describe_error, metadata
from benchmarks.applications.external.worker import ANSWERS


@dataclass(eq=False)
class Inside(ExternalIntegrator):
    """An external integrator whose contender runs in this process. Its memory is measured only if
    `watched`."""

    contender: Any = None
    watched: bool = False

    @classmethod
    def of(cls, contender: Any) -> Inside:
        """Like `ExternalIntegrator.open`."""
        external = cls("inside:It", contender=contender)
        external._declare(metadata(contender))
        return external

    def _ask(self, question: str, *arguments: Any, is_trial: bool = False) -> Any:
        if question == "memory growth" and not self.watched:
            return 0.0  # it would be that of this process, and take a second or two
        try:
            return ANSWERS[question](self.contender, *arguments)
        except ContenderError:
            raise
        except Exception as error:
            raise ContenderError(f"It raised {describe_error(error)}.") from None


class Gauss:
    """galvi's collocation as a user's contender; supports every problem."""

    name, order = "a gauss", 4
    conserves = {"energy": 1e-3, "angular momentum": 1e-11}  # noqa: RUF012

    def supports(self, problem: galvi.Problem) -> bool:
        return True

    def settings(self, problem: galvi.Problem, duration: float) -> list[dict[str, Any]]:
        short = duration / 40 if duration < 10.0 else 0.15 if duration < 1e3 else 20.0
        steps = max(1, round(duration / short))
        return [{"step": duration / n, "save_every": n} for n in (steps, 2 * steps)]

    method = galvi.Galerkin(galvi.Polynomials(2), galvi.gauss(2))

    def run(self, problem: galvi.Problem, duration: float, setting: Any) -> galvi.Trajectory:
        steps, save_every = round(duration / setting["step"]), setting["save_every"]
        return galvi.integrate(problem, self.method, setting["step"], steps, save_every=save_every)


class Stepped(Gauss):
    """Compositions of leapfrog; `strength` is a factor of the force, 1 in a correct one."""

    name, order, strength = "leapfrog", 2, 1.0
    conserves = {"energy": 0.02, "angular momentum": 1e-11}  # noqa: RUF012
    step_counts: ClassVar[tuple[int, ...]] = (250, 1000)
    weights: Sequence[float] = (1.0,)

    def settings(self, problem: galvi.Problem, duration: float) -> list[dict[str, Any]]:
        return [{"step": duration / n, "save_every": n} for n in self.step_counts]

    def pull(self, problem: galvi.Problem, q: Any, t: float) -> Any:
        return self.strength * problem.system.acceleration(q, t)

    def advanced(self, problem: galvi.Problem, q: Any, v: Any, t: float, h: float) -> Any:
        for w in self.weights:
            q = q + 0.5 * w * h * v
            v = v + w * h * self.pull(problem, q, t + 0.5 * h)
            q = q + 0.5 * w * h * v
        return q, v

    def run(self, problem: galvi.Problem, duration: float, setting: Any) -> galvi.Trajectory:
        h, save_every, q, v = setting["step"], setting["save_every"], problem.q0, problem.v0
        saved = [(q, v)]
        for k in range(round(duration / h)):
            q, v = self.advanced(problem, q, v, problem.t0 + k * h, h)
            saved += [(q, v)] if (k + 1) % save_every == 0 else []
        q, v = np.swapaxes(saved, 0, 1)
        t = problem.t0 + h * save_every * np.arange(len(q))
        counts = {"steps": k + 1}
        return galvi.Trajectory(problem, t, q, problem.system.momentum(v), counts=counts)


class OneSided(Stepped):
    """The symplectic Euler method, which is not symmetric."""

    name, order = "one-sided", 1
    conserves = {"energy": 1e-3, "angular momentum": 1e-11}  # noqa: RUF012
    settings = Gauss.settings

    def advanced(self, problem: galvi.Problem, q: Any, v: Any, t: float, h: float) -> Any:
        v = v + h * self.pull(problem, q, t)
        return q + h * v, v


class Drifting(Stepped):
    """The explicit Euler method, which gains energy and declares that it conserves it."""

    name, order, step_counts = "drifting", 1, (300, 1200)
    conserves = {"energy": 0.02}  # noqa: RUF012

    def advanced(self, problem: galvi.Problem, q: Any, v: Any, t: float, h: float) -> Any:
        return q + h * v, v + h * self.pull(problem, q, t)


class WithoutSteps(Gauss):
    """Its settings have tolerances instead of steps, and it declares an order."""

    conserves: ClassVar[dict[str, float]] = {}

    def settings(self, problem: galvi.Problem, duration: float) -> list[dict[str, Any]]:
        return [{"tolerance": 1e-6}, {"tolerance": 1e-9}]

    def run(self, problem: galvi.Problem, duration: float, setting: Any) -> galvi.Trajectory:
        step = duration / setting["samples"] / 40
        return super().run(problem, duration, {"step": step, "save_every": 40})


class WithoutLongRuns(WithoutSteps):
    """It raises in runs longer than 5."""

    def run(self, problem: galvi.Problem, duration: float, setting: Any) -> galvi.Trajectory:
        if duration > 5.0:
            raise RuntimeError("too long")
        return super().run(problem, duration, setting)


class Still(Gauss):
    """It does not move, and conserves everything."""

    name, order = "still", None

    def settings(self, problem: galvi.Problem, duration: float) -> list[dict[str, Any]]:
        return [{"samples": 1}]

    def run(self, problem: galvi.Problem, duration: float, setting: Any) -> galvi.Trajectory:
        count = setting["samples"] + 1
        t = problem.t0 + duration * np.arange(count) / setting["samples"]
        q, p = (np.array([start] * count) for start in (problem.q0, problem.p0))
        return galvi.Trajectory(problem, t, q, p)


class Single(Gauss):
    """A single setting, and a motion that is a thousandth wrong."""

    name, order = "single", None

    def settings(self, problem: galvi.Problem, duration: float) -> list[dict[str, Any]]:
        return super().settings(problem, duration)[-1:]

    def run(self, problem: galvi.Problem, duration: float, setting: Any) -> galvi.Trajectory:
        run = super().run(problem, duration, setting)
        return altered(run, q=run.q + 1e-3 * (run.q - run.q[0]))


class FineFirst(Gauss):
    """Its settings go from fine to coarse."""

    name = "fine first"

    def settings(self, problem: galvi.Problem, duration: float) -> list[dict[str, Any]]:
        return super().settings(problem, duration)[::-1]


class Unseen(Gauss):
    """It declares angular momentum to 1e-30, which none of its problems conserves."""

    name = "unseen"
    conserves = {"angular momentum": 1e-30}  # noqa: RUF012

    def supports(self, problem: galvi.Problem) -> bool:
        return problem.name.startswith("planar pendulum")


class Choosy(Gauss):
    """It supports nothing."""

    def supports(self, problem: galvi.Problem) -> bool:
        return False


class Unsure(Gauss):
    """It does not know what it supports."""

    def supports(self, problem: galvi.Problem) -> bool:
        raise OSError("who knows")


class Bare(Gauss):
    """It offers no setting."""

    def settings(self, problem: galvi.Problem, duration: float) -> list[dict[str, Any]]:
        return []


class Altered(Gauss):
    """Its runs are changed by a function before they are returned."""

    def __init__(self, change: Callable[[galvi.Trajectory], galvi.Trajectory]) -> None:
        self.change, self.name = change, change.__name__.replace("_", " ")

    def run(self, problem: galvi.Problem, duration: float, setting: Any) -> galvi.Trajectory:
        return self.change(super().run(problem, duration, setting))


def altered(run: galvi.Trajectory, **parts: Any) -> galvi.Trajectory:
    """A new trajectory of the run's problem, t, q, p and counts, with `parts` in their place."""
    parts_of_run = {name: getattr(run, name) for name in ("problem", "t", "q", "p", "counts")}
    return galvi.Trajectory(**(parts_of_run | parts))


class Broken(Altered):
    """A contender each of whose runs is spoilt."""

    def __init__(self) -> None:
        super().__init__(self.spoilt)
        self.name = type(self).name


class Raising(Broken):
    name = "raising"

    def spoilt(self, run: galvi.Trajectory) -> galvi.Trajectory:
        raise RuntimeError("no, thanks")


class Flat(Broken):
    name = "flat"

    def spoilt(self, run: galvi.Trajectory) -> galvi.Trajectory:
        return altered(run, q=run.q.reshape(len(run.t), -1, 1))


class Silent(Broken):
    """Its states are not finite, although it reports success."""

    name = "silent"

    def spoilt(self, run: galvi.Trajectory) -> galvi.Trajectory:
        return altered(run, q=run.q * np.nan)


class Failing(Broken):
    """It reports that it failed, and why."""

    name = "failing"

    def spoilt(self, run: galvi.Trajectory) -> galvi.Trajectory:
        failure = {"success": False, "status": "Out of luck."}
        return altered(run, q=run.q * np.nan, p=run.p * np.nan, **failure)


def mirrored(run: galvi.Trajectory) -> galvi.Trajectory:
    """Momenta of the other sign."""
    return altered(run, p=-run.p)


def heavy(run: galvi.Trajectory) -> galvi.Trajectory:
    """Momenta that are a hundredth too large, but for the first."""
    return altered(run, p=np.concatenate([run.p[:1], 1.01 * run.p[1:]]))


def swapped_start(run: galvi.Trajectory) -> galvi.Trajectory:
    """The first state is the last."""
    return altered(
        run, **{name: np.concatenate([x[-1:], x[1:]]) for name, x in (("q", run.q), ("p", run.p))}
    )


def aliased(run: galvi.Trajectory) -> galvi.Trajectory:
    """Every saved state is the last one, as if one array were saved."""
    return altered(
        run, **{name: np.stack([x[-1]] * len(x)) for name, x in (("q", run.q), ("p", run.p))}
    )


def between(run: galvi.Trajectory) -> galvi.Trajectory:
    """Correct at both ends only."""
    return altered(run, q=np.concatenate([run.q[:1], 0.0 * run.q[1:-1] + 7.0, run.q[-1:]]))


def erratic(run: galvi.Trajectory) -> galvi.Trajectory:
    """Errors that follow no power of the step, all of them small."""
    noise = 10.0 ** np.random.default_rng(round((run.t[-1] - run.t[0]) / run.step)).uniform(-7, -2)
    return altered(run, q=np.concatenate([run.q[:-1], run.q[-1:] + noise * run.step]))


RANDOM = np.random.default_rng(5)


def unseeded(run: galvi.Trajectory) -> galvi.Trajectory:
    """Ends that differ from run to run by 1e-13."""
    relative = 1e-13 * RANDOM.standard_normal() * (run.t > run.t[0])
    return altered(run, q=run.q * (1.0 + relative[:, None]))


BROKEN = {
    Raising: "It raised RuntimeError: no, thanks.",
    Flat: "Its q must have the shape",
    Silent: "It says that it succeeded, and its states are not finite.",
    Failing: "Out of luck.",
}
ORBIT, SWING = (
    next(case for case in CHECK_PROBLEMS if case.problem.name.startswith(name))
    for name in ("kepler", "planar pendulum")
)


def checked(contender, *check_problems):
    """(rows of a contender, those with unexpected verdicts, its external integrator)."""
    external = Inside.of(contender)
    (claim,) = contender_checks([external], check_problems or (ORBIT,))
    rows = claim.check(claim.study(galvi.Galerkin, True, lambda sentence: None))
    assert {row.id for row in rows} == {claim.id} and len({row.quantity for row in rows}) == len(
        rows
    )
    return rows, [row for row in rows if row.verdict != row.expected], external
