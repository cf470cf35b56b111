"""The kernel of a moving frame: steps in it, in vector instructions."""

from __future__ import annotations

from functools import lru_cache
from typing import Any, cast

import numpy as np
from numpy.polynomial.legendre import legvander

from galvi.arrays import Array
from galvi.frames.frame import Frame, Motion
from galvi.frames.kepler_frame import KeplerFrame
from galvi.kernels.forces.passages import FOUND
from galvi.kernels.nystrom.advance import NOTHING, UNWATCHED
from galvi.kernels.nystrom.solve import FORCES, SOLVED
from galvi.lanes.frames import collocation
from galvi.lanes.frames.rows import POSITION, SLOPE
from galvi.lanes.vectors import LANES
from galvi.method import Galerkin
from galvi.problem import Problem
from galvi.rules.rule import gauss
from galvi.run.in_lanes.tables import aligned, stages_in_lanes
from galvi.run.point_masses.meetings import can_meet
from galvi.run.request import RunRequest
from galvi.run.run_arrays import FORCES_IN_LANES, RunArrays, State, fixed, run_plan
from galvi.spaces.polynomials import Polynomials
from galvi.tableau import tabulate

MEETING_CHECK_STEPS = 1024  # steps between two checks whether bodies can meet
NO_PASSAGES = np.zeros(0)


def frame_of(method: Galerkin) -> Frame:
    """The method's frame."""
    return cast(Frame, method.chart)


@lru_cache(maxsize=32)
def frame_start(problem: Problem, method: Galerkin) -> State:
    """State, stages and solver_state before the first step."""
    state = frame_of(method).enter(problem, problem.q0, problem.v0)
    solver_state = np.array([NOTHING, 0, 0], dtype=np.int64)
    return fixed(state, np.zeros((0, method.stages)), solver_state)


def stretched_nodes(y: Array, stretch: float) -> tuple[Array, Array]:
    """The stretched nodes in [-1, 1] of Gauss nodes y, and their derivatives with respect to y."""
    if stretch < 1e-8:
        return y, np.ones_like(y)
    largest_angle = np.arcsin(stretch)
    return np.arcsin(stretch * y) / largest_angle, stretch / largest_angle / np.sqrt(
        1.0 - (stretch * y) ** 2
    )


@lru_cache(maxsize=32)
def motion_of(problem: Problem, method: Galerkin, step: float) -> Motion:
    """The frame of a method, for steps of this size."""
    nodes = method.table.c[stages_in_lanes(method.stages)]
    return frame_of(method).motion(problem, step, nodes)


def tables_of(motion: Motion, method: Galerkin, checks: Array) -> tuple[Any, ...]:
    """The tables of galvi.lanes.frames.collocation."""
    table, lanes = method.table, stages_in_lanes(method.stages)
    weights = np.zeros(lanes.size)
    weights[: table.b.size] = table.b
    numbers = (
        table.integral.T[:, lanes],
        weights,
        table.c[lanes],
        table.projection.T,
        motion.clock,
        1.0 / motion.sizes,
        checks,
    )
    arrays: list[Any] = [np.array(x, dtype=np.float64, order="C") for x in numbers]
    return *arrays, _first_pass_tables(method.stages)


@lru_cache(maxsize=32)
def _first_pass_tables(s: int) -> tuple[Any, ...]:
    """The tables of a first pass at about half as many nodes; empty where that saves no vector."""
    c, width = tabulate(Polynomials(s), gauss(s)).c, stages_in_lanes(s).size
    coarse_count = min(-(-width // (2 * LANES)) * LANES, s)
    if coarse_count == s or width == LANES:
        return np.zeros((0, width)), np.zeros(LANES), np.zeros(LANES), np.zeros((0, width))
    coarse_table = tabulate(Polynomials(coarse_count), gauss(coarse_count))
    lanes = stages_in_lanes(s)
    legendre = legvander(2.0 * coarse_table.c - 1.0, coarse_count - 1)
    values = np.linalg.solve(legendre.T, legvander(2.0 * c - 1.0, coarse_count - 1).T)
    integrals = legendre_integrals(c, coarse_count) @ np.linalg.inv(legendre)
    matrices = (np.ascontiguousarray(x[:, lanes]) for x in (integrals.T, values))
    matrix, guess = matrices
    return matrix, coarse_table.b.copy(), coarse_table.c.copy(), guess


def legendre_integrals(c: Array, count: int) -> Array:
    """The integrals (len(c), count) from 0 to c of the first ``count`` Legendre polynomials on
    [0, 1]."""
    P = legvander(2.0 * c - 1.0, count)
    k = np.arange(1, count)
    first = 0.5 * (P[:, 1:2] + 1.0)
    higher = 0.5 * (P[:, 2:] - P[:, : count - 1]) / (2 * k + 1)
    return np.hstack([first, higher])


class FrameKernel:
    """Steps in a moving frame, by galvi.lanes.frames.collocation.

    Parameters
    ----------
    checks
        see `galvi.run.in_frame.passes.checks_of`
    """

    def __init__(self, request: RunRequest, work: RunArrays, checks: Array) -> None:
        self._request, self._work = request, work
        self._motion = motion = motion_of(request.problem, request.method, request.step)
        self.tables = tables = tables_of(motion, request.method, checks)
        lines = np.ones((work.state.shape[1] + 1, tables[0].shape[0] + 2))
        self._scratch = *scratch_of(motion, tables, work.state.shape), lines
        for nodes, c in (
            (self._scratch[0][2], tables[2]),
            (self._scratch[1][2], tables[-1][2]),
        ):
            nodes[POSITION], nodes[SLOPE] = stretched_nodes(2.0 * c - 1.0, motion.stretch)
        self._kernel = collocation.compiled_advance_frame()
        self._plan, self._progress, self._saved = run_plan(
            request, work, request.checkpoint.tolerance
        )
        self._passage = NO_PASSAGES
        if work.passage.size:
            frame = cast(KeplerFrame, frame_of(request.method))
            self._passage = np.append(work.passage, frame.held_pairs(request.problem))
        self._checked_block, self._may_meet = -1, False  # the last block of MEETING_CHECK_STEPS

    def advance(self, n: int) -> int:
        """See `galvi.run.stepper.Kernel`."""
        work = self._work
        state, solver_state, before = work.state.copy(), work.solver_state.copy(), work.steps_done
        code = self._in_blocks(n)
        if code != SOLVED:  # the state is lost: repeat the steps before the failed one
            steps_done, counts = work.steps_done - before, work.counts.copy()
            work.state[:], work.solver_state[:] = state, solver_state
            if steps_done:
                self._in_blocks(steps_done)
            work.counts[:] = counts
        work.counts[FORCES_IN_LANES] = work.counts[FORCES]
        return code

    def _in_blocks(self, n: int) -> int:
        """Does up to n steps, and evaluates `can_meet` at the start of each MEETING_CHECK_STEPS of
        the run."""
        request, work, passage, code = self._request, self._work, self._passage, SOLVED
        while n and code == SOLVED:
            block, steps_in_block = divmod(
                request.checkpoint.first + work.steps_done, MEETING_CHECK_STEPS
            )
            if block != self._checked_block and work.watch != UNWATCHED and passage.size:
                self._checked_block = block
                q, v = (
                    tuple(work.state[row, : request.problem.q0.size].tolist()) for row in (0, 2)
                )
                self._may_meet = can_meet(request.problem, q, v, request.method, request.step)
            block_steps = min(n, MEETING_CHECK_STEPS - steps_in_block)
            progress = *self._progress[:-1], passage if self._may_meet else NO_PASSAGES
            code = int(
                self._kernel(
                    self._motion.functions,
                    self._motion.numbers,
                    self.tables,
                    self._plan,
                    block_steps,
                    progress,
                    self._scratch,
                    self._saved,
                )
            )
            n -= block_steps
        if passage.size and passage[0] > work.passage[0]:
            work.passage[:FOUND] = passage[:FOUND]
        return code


def scratch_of(motion: Motion, tables: tuple[Any, ...], shape: tuple[int, ...]) -> Any:
    """Scratch arrays of a frame's kernel: for the stages, for the stages of the first pass, for the
    functions, and a state of ``shape``."""
    rows, width, coarse_width = motion.sizes.size, tables[1].size, tables[-1][2].size
    arrays = aligned(
        *(
            shape
            for m in (width, coarse_width)
            for shape in ((rows, m), (rows, m), (5, m), (motion.guesses, m))
        ),
        (motion.work, LANES),
        shape,
    )
    return tuple(arrays[:4]), tuple(arrays[4:8]), arrays[8], arrays[9]
