"""The other side of `benchmarks.external.integrator`: a process in which somebody else's contender
runs.

A request is (what, *arguments), an answer ("done", value) or ("fault", sentence). Whatever the
contender raises becomes a sentence; what it hangs or breaks is this process and no other.
"""

from __future__ import annotations

import os
import signal
import time
from collections.abc import Mapping
from typing import Any
from weakref import WeakValueDictionary

import numpy as np

from benchmarks.external.code_digest import loaded, places
from benchmarks.external.loading import Fault, introduced, is_positive, opened, told
from benchmarks.external.settings_check import plain_ladder
from benchmarks.external.worker_life import tie_to_parent
from galvi import Problem
from references.setting import fixed_steps, sample_times

NEAR = 1e-9  # of the duration: by how much a time may differ from the one asked for; of the largest
# component, by how much the first state may differ from the start
RETURNED: WeakValueDictionary[int, Any] = WeakValueDictionary()


def serve(connection: Any, path: str) -> None:
    """Answer requests until the connection closes, or the parent is gone.

    What the contender prints goes to stderr.
    """
    guard, before = tie_to_parent(), loaded()
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # the parent decides
    os.dup2(2, 1)
    os.set_inheritable(connection.fileno(), False)  # what the contender starts does not hold it
    contender: Any = None
    while guard:
        try:
            what, *arguments = connection.recv()
        except (EOFError, OSError):
            return
        try:
            if what == "open":
                contender = opened(path)
                value: Any = (*introduced(contender), places(path.partition(":")[0], before))
            else:
                value = ANSWERS[what](contender, *arguments)
            answer = ("done", value)
        except Fault as fault:
            answer = ("fault", str(fault))
        except BaseException as error:
            answer = ("fault", f"It raised {told(error)}.")
        try:
            connection.send(answer)
        except OSError:  # nobody waits for it any more
            return


def supports(contender: Any, problem: Problem) -> bool:
    """Whether it solves the problem."""
    return bool(contender.supports(problem))


def settings(contender: Any, problem: Problem, duration: float) -> list[dict[str, Any]] | None:
    """What it wants to be run with; None when it does not say."""
    if not hasattr(contender, "settings"):
        return None
    offered = list(contender.settings(problem, duration))
    if not offered or not all(isinstance(one, Mapping) for one in offered):
        raise Fault(f"Its settings must be mappings, one at least; received {offered!r}.")
    return plain_ladder(offered, duration)


def claimed_error(
    contender: Any, problem: Problem, duration: float, setting: Mapping[str, Any]
) -> float | None:
    """The largest error that it claims for such a run; None when it does not say."""
    if not hasattr(contender, "claimed_error"):
        return None
    claimed = contender.claimed_error(problem, duration, dict(setting))
    if not is_positive(claimed):
        raise Fault(f"The error that it claims must be a positive number; received {claimed!r}.")
    return float(claimed)


def run(
    contender: Any, problem: Problem, duration: float, setting: Mapping[str, Any]
) -> tuple[dict[str, Any], float]:
    """The run's parts, examined, and the seconds that it took."""
    start = time.perf_counter()
    found = contender.run(problem, duration, dict(setting))
    seconds = time.perf_counter() - start
    _keep(found)
    return examined(found, problem, duration, setting), seconds


def seconds(
    contender: Any, problem: Problem, duration: float, setting: Mapping[str, Any], repeats: int
) -> float:
    """Of one run, the mean of several, of which the last is examined."""
    start, before, found = time.perf_counter(), None, None
    for _ in range(repeats):
        before = found
        found = contender.run(problem, duration, dict(setting))
    seconds = (time.perf_counter() - start) / repeats
    if before is found:
        RETURNED[id(found)] = found
    _keep(found)
    examined(found, problem, duration, setting)
    return seconds


def _keep(found: Any) -> None:
    """Fault for what it returned before: no time of such a run is one."""
    if RETURNED.get(id(found)) is found:
        raise Fault("It returned a trajectory that it had returned before; each run must be made.")
    try:
        RETURNED[id(found)] = found
    except TypeError:  # it is of a kind that cannot be remembered without being kept
        return


def examined(
    found: Any, problem: Problem, duration: float, setting: Mapping[str, Any]
) -> dict[str, Any]:
    """t, q, p, success, status and counts of a run. Fault when they are not what was asked for."""
    wanted = ("t", "q", "p", "success", "status", "counts")
    lacking = [part for part in wanted if not hasattr(found, part)]
    if lacking:
        raise Fault(
            f"Its run must return a galvi.Trajectory; received {type(found).__name__}, which has "
            f"no {' and no '.join(lacking)}."
        )
    try:
        t, q, p = (np.array(part, dtype=np.float64) for part in (found.t, found.q, found.p))
    except (TypeError, ValueError) as error:
        raise Fault(f"Its t, q and p must be arrays of numbers; {error}.") from None
    try:
        times = asked_times(problem, duration, setting)
    except (KeyError, TypeError, ValueError, OverflowError, MemoryError) as error:
        raise Fault(
            "Its settings must say at which times a run has states, as step and save_every or as "
            f"samples; received {dict(setting)!r} ({told(error)})."
        ) from None
    if t.shape != times.shape or not np.allclose(t, times, rtol=0.0, atol=NEAR * abs(duration)):
        raise Fault(
            f"Its times must be the {len(times)} from {times[0]:g} to {times[-1]:g} that its "
            f"setting asks for; received {_ends(t)}."
        )
    for name, states, start in (("q", q, problem.q0), ("p", p, problem.v0)):
        if states.shape != (len(times), *start.shape):
            raise Fault(
                f"Its {name} must have the shape {(len(times), *start.shape)}; received "
                f"{states.shape}."
            )
    success = bool(found.success)
    if not success and not str(found.status).strip():
        raise Fault("It says that it failed, and its status does not say why.")
    if success and not (np.isfinite(q).all() and np.isfinite(p).all()):
        raise Fault("It says that it succeeded, and its states are not finite.")
    for name, states, start in (("q", q, problem.q0), ("p", p, problem.p0)):
        off = np.max(np.abs(states[0] - start))
        if success and not off <= NEAR * max(np.max(np.abs(states)), np.max(np.abs(start))):
            raise Fault(
                f"Its first {name} must be the problem's start, {_row(start)}; received "
                f"{_row(states[0])}."
            )
    try:
        counts = {str(name): int(count) for name, count in dict(found.counts).items()}
    except (TypeError, ValueError):
        raise Fault(
            f"Its counts must be whole numbers by their names; received {found.counts!r}."
        ) from None
    return {
        "t": t, "q": q, "p": p, "success": success, "status": str(found.status), "counts": counts,
    }  # fmt: skip


def asked_times(problem: Problem, duration: float, setting: Mapping[str, Any]) -> Any:
    """At which times a run for this setting has states; errors as `references.setting`."""
    if "step" in setting:
        return fixed_steps(duration, setting).times(problem.t0)
    return sample_times(problem.t0, duration, setting)


def _row(state: Any) -> str:
    return np.array2string(np.ravel(state), precision=6, threshold=6, separator=", ").replace(
        "\n", ""
    )


def _ends(t: Any) -> str:
    if t.ndim != 1 or not t.size:
        return f"an array of shape {t.shape}"
    return f"{len(t)} from {t[0]:g} to {t[-1]:g}"


ANSWERS = {
    "supports": supports,
    "settings": settings,
    "claimed_error": claimed_error,
    "run": run,
    "seconds": seconds,
}
