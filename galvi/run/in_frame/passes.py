"""The number of passes of a step in a moving frame."""

from __future__ import annotations

from functools import lru_cache
from typing import NamedTuple

import numpy as np

from galvi.arrays import Array
from galvi.kernels.nystrom.solve import ITERATIONS, SOLVED
from galvi.lanes.frames import collocation
from galvi.method import Galerkin
from galvi.problem import Problem
from galvi.run.in_frame.kernel import FrameKernel, frame_of, frame_start, motion_of
from galvi.run.request import ROUND_OFF, RunRequest, from_start
from galvi.run.run_arrays import RunArrays

PROBED_STEPS = 16  # first steps of a run, from which the number of passes of all steps is chosen
FRAME_TOLERANCE = 2.0**-63  # share of the state that passes may leave in a step: in 1e6 steps 1e-13
CONVERGED_CHANGE = 2.0**-80  # share of the state that passes leave in a converged step
CONVERGED = (2.0, -1.0, CONVERGED_CHANGE, 0.0)  # checks of a step whose passes converge
FURTHER_PASS_RATIO = 100.0  # of the last change to that at the start, above which passes are added


@lru_cache(maxsize=32)
def checks_of(
    problem: Problem, method: Galerkin, step: float, tolerance: float
) -> tuple[float, float, float, float]:
    """The checks of galvi.lanes.frames.collocation: the passes of a step, the change in the last
    one above which further passes follow, and the change that these may leave.

    Unless the frame prescribes the number of passes, it is the smallest with which the mean error
    of the first `PROBED_STEPS` steps is within the tolerance, each from the state of a converged
    step. It depends only on the problem's start, so that it is the same in all parts of a continued
    run.
    """
    allowed_change = FRAME_TOLERANCE if tolerance == ROUND_OFF else tolerance
    converged = _probe_steps(problem, method, step, CONVERGED)
    if not converged:
        return 2.0, -1.0, allowed_change, 0.0  # the run fails likewise and reports it
    prescribed, largest = frame_of(method).passes, max(probe.passes for probe in converged)
    pass_counts = (
        range(2, largest + 1) if prescribed is None else (min(prescribed, collocation.MAX_PASSES),)
    )
    measured = converged
    for passes in pass_counts:
        checks = float(passes), np.inf, allowed_change, 0.0
        attempts = _probe_steps(problem, method, step, checks, [probe.start for probe in converged])
        if len(attempts) < len(converged):
            continue
        end_errors = [
            attempt.end - true.end for attempt, true in zip(attempts, converged, strict=True)
        ]
        measured = attempts
        if np.mean(np.max(np.abs(np.sum(end_errors, axis=1)), axis=1)) <= allowed_change:
            break
    change = max(probe.change for probe in measured)
    return (
        float(passes),
        max(FURTHER_PASS_RATIO * change, collocation.ROUNDING_CHANGE),
        allowed_change,
        0.0,
    )


class Probe(NamedTuple):
    """One of the first steps of a run.

    Attributes
    ----------
    start
        the state (8, m) before the step
    passes
        its number of passes
    change
        relative change in the last pass
    end : array, shape (2, 2 n)
        the state in the frame after the step and its low part, over their sizes
    """

    start: Array
    passes: int
    change: float
    end: Array


def _probe_steps(
    problem: Problem,
    method: Galerkin,
    step: float,
    checks: tuple[float, ...],
    states: list[Array] | None = None,
) -> list[Probe]:
    """The first PROBED_STEPS steps of a run, or a step from each of ``states``, up to one that
    fails."""
    request = RunRequest(problem, method, step, PROBED_STEPS, from_start(curves=False))
    work = RunArrays.of(request, frame_start(problem, method), 2, (0, 0), watched=False)
    kernel = FrameKernel(request, work, np.array(checks))
    sizes = motion_of(problem, method, step).sizes
    n, probes = sizes.size // 2, []
    for k in range(PROBED_STEPS if states is None else len(states)):
        before = int(work.counts[ITERATIONS])
        work.state[:] = work.state if states is None else states[k]
        start = work.state.copy()
        if kernel.advance(1) != SOLVED:
            break
        end = np.stack([work.state[row::2, :n].ravel() for row in (4, 5)])
        passes = int(work.counts[ITERATIONS]) - before
        probes.append(
            Probe(start, passes, float(kernel.tables[-2][collocation.CHANGE]), end / sizes)
        )
    return probes
