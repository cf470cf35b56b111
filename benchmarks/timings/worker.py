"""A program that runs and times cases with the galvi on its path, on request.

It imports nothing of the suite and only galvi's public interface, so that it works with any
revision. It receives the descriptor of one end of a pipe and stays alive, so that start-up and
compilation are outside every sample. Requests and answers are JSON:

{"do": "run", "case"}                          the end states, counts, status, seconds of the
                                               first call, numbers that identify the problem, the
                                               file of galvi or of the integrator, the memory of
                                               the process afterwards, and by how much its peak
                                               exceeded the memory before, in bytes
{"do": "time", "case", "repeats", "attempts"}   seconds of one call, see `sample`
any                                            "raised": the exception, when there was one
"""

from __future__ import annotations

import gc
import importlib
import json
import math
import sys
import time
from collections.abc import Callable, Mapping
from multiprocessing.connection import Connection
from typing import Any

START_DIFFERENCE = 1e-3  # difference between the starts of a case
UNTIMED = ("round-off", "long")  # kinds of cases
TIME_TOLERANCE = 1e-9  # tolerance of the last time, relative to the duration
PROBE_TIME = 0.1  # functions of a problem are evaluated this far along the velocity from the start


def problem_of(case: Mapping[str, Any]) -> Any:
    """The case's problem, by the imported galvi."""
    import galvi

    return getattr(galvi.problems, case["problem"])(**case["arguments"])


def method_of(case: Mapping[str, Any]) -> Any:
    """The case's method, by the imported galvi."""
    import galvi

    charts = (getattr(galvi, case["chart"])(),) if case["chart"] else ()
    rule = getattr(galvi, case["rule"])(case["points"])
    return galvi.Galerkin(galvi.Polynomials(case["degree"]), rule, *charts)


def prepared(case: Mapping[str, Any]) -> Callable[[], list[Any]]:
    """A call that runs a case once and returns a trajectory for each start."""
    import galvi

    problems = starts(problem_of(case), case["starts"])
    if case.get("contender"):
        run, duration = contender_of(case).run, case["step"] * case["steps"]
        return lambda: [run(problem, duration, dict(case["setting"])) for problem in problems]
    method, step, steps = method_of(case), case["step"], case["steps"]

    def call() -> list[Any]:
        return [
            galvi.integrate(problem, method, step, steps, save_every=steps) for problem in problems
        ]

    return call


def contender_of(case: Mapping[str, Any]) -> Any:
    """The case's integrator, from its module "package.module:Class" on the path."""
    module, _, name = case["contender"].partition(":")
    contender = getattr(importlib.import_module(module), name)
    return contender() if isinstance(contender, type) else contender


def check_end(run: Any, start: float, duration: float) -> None:
    """Raise ValueError where a run succeeded and does not end at start + duration."""
    end = start + duration
    if run.success and not abs(run.t[-1] - end) <= TIME_TOLERANCE * abs(duration):
        raise ValueError(f"its last time must be {end:g}; received {run.t[-1]:g}")


def finest_offered(case: Mapping[str, Any]) -> Any:
    """The finest setting that the case's integrator offers, as text; "" where it offers none."""
    if not case.get("contender") or not hasattr(contender := contender_of(case), "settings"):
        return ""
    settings = contender.settings(problem_of(case), case["step"] * case["steps"])
    return str(dict(list(settings)[-1]))


def starts(problem: Any, count: int) -> list[Any]:
    """The problem itself, and copies from slightly perturbed configurations."""
    if count == 1:
        return [problem]
    return [
        problem.with_initial_state(problem.q0 * (1.0 + START_DIFFERENCE * k), problem.v0)
        for k in range(count)
    ]


def described(runs: list[Any], momenta: bool = False) -> dict[str, Any]:
    """Flat final configurations of the runs, with momenta if requested, summed counts, and success
    and status: those of the first failed run, if one failed."""
    failed = [run for run in runs if not run.success]
    counts: dict[str, int] = {}
    for run in runs:
        for name, count in run.counts.items():
            counts[name] = counts.get(name, 0) + int(count)
    return {
        "ends": [_flat(run.q[-1]) + (_flat(run.p[-1]) if momenta else []) for run in runs],
        "counts": counts,
        "success": not failed,
        "status": str((failed or runs)[0].status),
    }


def problem_values(problem: Any) -> dict[str, list[float]]:
    """A problem's start, and values of its functions near it, to tell whether problems differ.

    A function that its system lacks, or that takes other arguments, is omitted.
    """
    q, v, t = problem.q0, problem.v0, getattr(problem, "t0", 0.0)
    system = getattr(problem, "system", None)
    shifted_q = q + PROBE_TIME * v if q.shape == v.shape else q
    probes: tuple[tuple[str, tuple[Any, ...]], ...] = (
        ("momentum", (v,)),
        ("potential_energy", (shifted_q[None], [t])),
        ("acceleration", (shifted_q, t)),
        ("torque", (shifted_q, t)),
        ("force", (shifted_q, v)),
        ("force", (shifted_q, v, t)),
        ("function", (shifted_q, v)),
        ("slopes", (shifted_q, v)),
    )
    numbers = {"start": [float(t), *_flat(q), *_flat(v)]}
    for name, arguments in probes:
        try:
            numbers[name] = _flat(getattr(system, name)(*arguments))
        except Exception:
            continue
    return numbers


def _flat(value: Any) -> list[float]:
    import numpy

    return [float(x) for x in numpy.ravel(value)]


def sample(call: Callable[[], Any], repeats: int, attempts: int = 1) -> dict[str, float]:
    """The mean seconds of a call over the repeats, in the fastest of `attempts`.

    Returns processor time ("processor") and wall time ("wall"). The fastest counts, since other
    load only adds to a time. The garbage collector is off during the calls.
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
    """Make the first call of a case, store the call in `calls`, and return the answer."""
    start = time.perf_counter()
    call, before = prepared(case), peak(from_now=True)
    runs = call()
    first_seconds = time.perf_counter() - start
    added_peak = peak() - before
    problem = problem_of(case)
    if case.get("contender"):
        for trajectory in runs:
            check_end(trajectory, problem.t0, case["step"] * case["steps"])
    calls[case["name"]] = call
    # under `ulimit -t` the clock of processor time stands still for milliseconds
    warm_seconds = math.nan if case["kind"] in UNTIMED else sample(call, 1)["wall"]
    times = {"first_call": first_seconds, "warm": warm_seconds}
    module = sys.modules[case["contender"].partition(":")[0] if case.get("contender") else "galvi"]
    origin = {"code": module.__file__, "problem": problem_values(problem)}
    description = described(runs, bool(case.get("contender"))) | {"offered": finest_offered(case)}
    return description | times | origin | {"need": added_peak, "memory": memory()}


def memory() -> float:
    """The memory of this process in bytes; NaN where the system does not report it."""
    gc.collect()
    return _status("VmRSS:")


def peak(from_now: bool = False) -> float:
    """The peak memory of this process in bytes, which is first reset where `from_now`; NaN where
    the system does not report it."""
    if from_now:
        gc.collect()
        try:
            with open("/proc/self/clear_refs", "w", encoding="ascii") as file:
                file.write("5")
        except OSError:
            pass  # the peak stays that of all earlier runs
    return _status("VmHWM:")


def _status(name: str) -> float:
    try:
        with open("/proc/self/status", encoding="ascii") as file:
            return 1024.0 * int(file.read().partition(name)[2].split()[0])
    except (OSError, IndexError):
        return math.nan


def answer(order: Mapping[str, Any], calls: dict[str, Callable[[], Any]]) -> dict[str, Any]:
    """Answer one request; a case that this process has not run is run before it is timed."""
    case = order["case"]
    if order["do"] == "run":
        return run(case, calls)
    if case["name"] not in calls:
        run(case, calls)
    return sample(calls[case["name"]], order["repeats"], order["attempts"])


def serve(pipe: Connection) -> None:
    """Answer requests until the other end is closed.

    Both are JSON, so that no object of a tested integrator reaches the process that asks.
    """
    calls: dict[str, Callable[[], Any]] = {}
    while True:
        try:
            order = json.loads(pipe.recv_bytes())
        except EOFError:
            return
        try:
            reply = json.dumps(answer(order, calls))
        except Exception as error:
            reply = json.dumps({"raised": f"{type(error).__name__}: {error}"})
        pipe.send_bytes(reply.encode())


if __name__ == "__main__":
    serve(Connection(int(sys.argv[1])))
