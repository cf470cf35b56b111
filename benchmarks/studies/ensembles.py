"""Ensembles: the gain by lanes, threads and workers, and peers at matched error.

Errors are the largest of the configurations of a few members at the end, against a closed form or
another engine. Of each code the cheapest setting that reaches the error is timed, in interleaved
rounds, in as many threads as there are processors; SciPy runs a few in one thread, and its time is
divided by the processors.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import ExitStack, contextmanager
from functools import partial
from importlib.util import find_spec
from typing import Any, NamedTuple

import numpy as np
import pandas as pd
from scipy.spatial.transform import Rotation

import galvi
from benchmarks.statistics.timing import Timing, interleaved
from galvi.run.ensemble import processors
from references import DOP853, FREE_TOP, KEPLER, RIGID_DOP853
from references.heyoka.taylor import HEYOKA_BATCHES, HEYOKA_ENSEMBLE
from references.mujoco.rollout import MUJOCO_ROLLOUT

ROUNDS, ROUND_SECONDS = 3, 0.05
MEMBERS, QUICK_MEMBERS = 1000, 200
CHECKED_MEMBERS = 3  # members whose error is measured
DEGREES = 6, 8, 9  # of galvi
STEPS = 4, 5, 6, 7, 8, 10, 12, 14, 16, 20, 24, 28, 34, 44, 56, 64, 96, 128, 192
SEED = 17
COLUMNS = ("part", "problem", "contender", "settings", "error", "target", "seconds", "low", "high",
           "microseconds", "relative")  # fmt: skip
EXPLANATION = (
    "First, members of one ensemble: a run of each by itself, then eight to an instruction, in "
    "threads and on the workers of a cluster on this machine. Then ensembles of other codes, "
    "each at its cheapest setting that reaches the error, in as many threads as there "
    "are processors; SciPy runs three members in one thread, and its time for a member is divided "
    "by the processors, as if it gained that much on them. The error is the largest of a "
    "configuration's entries at the end of a few members, against a closed form or another engine."
)
Call = Callable[[], Any]


class Ensemble(NamedTuple):
    """Members of a problem that all codes run.

    Attributes
    ----------
    target
        error that each has to reach
    truth
        final configurations of the first members
    """

    problem: galvi.Problem
    q: Any
    v: Any
    duration: float
    target: float
    truth: Any


class Candidate(NamedTuple):
    """A code at some settings, in order of increasing accuracy.

    Attributes
    ----------
    calls
        iterator of (setting as text, call that returns the final configurations)
    in_parallel
        whether a call runs all members; else it runs CHECKED_MEMBERS of them, in one thread
    """

    name: str
    calls: Iterator[tuple[str, Call]]
    in_parallel: bool = True


def ensembles(quick: bool, say: Callable[[str], None]) -> pd.DataFrame:
    """All parts of the study."""
    members = QUICK_MEMBERS if quick else MEMBERS
    rows = []
    for make in (free_bodies, pendulums, kepler_orbits):
        ensemble = make(members)
        say(f"{len(ensemble.q)} of {ensemble.problem.name}")
        rows += compared(ensemble)
    say("scaling")
    rows += scaling(kepler_orbits(32 * members))  # of a second or longer
    return pd.DataFrame(rows, columns=list(COLUMNS))


def _perturbed(problem: galvi.Problem, members: int, size: float) -> tuple[Any, Any]:
    changes = size * np.random.default_rng(SEED).standard_normal((2, members, *problem.q0.shape))
    return problem.q0 * (1.0 + changes[0]), problem.v0 * (1.0 + changes[1])


def _truth(
    contender: Any, problem: galvi.Problem, q: Any, v: Any, duration: float, **setting: Any
) -> Any:
    runs = [
        contender.run(problem.with_initial_state(*state), duration, {"samples": 1, **setting})
        for state in zip(q[:CHECKED_MEMBERS], v[:CHECKED_MEMBERS], strict=True)
    ]
    return np.stack([run.q[-1] for run in runs])


def _bodies(
    problem: galvi.Problem, members: int, duration: float, truth: Any, **setting: Any
) -> Ensemble:
    random = np.random.default_rng(SEED)
    q = Rotation.random(members, rng=random).as_matrix()
    v = problem.v0 * (1.0 + 0.1 * random.standard_normal((members, 3)))
    return Ensemble(
        problem, q, v, duration, 1e-8, _truth(truth, problem, q, v, duration, **setting)
    )


def free_bodies(members: int) -> Ensemble:
    """Free rigid bodies at random attitudes, 5 units of time."""
    return _bodies(galvi.problems.free_rigid_body(), members, 5.0, FREE_TOP)


def pendulums(members: int) -> Ensemble:
    """3D pendulums at random attitudes, 2 units of time; the truth is SciPy's DOP853."""
    return _bodies(galvi.problems.pendulum_3d(), members, 2.0, RIGID_DOP853, rtol=1e-13, atol=1e-13)


def kepler_orbits(members: int) -> Ensemble:
    """Orbits of eccentricity 0.3 or near it, three revolutions."""
    problem = galvi.problems.kepler(0.3)
    q, v = _perturbed(problem, members, 0.02)
    duration = 6.0 * math.pi
    return Ensemble(problem, q, v, duration, 1e-12, _truth(KEPLER, problem, q, v, duration))


def candidates(ensemble: Ensemble) -> list[Candidate]:
    """The codes that run an ensemble here; galvi once for each degree."""
    problem = ensemble.problem
    codes = [Candidate("galvi", _of_galvi(ensemble, degree)) for degree in DEGREES]
    if MUJOCO_ROLLOUT.supports(problem) and not MUJOCO_ROLLOUT.missing:
        codes.append(Candidate(MUJOCO_ROLLOUT.name, _of_mujoco(ensemble)))
    for heyoka in (HEYOKA_BATCHES, HEYOKA_ENSEMBLE):
        if heyoka.supports(problem) and not heyoka.missing:
            codes.append(Candidate(heyoka.name, _of_heyoka(heyoka, ensemble)))
    if HEYOKA_BATCHES.supports(problem):
        codes.append(Candidate("SciPy DOP853", _of_scipy(ensemble), in_parallel=False))
    return codes


def _of_galvi(ensemble: Ensemble, degree: int) -> Iterator[tuple[str, Call]]:
    """Settings from the coarsest with which the first members reach the error."""
    problem, q, v, duration, target, truth = ensemble
    method = galvi.Galerkin(galvi.Polynomials(degree), galvi.gauss(degree))
    run, checked = partial(galvi.integrate_ensemble, problem, tolerance=1e-4 * target), len(truth)
    for steps in STEPS:
        arguments = method, duration / steps, steps
        ends = run(q[:checked], v[:checked], *arguments)[0]
        if np.abs(ends - truth).max() <= target or steps == STEPS[-1]:
            yield f"degree {degree}, {steps} steps", lambda a=arguments: run(q, v, *a)[0]


def _of_mujoco(ensemble: Ensemble) -> Iterator[tuple[str, Call]]:
    problem, q, v, duration, *_ = ensemble
    for steps in (50, 100, 150, 200, 300, 400, 600, 800, 1200, 1600):
        yield (
            f"{steps} steps",
            MUJOCO_ROLLOUT.prepared(problem, q, v, duration / steps, steps, processors()),
        )


def _of_heyoka(heyoka: Any, ensemble: Ensemble) -> Iterator[tuple[str, Call]]:
    problem, q, v, duration, *_ = ensemble
    for tolerance in (1e-12, 1e-13, 1e-14, 1e-15):
        yield (
            f"tolerance {tolerance:g}",
            heyoka.prepared(problem, q, v, duration, tolerance, processors()),
        )


def _of_scipy(ensemble: Ensemble) -> Iterator[tuple[str, Call]]:
    """CHECKED_MEMBERS members in one thread, whose time stands for that of all."""
    problem, q, v, duration, *_ = ensemble

    def call(tolerance: float) -> Any:
        return _truth(DOP853, problem, q, v, duration, rtol=tolerance, atol=tolerance)

    for tolerance in (1e-12, 1e-13, 2.3e-14):
        yield f"rtol {tolerance:g}, {CHECKED_MEMBERS} members", partial(call, tolerance)


def compared(ensemble: Ensemble) -> list[tuple[Any, ...]]:
    """A row for each code, of its fastest setting that reaches the error."""
    chosen: list[tuple[Candidate, str, float, Call]] = []
    missed: dict[str, tuple[str, float]] = {}
    for candidate in candidates(ensemble):
        error, setting = math.inf, ""
        for setting, call in candidate.calls:
            error = float(np.abs(call()[:CHECKED_MEMBERS] - ensemble.truth).max())
            if error <= ensemble.target:
                chosen.append((candidate, setting, error, call))
                break
        else:
            missed[candidate.name] = setting, error
    times = interleaved([call for *_, call in chosen], ROUNDS, ROUND_SECONDS)
    name, members = ensemble.problem.name, len(ensemble.q)
    # members in the time of CHECKED_MEMBERS on one thread
    on_all_processors = CHECKED_MEMBERS * processors()
    fastest: dict[str, tuple[str, float, Timing, float]] = {}
    for (candidate, setting, error, _), timing in zip(chosen, times, strict=True):
        code, per_member = (
            candidate.name,
            timing.seconds / (members if candidate.in_parallel else on_all_processors),
        )
        if code not in fastest or per_member < fastest[code][-1]:
            fastest[code] = setting, error, timing, per_member
    first = "peers", f"{members} of {name}"
    galvi_per_member = fastest["galvi"][-1] if "galvi" in fastest else math.nan
    rows: list[tuple[Any, ...]] = [
        (
            *first,
            code,
            setting,
            error,
            ensemble.target,
            timing.seconds,
            timing.low,
            timing.high,
            1e6 * per_member,
            per_member / galvi_per_member,
        )
        for code, (setting, error, timing, per_member) in fastest.items()
    ]
    rows += [
        (*first, code, f"not reached, {setting}", error, ensemble.target, *(math.nan,) * 5)
        for code, (setting, error) in missed.items()
        if code not in fastest
    ]
    return rows


def scaling(ensemble: Ensemble) -> list[tuple[Any, ...]]:
    """Rows of one ensemble: members one by one, in lanes, in threads and on workers."""
    problem, q, v, duration, *_ = ensemble
    method = galvi.Galerkin(galvi.Polynomials(8), galvi.gauss(8))
    steps, single_members = 200, max(len(q) // 40, 8)
    arguments = (method, duration / 24, steps)
    run = partial(galvi.integrate_ensemble, problem, q, v, *arguments)

    def one_by_one() -> Any:
        starts = [
            problem.with_initial_state(*state)
            for state in zip(q[:single_members], v[:single_members], strict=True)
        ]
        return galvi.integrate_many(starts, *arguments, save_every=steps, threads=1)

    first, rows = f"one by one, {single_members} members", list[tuple[Any, ...]]()
    for make_executors in (threads, workers):
        with make_executors() as executors:
            calls: dict[str, Call] = {first: one_by_one}
            calls |= {
                label: partial(run, executor=executor) for label, executor in executors.items()
            }
            times = dict(
                zip(calls, interleaved(list(calls.values()), ROUNDS, ROUND_SECONDS), strict=True)
            )
        serial = times[first].seconds / single_members
        for label, timing in times.items():
            per_member = serial if label == first else timing.seconds / len(q)
            if label != first or not rows:
                rows.append(
                    (
                        "scaling",
                        f"{len(q)} of {problem.name}",
                        label,
                        f"{steps} steps",
                        math.nan,
                        math.nan,
                        timing.seconds,
                        timing.low,
                        timing.high,
                        1e6 * per_member / steps,
                        serial / per_member,
                    )
                )
    return rows


@contextmanager
def threads() -> Iterator[dict[str, Any]]:
    """Executors with one thread and with as many as there are processors, by label."""
    with ExitStack() as stack:
        yield {
            f"lanes, {n} thread{'s' * (n > 1)}": stack.enter_context(ThreadPoolExecutor(n))
            for n in sorted({1, processors()})
        }


class OneWorker:
    """The first worker of a cluster; the others idle meanwhile."""

    def __init__(self, client: Any) -> None:
        self._client, (self._worker, *_) = client, client.nthreads()

    def nthreads(self) -> dict[str, int]:
        """The number of threads of the worker, by its address."""
        return {self._worker: self._client.nthreads()[self._worker]}

    def submit(self, function: Callable[..., Any], *arguments: Any) -> Any:
        """See Dask's ``Client.submit``."""
        return self._client.submit(function, *arguments, workers=[self._worker])


@contextmanager
def workers() -> Iterator[dict[str, Any]]:
    """One Dask worker, and as many as there are processors, by label; {} where Dask is not
    installed."""
    if find_spec("distributed") is None:
        yield {}
        return
    from distributed import Client, LocalCluster

    n = processors()
    with (
        LocalCluster(
            n_workers=n, threads_per_worker=1, dashboard_address=":0", silence_logs=50
        ) as cluster,
        Client(cluster) as client,
    ):
        yield {"lanes, 1 Dask worker": OneWorker(client)} | (
            {f"lanes, {n} Dask workers": client} if n > 1 else {}
        )
