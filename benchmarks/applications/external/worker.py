"""The process in which an external integrator runs: requests, answers, and its end.

`external.integrator` calls `answer` through a pool of one process. Exceptions of the
integrator become ContenderErrors; a hang or crash affects this process only.
"""

from __future__ import annotations

import gc
import math
import multiprocessing
import os
import signal
import sys
import threading
import time
from collections.abc import Mapping
from contextlib import suppress
from functools import cache
from itertools import pairwise
from multiprocessing.connection import Connection
from typing import Any
from weakref import WeakSet

import psutil

from benchmarks.applications.external.loading import (
    ContenderError,
    definition,
    describe_error,
    load_class,
    metadata,
    plain_text,
)
from benchmarks.applications.external.validation import valid_claim, valid_run, valid_settings
from galvi import Problem, Trajectory

STEP_MULTIPLES = (1, 4, 16, 64)  # multiples of the fewest steps
MEMORY_ROUNDS = 3  # rounds of repeated runs, whose growth of memory is compared
ROUND_SECONDS, MOST_RUNS_A_ROUND = 0.4, 2000  # of one such round
SLOW_RUN_SECONDS = 4.0  # longer runs are not repeated to measure memory
RETURNED_RUNS: WeakSet[Trajectory] = WeakSet()
contender_at = cache(load_class)


def prepare(output: Connection) -> None:
    """Send the output of this process to the pipe and make it leader of a process group.

    Elsewhere than on POSIX there is no group, and output is discarded.
    """
    parent = multiprocessing.parent_process()
    assert parent is not None, (
        "only a process that multiprocessing started has a parent to end with"
    )
    file = output.fileno() if os.name == "posix" else os.open(os.devnull, os.O_WRONLY)
    for stream in (1, 2):
        os.dup2(file, stream)
    output.close()
    # The pool closes its pipe before it sends SIGTERM: a worker that waits ends by itself, and
    # cleans up; one that hangs is killed soon after.
    signal.signal(signal.SIGTERM, lambda *_: None)
    if os.name == "posix":
        os.setsid()
    threading.Thread(target=_end_after, args=(parent,), daemon=True).start()


def _end_after(parent: Any) -> None:
    """End this process and its group when the parent has ended, killed or not."""
    parent.join()
    if os.name == "posix":
        os.killpg(0, signal.SIGKILL)
    os._exit(1)


def answer(path: str, question: str, *arguments: Any) -> Any:
    """The integrator's answer to a question of ANSWERS. Raises only ContenderError."""
    try:
        return ANSWERS[question](contender_at(path), *arguments)
    except ContenderError as error:  # perhaps of a class of the integrator's own
        raise ContenderError(plain_text(error)) from None
    except BaseException as error:
        raise ContenderError(f"It raised {describe_error(error)}.") from None
    finally:
        with suppress(Exception):  # of a stream of the integrator's own
            sys.stdout.flush()


def supports(contender: Any, problem: Problem) -> bool:
    """Whether the integrator solves the problem."""
    return bool(contender.supports(problem))


def equal_steps(duration: float, fewest: int) -> list[dict[str, Any]]:
    """The settings of an integrator that offers none, from coarse to fine."""
    return [{"step": duration / n, "save_every": n} for n in (fewest * k for k in STEP_MULTIPLES)]


def settings(
    contender: Any, problem: Problem, duration: float, fewest: int
) -> list[dict[str, Any]]:
    """The settings that it offers, or else multiples of `fewest` equal steps, coarse to fine."""
    if not hasattr(contender, "settings"):
        return equal_steps(duration, fewest)
    return valid_settings(list(contender.settings(problem, duration)), duration)


def claimed_error(
    contender: Any, problem: Problem, duration: float, setting: Mapping[str, Any]
) -> float | None:
    """The largest error that it claims for such a run; None without a method for this."""
    if not hasattr(contender, "claimed_error"):
        return None
    return valid_claim(contender.claimed_error(problem, duration, dict(setting)))


def timed_run(
    contender: Any, problem: Problem, duration: float, setting: Mapping[str, Any], repeats: int = 1
) -> tuple[dict[str, Any], float]:
    """The parts of the last of `repeats` runs, validated, and their mean time in seconds."""
    run, start = None, time.perf_counter()
    for _ in range(repeats):
        before, run = run, contender.run(problem, duration, dict(setting))
    seconds = (time.perf_counter() - start) / repeats
    parts = valid_run(run, problem, duration, setting)
    if run is before or run in RETURNED_RUNS:
        raise ContenderError(
            "It returned a trajectory that it had returned before; each run must be made."
        )
    RETURNED_RUNS.add(run)
    return parts, seconds


def memory_growth(
    contender: Any, problem: Problem, duration: float, setting: Mapping[str, Any]
) -> float:
    """Bytes by which repeated runs make this process grow.

    After a warm round there are MEMORY_ROUNDS equal ones. The growth is MEMORY_ROUNDS times the
    least growth of a round, so that memory that is allocated once does not count. NaN where a run
    takes longer than SLOW_RUN_SECONDS.
    """

    def seconds(runs: int) -> float:
        start = time.perf_counter()
        for _ in range(runs):
            contender.run(problem, duration, dict(setting))
        return (time.perf_counter() - start) / runs

    def memory() -> int:
        gc.collect()
        return int(process.memory_info().rss)

    process = psutil.Process()
    seconds(1)  # it may compile
    run_seconds = seconds(1)
    if run_seconds > SLOW_RUN_SECONDS:
        return math.nan
    runs = max(1, min(MOST_RUNS_A_ROUND, int(ROUND_SECONDS / max(run_seconds, 1e-9))))
    seconds(runs)
    levels = [memory()]
    for _ in range(MEMORY_ROUNDS):
        seconds(runs)
        levels.append(memory())
    return float(MEMORY_ROUNDS * max(0, min(after - before for before, after in pairwise(levels))))


ANSWERS = {
    "metadata": metadata,
    "definition": definition,
    "supports": supports,
    "settings": settings,
    "claimed error": claimed_error,
    "timed run": timed_run,
    "memory growth": memory_growth,
}
