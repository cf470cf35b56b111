"""SciPy's solve_ivp: RK45 (Dormand-Prince 5(4), MATLAB's ode45), DOP853 and Radau."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np
import scipy

from galvi import Canonical, NBody, Problem, Trajectory, input_checks
from galvi.arrays import Array
from references.as_trajectory import Failure, as_trajectory
from references.contender import times_of_run
from references.newton import acceleration
from references.setting import described

DEFAULT: Mapping[str, Any] = {}
TIGHT: Mapping[str, Any] = {"rtol": 3e-14, "atol": 1e-15}
SETTINGS = ("tolerance", "rtol", "atol", "first_step", "max_step")


@dataclass(frozen=True)
class ScipyIvp:
    """One method of solve_ivp on (q, v)' = (v, a(q, v, t)), external forces included.

    Setting: samples; rtol, atol, or tolerance for both; first_step, max_step as in SciPy. The
    defaults, rtol 1e-3 and atol 1e-6, are SciPy's and ode45's and leave about three digits: add
    TIGHT for a truth. The run's `method` names the tolerances, and its `status` says so where rtol
    is the default. States between steps come from SciPy's interpolant, whose order is below the
    method's: ask for one sample where only the end matters.
    """

    fixed_step: ClassVar[bool] = False

    name: str
    solver: str
    order: int
    exact: bool = False
    missing: str = ""

    def supports(self, problem: Problem) -> bool:
        """Any system on a vector space with L = v.M v / 2 - V, whatever acts on it."""
        return isinstance(problem.system, (Canonical, NBody))

    def run(self, problem: Problem, duration: float, setting: Mapping[str, Any]) -> Trajectory:
        """Adaptive steps; see `Contender`."""
        shape, accelerated = problem.q0.shape, acceleration(problem)
        return run_on_coordinates(
            self,
            problem,
            duration,
            setting,
            lambda q, v, t: accelerated(q.reshape(shape), v.reshape(shape), t).ravel(),
        )


def run_on_coordinates(
    contender: Any,
    problem: Problem,
    duration: float,
    setting: Mapping[str, Any],
    accelerated: Callable[[Array, Array, float], Array],
) -> Trajectory:
    """The run of a contender's solver on (q, v)' = (v, accelerated(q, v, t)), (d,) each."""
    times, d = times_of_run(contender, problem, duration, setting, *SETTINGS), problem.q0.size

    def slope(t: float, y: Array) -> Array:
        return np.concatenate([y[d:], accelerated(y[:d], y[d:], t)])

    start = np.concatenate([problem.q0.ravel(), problem.v0.ravel()])
    states, calls, failure = solve(contender.solver, slope, times, start, setting)
    return as_trajectory(
        problem,
        described(contender.name, with_tolerances(setting), f"scipy {scipy.__version__}"),
        times,
        states[:, :d],
        states[:, d:],
        counts={"force_evaluations": calls},
        failure=failure,
        notes=[accuracy_note(setting)],
    )


def solve(
    solver: str, slope: Any, times: Array, start: Array, setting: Mapping[str, Any]
) -> tuple[Array, int, Failure | None]:
    """States (saved, n) of y' = slope(t, y), NaN past a failure; the number of calls of slope; the
    failure, or None."""
    from scipy.integrate import solve_ivp  # would lengthen the import of the references by a fifth

    options = tolerances(setting)
    for key in ("first_step", "max_step"):
        if key in setting:
            options[key] = input_checks.positive(key, setting[key])
    with np.errstate(all="ignore"):  # as_trajectory looks for non-finite states itself
        solved = solve_ivp(slope, (times[0], times[-1]), start, solver, t_eval=times, **options)
    states = np.full((len(times), start.size), np.nan)
    states[: solved.y.shape[1]] = solved.y.T
    return states, int(solved.nfev), None if solved.success else _failure(solved)


def tolerances(setting: Mapping[str, Any]) -> dict[str, float]:
    """rtol and atol of a setting, or SciPy's defaults; ValueError unless positive."""
    fallback = {"rtol": 1e-3, "atol": 1e-6}
    if "tolerance" in setting:
        fallback = dict.fromkeys(fallback, input_checks.positive("tolerance", setting["tolerance"]))
    explicit = {key: input_checks.positive(key, setting[key]) for key in fallback if key in setting}
    return {**fallback, **explicit}


def with_tolerances(setting: Mapping[str, Any]) -> dict[str, Any]:
    """The setting with both tolerances, SciPy's defaults where it has none; unchanged if it has the
    key "tolerance"."""
    return dict(setting) if "tolerance" in setting else {**setting, **tolerances(setting)}


def accuracy_note(setting: Mapping[str, Any]) -> str:
    """A note that a run with SciPy's default relative tolerance is no truth; "" for a setting with
    tolerance or rtol."""
    if "tolerance" in setting or "rtol" in setting:
        return ""
    return (
        f"With SciPy's default tolerance rtol = {tolerances(setting)['rtol']:g} some three digits "
        f"are right: for a truth, set rtol={TIGHT['rtol']:g} and atol={TIGHT['atol']:g}."
    )


def _failure(solved: Any) -> Failure:
    row = solved.y.shape[1]
    return Failure(
        row=row,
        step=row,
        why=f"SciPy gave up before sample {row}: {solved.message} Forces grew beyond bound there, "
        "as where bodies meet, or the tolerance cannot be reached; end the run earlier or loosen "
        "it.",
    )


ODE45 = ScipyIvp("SciPy RK45 (ode45)", solver="RK45", order=5)
DOP853 = ScipyIvp("SciPy DOP853", solver="DOP853", order=8)
RADAU = ScipyIvp("SciPy Radau", solver="Radau", order=5)
