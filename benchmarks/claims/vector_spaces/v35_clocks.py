"""V35: constant steps in clocks: orders, forms, ways back, momenta and energies."""

from __future__ import annotations

from typing import Any

import numpy as np

import galvi
from benchmarks.claims.kit import (
    Fault,
    MakeMethod,
    Problem,
    Report,
    collocation,
    convergence_fits,
    fewer,
    scaled,
    with_arguments,
)
from references.closed_forms.kepler import KEPLER
from references.scipy.ivp import DOP853
from references.scipy.lagrangian_ivp import LAGRANGIAN_DOP853
from references.stored.encounters import kozai_triple

STARS = Problem(
    galvi.NBody(np.array([1.0, 0.5, 0.7])),
    np.array([[-0.05, 0.0, 0.0], [0.95, 0.0, 0.1], [-0.45, 3.5, 0.0]]),
    np.array([[0.0, -0.3, 0.0], [0.0, 0.7, 0.0], [-0.6, 0.0, 0.1]]),
    name="three stars, two of them close",
)
QUICK_STEPS = 250_000  # steps of the long run in the quick form


def facing(q: Any) -> Any:
    """The function g of a clock, on the angle q[1]."""
    return 1.0 / (2.0 + np.cos(q[1]))


def clocks() -> dict[str, tuple[Problem, Any, Any, float, float]]:
    """Name -> (problem, clock, truth, longest step, duration T)."""
    swing = galvi.problems.elastic_pendulum()
    return {
        "DynamicalTime": (STARS, galvi.DynamicalTime(), DOP853, 0.5, 4.0),
        "Sundman": (galvi.problems.kepler(0.5), galvi.Sundman(), KEPLER, 0.5, 6.0),
        "Clock of a function": (swing, galvi.Clock(facing), LAGRANGIAN_DOP853, 0.3, 2.0),
    }


def measure(make_method: MakeMethod, quick: bool, report: Report) -> dict[str, Any]:
    """Orders, defects and round-trip errors in each clock; momenta; and the energy in a long
    run."""
    numbers: dict[str, Any] = {}
    for name, (problem, clock, truth, longest, duration) in clocks().items():
        report(name)
        methods = {s: collocation(make_method, s, galvi.Cayley(), clock) for s in (2, 3, 4)}
        setting = {"samples": 200} | ({} if truth.exact else {"tolerance": 1e-13})
        exact = truth.run(problem, duration, setting)
        sizes = [longest * share for share in (1.0, 0.8, 0.625, 0.5)]
        for s, method in methods.items():
            runs = [galvi.integrate(problem, method, h, duration=duration) for h in sizes]
            if s < 4:
                quantity, errors = "error at the end", [run.q[-1] - exact.q[-1] for run in runs]
            else:
                quantity, errors = "curve between steps", [run(exact.t) - exact.q for run in runs]
            order = convergence_fits.slope(sizes, [np.max(abs(error)) for error in errors])
            numbers[f"order of the {quantity}, {name}, {s} stages"] = order
        defect = galvi.symplecticity_defect(problem, methods[2], longest)
        back = galvi.round_trip_error(problem, methods[2], longest, 20)
        numbers[f"defect of DF^T J DF = J, in (q, t; p, -E), {name}"] = defect
        numbers[f"distance from the start after as many steps back, {name}"] = back
    report("momenta and a long run")
    two, eight = (
        collocation(make_method, s, galvi.Cayley(), galvi.DynamicalTime()) for s in (2, 8)
    )
    run = galvi.integrate(STARS, two, 0.5, 200)
    linear, angular = run.p.sum(axis=1), np.cross(run.q, run.p).sum(axis=1)
    steps = QUICK_STEPS if quick else 2_500_000
    run = galvi.integrate(kozai_triple(), eight, 0.4, steps, save_every=steps // 400)
    change = abs(galvi.energy(run) / galvi.energy(run)[0] - 1.0)
    first = np.max(change[:5])
    return numbers | {
        "change of the linear momentum": np.max(abs(linear - linear[0])),
        "change of the angular momentum": np.max(abs(angular - angular[0])),
        "largest error of the energy": np.max(change),
        "growth of the energy's error": np.max(change) / first if first else np.nan,
    }


def without_slope(original: Any) -> Any:
    """The transformed problem with g constant under differentiation, as with an adaptive step that
    is chosen from outside, for a planted fault."""

    def wrong(in_tau: Any, driven: bool, t0: float) -> Problem:
        if in_tau.base_slopes is None:
            return original(in_tau, driven, t0)
        in_tau.slope = np.zeros_like
        system = galvi.Lagrangian(in_tau.value, in_tau.base.group, in_tau.slopes, check=False)
        q, u = in_tau.start
        return Problem(system, q, u, t0)

    return wrong


def other_energy(problem: Problem, method: Any, energy: float, *options: Any) -> tuple[Any, ...]:
    return problem, method, energy * (1.0 + 1e-6), *options


CLOCKED = "galvi.run.clocked"
FAULTS = {
    "g without its slope": Fault(
        wrong={f"{CLOCKED}.transformed.in_clock": without_slope, **fewer(__name__, QUICK_STEPS=400)}
    ),
    "the energy off by 1e-6": Fault(
        wrong={
            f"{CLOCKED}.in_lanes.energy_of": scaled(1.0 + 1e-6),
            # without its cache
            f"{CLOCKED}.in_lanes._motion": lambda original: original.__wrapped__,
            f"{CLOCKED}.run.motion_in_transformed_time": with_arguments(other_energy),
            **fewer(__name__, QUICK_STEPS=400),
        }
    ),
}
