"""A process that builds cases with the galvi on its path, and times one sample on command.

It stands alone: nothing of the suite is imported, so that it serves any version of galvi. Commands
and answers are lines of JSON. The process stays alive, so that start-up and compilation are outside
of every sample.

{"do": "prepare", "case": ...}    the ends reached, counts, status, seconds of the first call, and
                                  numbers that tell what the problem is, see `probed`
{"do": "sample", "name", "repeats", "goes"}  seconds of one call: processor time and wall time
"""

from __future__ import annotations

import gc
import json
import math
import os
import sys
import time
from collections.abc import Callable, Mapping
from typing import Any

SPREAD = 1e-3  # between the starts of a case
ASIDE = 0.1  # in units of time: how far from the start a problem's functions are evaluated


def problem_of(case: Mapping[str, Any]) -> Any:
    """The case's problem, of the galvi that is imported."""
    import galvi

    return getattr(galvi.problems, case["problem"])(**case["arguments"])


def prepared(case: Mapping[str, Any]) -> Callable[[], list[Any]]:
    """What runs a case once, giving a trajectory for each start; raises what galvi raises."""
    import galvi

    made = problem_of(case)
    charts = (getattr(galvi, case["chart"])(),) if case["chart"] else ()
    rule = getattr(galvi, case["rule"])(case["points"])
    method = galvi.Galerkin(galvi.Polynomials(case["degree"]), rule, *charts)
    problems = starts(made, case["starts"])
    step, steps = case["step"], case["steps"]

    def call() -> list[Any]:
        return [galvi.integrate(one, method, step, steps, save_every=steps) for one in problems]

    return call


def starts(problem: Any, count: int) -> list[Any]:
    """The problem itself, and others from configurations a little farther out."""
    if count == 1:
        return [problem]
    factors = [1.0 + SPREAD * k for k in range(count)]
    return [problem.starting_at(problem.q0 * factor, problem.v0) for factor in factors]


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

    A function that its system lacks, or that asks for something else, is left out.
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
    told = {"start": [float(t), *_flat(q), *_flat(v)]}
    for name, arguments in asked:
        try:
            told[name] = _flat(getattr(system, name)(*arguments))
        except Exception:
            continue
    return told


def _flat(value: Any) -> list[float]:
    import numpy

    return [float(x) for x in numpy.ravel(value)]


def sample(call: Callable[[], Any], repeats: int, goes: int = 1) -> dict[str, float]:
    """Seconds of one call, the mean over the repeats, in the quickest of so many goes.

    What else happens on the machine only adds to them. The collector of garbage waits.
    """
    best = {"processor": math.inf, "wall": math.inf}
    gc.disable()
    try:
        for _ in range(goes):
            wall, processor = time.perf_counter(), time.process_time()
            for _ in range(repeats):
                call()
            processor, wall = time.process_time() - processor, time.perf_counter() - wall
            if processor < best["processor"] * repeats:
                best = {"processor": processor / repeats, "wall": wall / repeats}
    finally:
        gc.enable()
    return best


def answer(order: Mapping[str, Any], calls: dict[str, Callable[[], Any]]) -> dict[str, Any]:
    """Do what one line asks."""
    if order["do"] == "where":
        import galvi

        return {"file": galvi.__file__}
    if order["do"] == "sample":
        return sample(calls[order["name"]], order["repeats"], order["goes"])
    case = order["case"]
    start = time.perf_counter()
    call = prepared(case)
    runs = call()
    first = time.perf_counter() - start
    calls[case["name"]] = call
    gc.collect()
    told = {"first_call": first, "warm": sample(call, 1)["processor"]}
    return described(runs) | told | {"problem": probed(problem_of(case))}


def serve() -> None:
    """Answer until the commands end; what galvi prints goes to stderr."""
    out = os.fdopen(os.dup(1), "w", encoding="utf-8")
    os.dup2(2, 1)
    calls: dict[str, Callable[[], Any]] = {}
    for line in sys.stdin:
        try:
            told = answer(json.loads(line), calls)
        except Exception as error:
            told = {"raised": f"{type(error).__name__}: {' '.join(str(error).split())}"}
        out.write(json.dumps(_finite(told)) + "\n")
        out.flush()


def _finite(value: Any) -> Any:
    """The same with None for what is not finite, which JSON lacks."""
    if isinstance(value, dict):
        return {key: _finite(one) for key, one in value.items()}
    if isinstance(value, list):
        return [_finite(one) for one in value]
    return None if isinstance(value, float) and not math.isfinite(value) else value


if __name__ == "__main__":
    serve()
