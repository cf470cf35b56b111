"""The cost of a step: iterations, force evaluations, solver, seconds."""

from __future__ import annotations

import math
from collections.abc import Callable, Collection, Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Any, NamedTuple

import pandas as pd

import galvi
from benchmarks.statistics.timing import interleaved, warmed
from galvi import Problem, Trajectory
from references.stored import encounters

ROUNDS = 3


class Case(NamedTuple):
    """A method on a problem, with `steps` steps of size `step`, and events to search for."""

    problem: Problem
    method: galvi.Galerkin
    step: float
    steps: int
    events: Sequence[galvi.Event] = ()


class Cost(NamedTuple):
    """The run of a case, and its time in seconds."""

    case: Case
    run: Trajectory
    seconds: float

    def per_step(self, count: str) -> float:
        """One of the run's counts, per step."""
        return self.run.counts[count] / max(1, self.run.counts["steps"])


@dataclass(frozen=True)
class Column:
    """A column of cost.csv and of the table on the page.

    Attributes
    ----------
    name
        name in cost.csv
    value
        function of a Cost that returns the value
    heading
        heading on the page; "" for a column that is in cost.csv only
    kind
        "text", "number" or "seconds"
    """

    name: str
    value: Callable[[Cost], Any]
    heading: str = ""
    kind: str = "number"


def _solver(cost: Cost) -> str:
    """The solver, by Hessian evaluations: Newton evaluates it at each stage and pass."""
    counts = cost.run.counts
    newton = counts["hessian_evaluations"] / cost.case.method.stages
    if not newton:
        return "fixed point"
    return "Newton" if newton == counts["iterations"] else "Newton and fixed point"


def _seconds(cost: Cost) -> float:
    steps = max(1, cost.run.counts["steps"])
    return cost.seconds / steps if cost.run.success else math.nan


def _count(name: str) -> Column:
    return Column(name, lambda cost: cost.run.counts[name])


COLUMNS = (
    Column("problem", lambda cost: cost.case.problem.name, "problem", "text"),
    Column("method", lambda cost: cost.case.method.name, "method", "text"),
    Column("order", lambda cost: cost.case.method.order, "order"),
    Column("step", lambda cost: cost.case.step, "step"),
    Column("steps", lambda cost: cost.case.steps),
    Column("solver", _solver, "solver", "text"),
    Column("iterations_per_step", lambda cost: cost.per_step("iterations"), "iterations per step"),
    Column("forces_per_step", lambda cost: cost.per_step("force_evaluations"), "forces per step"),
    _count("force_evaluations"),
    _count("hessian_evaluations"),
    _count("linear_solves"),
    Column("seconds_per_step", _seconds, "time per step", "seconds"),
    Column("status", lambda c: "" if c.run.success else c.run.status, "status", "text"),
)


def cost_table(
    quick: bool = False,
    report: Callable[[str], None] = lambda sentence: None,
    only: Collection[str] = (),
) -> pd.DataFrame:
    """One row for each problem and method, at a step size typical of its use.

    Parameters
    ----------
    only
        names of the problems; () for all

    Notes
    -----
    Counts are exact for a build and machine. ``forces_per_step`` counts configurations; ``solver``
    is the solver of the stage equations: fixed point, Newton, or both. Seconds are those of a whole
    run divided by its steps.
    """
    runs, calls, warm_seconds = [], [], []
    cases = [case for case in _cases(quick) if not only or case.problem.name in only]
    for case in cases:
        report(f"{case.problem.name}: {case.method.name}")

        def call(case: Case = case) -> Trajectory:
            return galvi.integrate(
                case.problem,
                case.method,
                case.step,
                case.steps,
                save_every=case.steps,
                events=case.events,
            )

        run, seconds = warmed(call)
        runs.append(run)
        calls.append(call)
        warm_seconds.append(seconds)
    timings = interleaved(calls, ROUNDS, 0.01 if quick else 0.05, warm_seconds)
    costs = [
        Cost(case, run, timing.seconds)
        for case, run, timing in zip(cases, runs, timings, strict=True)
    ]
    return pd.DataFrame(
        [[column.value(cost) for column in COLUMNS] for cost in costs],
        columns=[column.name for column in COLUMNS],
    )


def _cases(quick: bool) -> list[Case]:
    """The cases: Gauss collocation at practical steps, H's methods at H's steps, clocks, events and
    forces."""
    oscillator, kepler = galvi.problems.harmonic_oscillator(), galvi.problems.kepler(0.6)
    planets = galvi.problems.solar_system()
    springs = galvi.problems.fermi_pasta_ulam_tsingou()
    steps = 1000 if quick else 10_000
    cases = [
        *((kepler, _gauss(s), math.tau / k, steps) for s, k in ((2, 256), (4, 64), (8, 24))),
        (kepler, _gauss(16), math.tau / 8, steps),
        *((planets, _gauss(s), h, steps) for s, h in ((4, 4.0), (8, 8.0), (16, 32.0))),
        (oscillator, _oversampled_gauss(16), 20.0, 1000),
        (oscillator, _oversampled_gauss(24), 20.0, 1000),
        (kepler, _oversampled_gauss(8), 2.0, 1000),
        (kepler, _oversampled_gauss(32), 2.0, 1000),
        (planets, _oversampled_gauss(25), 100.0, 100),
        (planets, _gauss(16, galvi.KeplerFrame()), 32.0, steps),
        (galvi.problems.outer_solar_system(), _gauss(16, galvi.KeplerFrame()), 400.0, steps),
        (springs, _gauss(8, galvi.HarmonicFrame()), 2.0, steps // 5),
        *_lagrangians_and_bodies(steps),
    ]
    return [*(Case(*case) for case in cases), *_clocks_events_and_forces(steps)]


def _clocks_events_and_forces(steps: int) -> Iterator[Case]:
    """Steps in clocks, and the outer planets with events that do not occur, and with forces."""
    degree_8, outer = _gauss(8), galvi.problems.outer_solar_system()
    yield Case(encounters.burrau(), replace(degree_8, clock=galvi.DynamicalTime()), 0.4, 400)
    yield Case(
        galvi.problems.kepler(0.99), replace(degree_8, clock=galvi.Sundman()), 0.4, steps // 10
    )
    events = [galvi.events.within(k, k + 1, 0.5) for k in (1, 2, 3)]
    with_events = replace(outer, name=f"{outer.name}, three events")
    yield Case(with_events, degree_8, 200.0, steps, events)
    sun_forces = (galvi.Oblateness(0, 2e-7, 0.00465), galvi.Relativity(173.145, form="potential"))
    for force in sun_forces:
        system = replace(outer.system, forces=[force])
        name = f"{outer.name}, {type(force).__name__.lower()}"
        yield Case(replace(outer, system=system, name=name), degree_8, 200.0, steps)
    yield Case(outer, degree_8, 200.0, steps)


def _lagrangians_and_bodies(steps: int) -> Iterator[tuple[Problem, galvi.Galerkin, float, int]]:
    """Other Lagrangians on R^d, and bodies, with as many points as the degree and with one more."""
    models = galvi.problems
    for problem, h in (
        (models.elastic_pendulum(), 0.1),
        (models.skew_arm(), 0.02),
        (models.skew_arm(floating=True), 0.1),
        (models.kepler_polar(), 0.5),
        (models.henon_heiles(), 1.0),
        (models.fermi_pasta_ulam_tsingou(), 2.0),
        (models.double_pendulum(), 0.03),
        (models.planar_chain(), 0.02),
        (models.heavy_top(), 0.15),
    ):
        yield problem, _gauss(8), h, steps // 5
    body, thrown = models.free_rigid_body(), models.free_body_se3()
    yield body, _gauss(6), 0.5, steps
    yield body, galvi.Galerkin(galvi.Polynomials(6), galvi.gauss(7)), 0.5, steps // 10
    yield thrown, _gauss(5), 0.25, steps // 10
    yield models.brownout(), _gauss(4), 0.02, 100
    yield models.brownout(drag_coefficient=None), _gauss(4), 0.02, 100


def _gauss(degree: int, *chart: Any) -> galvi.Galerkin:
    return galvi.Galerkin(galvi.Polynomials(degree), galvi.gauss(degree), *chart)


def _oversampled_gauss(n: int) -> galvi.Galerkin:
    """H's choice: n basis functions, Gauss with 2 n points."""
    return galvi.Galerkin(galvi.Polynomials(n - 1), galvi.gauss(2 * n))
