"""A program that runs cases with the galvi on its path, and times them, on command.

It stands alone: nothing of the suite is imported, and of galvi only what is public, so that it
serves any revision. It is given the number of one end of a pipe, and stays alive, so that start-up
and compilation are outside of every sample. Questions and answers are dictionaries of plain values:

{"do": "run", "case"}                          the ends reached, counts, status, seconds of the
                                               first call, numbers that tell problems apart
{"do": "time", "case", "repeats", "attempts"}   seconds of one call, see `sample`
any                                            "raised": the exception, when there was one
"""

from __future__ import annotations

import gc
import math
import sys
import time
from collections.abc import Callable, Mapping
from multiprocessing.connection import Connection
from typing import Any

SPREAD = 1e-3  # between the starts of a case
ASIDE = 0.1  # in units of time: how far from the start a problem's functions are evaluated


def problem_of(case: Mapping[str, Any]) -> Any:
    """The case's problem, of the galvi that is imported."""
    import galvi

    return getattr(galvi.problems, case["problem"])(**case["arguments"])


def prepared(case: Mapping[str, Any]) -> Callable[[], list[Any]]:
    """The call that runs a case once, giving a trajectory for each start; raises galvi's errors."""
    import galvi

    problems = starts(problem_of(case), case["starts"])
    charts = (getattr(galvi, case["chart"])(),) if case["chart"] else ()
    rule = getattr(galvi, case["rule"])(case["points"])
    method = galvi.Galerkin(galvi.Polynomials(case["degree"]), rule, *charts)
    step, steps = case["step"], case["steps"]

    def call() -> list[Any]:
        return [galvi.integrate(one, method, step, steps, save_every=steps) for one in problems]

    return call


def starts(problem: Any, count: int) -> list[Any]:
    """The problem itself, and others from configurations a little farther out."""
    if count == 1:
        return [problem]
    # older revisions have only the second name
    moved = getattr(problem, "with_initial_state", None) or problem.starting_at
    return [moved(problem.q0 * (1.0 + SPREAD * k), problem.v0) for k in range(count)]


def described(runs: list[Any]) -> dict[str, Any]:
    """What the runs reached: flat configurations at the ends, summed counts, the first failure."""
    failed = [run for run in runs if not run.success]
    counts: dict[str, int] = {}
    for run in runs:
        for name, count in run.counts.items():
            counts[name] = counts.get(name, 0) + int(count)
    return {
        "ends": [[float(x) for x in run.q[-1].ravel()] for run in runs],
        "counts": counts,
        "success": not failed,
        "status": (failed or runs)[0].status,
    }


def probed(problem: Any) -> dict[str, list[float]]:
    """Where a problem starts, and its functions a little aside: two with other numbers are two.

    A function that its system lacks, or that takes other arguments, is left out.
    """
    q, v, t = problem.q0, problem.v0, getattr(problem, "t0", 0.0)
    system = getattr(problem, "system", None)
    aside = q + ASIDE * v if q.shape == v.shape else q
    asked: tuple[tuple[str, tuple[Any, ...]], ...] = (
        ("momentum", (v,)),
        ("potential_energy", (aside[None], [t])),
        ("acceleration", (aside, t)),
        ("torque", (aside, t)),
        ("force", (aside, v)),
        ("force", (aside, v, t)),
        ("function", (aside, v)),
        ("slopes", (aside, v)),
    )
    numbers = {"start": [float(t), *_flat(q), *_flat(v)]}
    for name, arguments in asked:
        try:
            numbers[name] = _flat(getattr(system, name)(*arguments))
        except Exception:
            continue
    return numbers


def _flat(value: Any) -> list[float]:
    import numpy

    return [float(x) for x in numpy.ravel(value)]


def sample(call: Callable[[], Any], repeats: int, attempts: int = 1) -> dict[str, float]:
    """Seconds of one call, the mean over the repeats, in the quickest of so many attempts: by the
    processor's clock ("processor"), and by the wall clock ("wall").

    What else happens on the machine only adds to them. The collector of garbage waits.
    """
    best = {"processor": math.inf, "wall": math.inf}
    gc.disable()
    try:
        for _ in range(attempts):
            wall, processor = time.perf_counter(), time.process_time()
            for _ in range(repeats):
                call()
            processor, wall = time.process_time() - processor, time.perf_counter() - wall
            if processor < best["processor"] * repeats:
                best = {"processor": processor / repeats, "wall": wall / repeats}
    finally:
        gc.enable()
    return best


def run(case: Mapping[str, Any], calls: dict[str, Callable[[], Any]]) -> dict[str, Any]:
    """A first call of a case, which is kept among the calls."""
    import galvi

    start = time.perf_counter()
    call = prepared(case)
    runs = call()
    first = time.perf_counter() - start
    calls[case["name"]] = call
    times = {"first_call": first, "warm": sample(call, 1)["processor"]}
    origin = {"galvi": galvi.__file__, "problem": probed(problem_of(case))}
    return described(runs) | times | origin


def answer(order: Mapping[str, Any], calls: dict[str, Callable[[], Any]]) -> dict[str, Any]:
    """Do what one question asks; a case that this process has not run is run before it is timed."""
    case = order["case"]
    if order["do"] == "run":
        return run(case, calls)
    if case["name"] not in calls:
        run(case, calls)
    return sample(calls[case["name"]], order["repeats"], order["attempts"])


def serve(pipe: Connection) -> None:
    """Answer until the other end is closed."""
    calls: dict[str, Callable[[], Any]] = {}
    while True:
        try:
            order = pipe.recv()
        except EOFError:
            return
        try:
            pipe.send(answer(order, calls))
        except Exception as error:
            pipe.send({"raised": f"{type(error).__name__}: {' '.join(str(error).split())}"})


if __name__ == "__main__":
    serve(Connection(int(sys.argv[1])))
