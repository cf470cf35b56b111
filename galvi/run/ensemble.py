"""Many initial conditions at once, in a pool of threads.

Compiled kernels release the interpreter's lock while they run, and threads share compiled code and
tables. A process would import and load everything again, which takes a second or more, and accepts
only functions that can be pickled (benchmarks/timings/test_ensemble.py).
"""

from __future__ import annotations

import os
import threading
from collections.abc import Callable, Iterable, Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from contextlib import ExitStack, contextmanager
from typing import Any

from tqdm import tqdm

from galvi import input_checks
from galvi.input_checks import shown
from galvi.method import Galerkin
from galvi.problem import Problem
from galvi.run.engines import stepper_for
from galvi.run.integrate import prepare_run
from galvi.run.interruption import Interrupted, defer_interrupts
from galvi.run.request import RunRequest, check_memory
from galvi.trajectory import Trajectory


def integrate_many(
    problems: Iterable[Problem],
    method: Galerkin,
    step: float,
    steps: int | None = None,
    *,
    duration: float | None = None,
    events: Any = (),
    save_every: int = 1,
    curves: bool | None = None,
    solver: str = "auto",
    tolerance: float | None = None,
    threads: int | None = None,
    progress: bool | None = None,
) -> tuple[Trajectory, ...]:
    """Integrate each of ``problems``, as `galvi.integrate` would, several at a time.

    Parameters
    ----------
    problems
        e.g. ``[problem.with_initial_state(q, v) for q, v in zip(q0, v0)]``
    threads
        number of concurrent runs; None: one for each processor available to this process
    progress
        True shows a progress bar of runs
    method, step, steps, duration, events, save_every, curves, solver, tolerance
        as for `galvi.integrate`

    Returns
    -------
    tuple[Trajectory, ...]
        The runs in the order of the problems, bit-identical to single runs for any number of
        threads. A failed run is returned like any other and does not stop the rest; Ctrl-C stops
        all of them, and each can be resumed. If any problem has plain Python functions, the
        runs are done one after another: compile such functions with ``numba.njit``.

    Raises
    ------
    ValueError, TypeError
        For bad input before any run starts; exceptions of user functions pass through. An
        exception that concerns one problem carries a note with its index.
    KeyboardInterrupt
        For Ctrl-C when all runs were done; its attribute ``run`` is the tuple of runs.

    Examples
    --------
    >>> orbits = [galvi.problems.kepler(e) for e in (0.1, 0.3, 0.6)]
    >>> method = galvi.Galerkin(galvi.Polynomials(8), galvi.gauss(8))
    >>> [run.success for run in galvi.integrate_many(orbits, method, step=0.25, steps=40)]
    [True, True, True]
    """
    if isinstance(problems, Problem) or not input_checks.has_items(problems):
        raise TypeError(
            f"problems must be several galvi.Problem values, as in "
            f"[problem.with_initial_state(q, v), ...]; "
            f"received {shown(problems)}. For one problem, "
            f"call galvi.integrate."
        )
    problems = tuple(problems)
    threads = processors() if threads is None else input_checks.whole("threads", threads)
    requests: list[RunRequest] = []
    runs: list[Callable[..., Trajectory]] = []
    compiled = True
    for k, problem in enumerate(problems):
        with _naming_problem(k):
            request = RunRequest.checked(
                problem, method, step, steps, duration=duration, save_every=save_every,
                curves=curves, solver=solver, tolerance=tolerance,
            )  # fmt: skip
            compiled = compiled and stepper_for(request).is_compiled
            requests.append(request)
            runs.append(prepare_run(request, events))
    if requests:
        check_memory(requests)
    return _run_all(runs, min(threads, len(runs)) if compiled else 1, progress)


def _run_all(
    runs: Sequence[Callable[..., Trajectory]], threads: int, progress: bool | None
) -> tuple[Trajectory, ...]:
    """The trajectories of the runs, in their order; raises the exception of the first run that
    raised one."""
    first_raised, lock = len(runs), threading.Lock()
    with defer_interrupts() as pressed, ExitStack() as stack:
        bar = stack.enter_context(tqdm(total=len(runs), unit="run")) if progress else None

        stopped = False

        def run_problem(k: int) -> Trajectory:
            nonlocal first_raised
            try:
                with _naming_problem(k):
                    return runs[k](interrupted=lambda: stopped or pressed() or first_raised < k)
            except BaseException:
                with lock:
                    first_raised = min(first_raised, k)
                raise
            finally:
                if bar is not None:
                    with lock:
                        bar.update()

        if threads < 2:
            trajectories = tuple(map(run_problem, range(len(runs))))
        else:
            with ThreadPoolExecutor(threads) as pool:
                try:
                    trajectories = tuple(pool.map(run_problem, range(len(runs))))
                except BaseException:  # also of a signal handler: the pool waits for its threads
                    stopped = True
                    raise
        if pressed() and not any(run.interrupted for run in trajectories):
            raise Interrupted(trajectories)
    return trajectories


@contextmanager
def _naming_problem(k: int) -> Iterator[None]:
    try:
        yield
    except Exception as error:
        error.add_note(f"This was problems[{k}].")
        raise


def processors() -> int:
    """How many processors this process may use."""
    available: Any = getattr(os, "sched_getaffinity", None)
    return len(available(0)) if available else os.cpu_count() or 1
