"""Contenders that run as they are asked to, and are wrong, each in a way that must be seen."""

from __future__ import annotations

from typing import Any

import numpy as np

import galvi
from tests.suite.benchmarks.contenders_at_hand import Gauss


def altered(run: galvi.Trajectory, q: Any = None, p: Any = None) -> galvi.Trajectory:
    """The run with other states."""
    q, p = (run.q if q is None else q), (run.p if p is None else p)
    return galvi.Trajectory(run.problem, run.t, q, p, counts=run.counts)


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


class Mirrored(Gauss):
    """Its momenta have the other sign."""

    name = "mirrored"

    def run(self, problem: galvi.Problem, duration: float, setting: Any) -> galvi.Trajectory:
        run = super().run(problem, duration, setting)
        return altered(run, p=-run.p)


class Heavy(Gauss):
    """Its momenta are a hundredth too large, but for the first."""

    name = "heavy"

    def run(self, problem: galvi.Problem, duration: float, setting: Any) -> galvi.Trajectory:
        run = super().run(problem, duration, setting)
        return altered(run, p=np.concatenate([run.p[:1], 1.01 * run.p[1:]]))


class Moved(Gauss):
    """Its first state is its last."""

    name = "moved"

    def run(self, problem: galvi.Problem, duration: float, setting: Any) -> galvi.Trajectory:
        run = super().run(problem, duration, setting)
        return altered(run, *(np.concatenate([x[-1:], x[1:]]) for x in (run.q, run.p)))


class Aliased(Gauss):
    """Every state that it saves is the same array."""

    name = "aliased"

    def run(self, problem: galvi.Problem, duration: float, setting: Any) -> galvi.Trajectory:
        run = super().run(problem, duration, setting)
        return altered(run, *(np.stack([x[-1]] * len(x)) for x in (run.q, run.p)))


class Between(Gauss):
    """Right at the ends only."""

    name = "between"

    def run(self, problem: galvi.Problem, duration: float, setting: Any) -> galvi.Trajectory:
        run = super().run(problem, duration, setting)
        q = run.q.copy()
        q[1:-1] = 7.0
        return altered(run, q)


class Single(Gauss):
    """A single setting, and a motion that is a thousandth wrong."""

    name, order = "single", None

    def settings(self, problem: galvi.Problem, duration: float) -> list[dict[str, Any]]:
        return super().settings(problem, duration)[-1:]

    def run(self, problem: galvi.Problem, duration: float, setting: Any) -> galvi.Trajectory:
        run = super().run(problem, duration, setting)
        return altered(run, run.q + 1e-3 * (run.q - run.q[0]))


class Unseen(Gauss):
    """It conserves what none of its problems has, and what nobody can."""

    name = "unseen"
    conserves = {"angular momentum": 1e-30}  # noqa: RUF012

    def supports(self, problem: galvi.Problem) -> bool:
        return problem.name.startswith("planar pendulum")


class Erratic(Gauss):
    """Errors that follow no power of the step, all of them small."""

    name = "erratic"

    def run(self, problem: galvi.Problem, duration: float, setting: Any) -> galvi.Trajectory:
        run = super().run(problem, duration, setting)
        noise = 10.0 ** np.random.default_rng(round(duration / setting["step"])).uniform(-7, -2)
        return altered(run, np.concatenate([run.q[:-1], run.q[-1:] + noise * setting["step"]]))


class FineFirst(Gauss):
    """Its settings go from fine to coarse."""

    name = "fine first"

    def settings(self, problem: galvi.Problem, duration: float) -> list[dict[str, Any]]:
        return super().settings(problem, duration)[::-1]


class Remembering(Gauss):
    """It runs once, and returns what it has."""

    name = "remembering"

    def __init__(self) -> None:
        self.known: dict[Any, galvi.Trajectory] = {}

    def run(self, problem: galvi.Problem, duration: float, setting: Any) -> galvi.Trajectory:
        key = (problem.name, duration, *setting.items())
        if key not in self.known:
            self.known[key] = super().run(problem, duration, setting)
        return self.known[key]


WRONG = {  # with a quantity of a row that must show it, and words of its reason
    Still: ("error at its finest over the way from the start", "Furthest from the truth"),
    Mirrored: ("runs and answers that failed", "Its first p must be the problem's start"),
    Heavy: ("error at its finest over that at its coarsest", "What becomes no better"),
    Moved: ("runs and answers that failed", "Its first q must be the problem's start"),
    Aliased: ("runs and answers that failed", "Its first q must be the problem's start"),
    Between: ("error at its finest over the way from the start", "its configuration"),
    Single: ("error at its finest over that at its coarsest", "It offers one setting"),
    Erratic: ("order in the step", "follow no power of the step"),
    FineFirst: ("runs and answers that failed", "must go from coarse to fine"),
}
