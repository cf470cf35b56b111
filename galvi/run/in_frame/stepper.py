"""Steps in a moving frame, in vector instructions."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import lru_cache
from typing import Any, NamedTuple, cast

import numpy as np
from numpy.polynomial.legendre import legvander

from galvi.arrays import Array
from galvi.curves.curves import Curves, FrameCurves
from galvi.frames.frame import Frame, Motion, revolution
from galvi.frames.kepler_frame import KeplerFrame
from galvi.kernels.forces.passages import FOUND, NEAR
from galvi.kernels.nystrom.advance import NOTHING
from galvi.kernels.nystrom.solve import FORCES, ITERATIONS, SOLVED
from galvi.lanes.frames import collocation
from galvi.lanes.frames.kepler_motion import HEAD, MASS
from galvi.lanes.frames.rows import ECCENTRICITY, PACE, PHASE, PLACE, TURNS, TWO_PI
from galvi.lanes.vectors import LANES
from galvi.lanes.within_steps import (
    WIDE,
    compiled_places_in_steps,
    compiled_states_in_steps,
)
from galvi.method import Galerkin
from galvi.problem import Problem
from galvi.rules.rule import gauss
from galvi.run.in_lanes.nystrom import aligned, stages_in_lanes
from galvi.run.request import ROUND_OFF, RunRequest, from_start
from galvi.run.run_arrays import FORCES_IN_LANES, NEVER, RunArrays, State, fixed, run_plan
from galvi.spaces.polynomials import Polynomials
from galvi.systems.nbody import NBody
from galvi.tableau import tabulate

MARGIN = 0.1  # share by which orbits may change before `can_meet` is asked again
AGAIN = 1024  # steps until it is
MANY = 16  # pairs whose orbits are looked at; of more, some may meet
AROUND = (128, 512)  # places on an orbit; more where these do not tell
BENT = 0.7  # Hill radii by which two orbits bend each other before they pass
NO_PASSAGES = np.zeros(0)
PROBED = 16  # first steps, from which the passes of all are chosen
FINEST = 2.0**-63  # share of the state that passes may leave in a step: in 1e6 steps 1e-13
SMALLEST = 2.0**-80  # what they leave of a step that is said to have converged
CONVERGED = (2.0, -1.0, SMALLEST, 0.0)  # checks of a step whose passes converge
SETTLED = 2.0**-51  # of an anomaly, up to which Newton's method for it has ended
USUAL = 100.0  # a change larger than so many times that at the start calls for further passes


def frame_of(method: Galerkin) -> Frame:
    """The method's frame."""
    return cast(Frame, method.chart)


def stretched(y: Array, stretch: float) -> tuple[Array, Array]:
    """The places in [-1, 1] of Gauss nodes y that are moved, and their slopes by y."""
    if stretch < 1e-8:
        return y, np.ones_like(y)
    whole = np.arcsin(stretch)
    return np.arcsin(stretch * y) / whole, stretch / whole / np.sqrt(1.0 - (stretch * y) ** 2)


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
        table.integral.T[:, lanes], weights, table.c[lanes], table.projection.T, motion.clock,
        1.0 / motion.sizes, checks,
    )  # fmt: skip
    arrays: list[Any] = [np.array(x, dtype=np.float64, order="C") for x in numbers]
    return *arrays, _coarse(method.stages)


@lru_cache(maxsize=32)
def _coarse(s: int) -> tuple[Any, ...]:
    """The tables of a first pass at about half as many nodes, where that saves a row of lanes."""
    c, width = tabulate(Polynomials(s), gauss(s)).c, stages_in_lanes(s).size
    fewer = min(-(-width // (2 * LANES)) * LANES, s)
    if fewer == s or width == LANES:
        return np.zeros((0, width)), np.zeros(LANES), np.zeros(LANES), np.zeros((0, width))
    few = tabulate(Polynomials(fewer), gauss(fewer))
    lanes = stages_in_lanes(s)
    legendre = legvander(2.0 * few.c - 1.0, fewer - 1)
    values = np.linalg.solve(legendre.T, legvander(2.0 * c - 1.0, fewer - 1).T)
    integrals = legendre_integrals(c, fewer) @ np.linalg.inv(legendre)
    matrices = (np.ascontiguousarray(x[:, lanes]) for x in (integrals.T, values))
    matrix, guess = matrices
    return matrix, few.b.copy(), few.c.copy(), guess


def legendre_integrals(c: Array, count: int) -> Array:
    """The integrals from 0 to c of the first Legendre polynomials on [0, 1], (len(c), count)."""
    P = legvander(2.0 * c - 1.0, count)
    k = np.arange(1, count)
    first = 0.5 * (P[:, 1:2] + 1.0)
    rest = 0.5 * (P[:, 2:] - P[:, : count - 1]) / (2 * k + 1)
    return np.hstack([first, rest])


class FrameKernel:
    """Steps in a moving frame, by galvi.lanes.frames.collocation.

    checks  see `checks_of`; None: those of the run
    """

    def __init__(self, run: RunRequest, work: RunArrays, checks: Array | None = None) -> None:
        self._run, self._work = run, work
        if checks is None:
            checks = np.array(
                checks_of(run.problem, run.method, run.step, run.checkpoint.tolerance)
            )
        self._motion = motion = motion_of(run.problem, run.method, run.step)
        self.tables = tables = tables_of(motion, run.method, checks)
        lines = np.ones((work.state.shape[1] + 1, tables[0].shape[0] + 2))
        self._scratch = *_scratch(motion, tables, work.state.shape), lines
        for nodes, c in (
            (self._scratch[0][2], tables[2]),
            (self._scratch[1][2], tables[-1][2]),
        ):
            nodes[PLACE], nodes[PACE] = stretched(2.0 * c - 1.0, motion.stretch)
        self._kernel = collocation.compiled_advance_frame()
        self._plan, self._progress, self._saved = run_plan(run, work, run.checkpoint.tolerance)
        self._passage = NO_PASSAGES
        if work.passage.size:
            frame = cast(KeplerFrame, frame_of(run.method))
            self._passage = np.append(work.passage, frame.held_pairs(run.problem))
        self._looked_at, self._may_meet = -1, False  # the last block of AGAIN steps

    def advance(self, n: int) -> int:
        """See `galvi.run.stepper.Kernel`."""
        work = self._work
        state, solver_state, before = work.state.copy(), work.solver_state.copy(), work.done
        code = self._in_blocks(n)
        if code != SOLVED:  # the steps before it once more, since the state is lost
            done, counts = work.done - before, work.counts.copy()
            work.state[:], work.solver_state[:] = state, solver_state
            if done:
                self._in_blocks(done)
            work.counts[:] = counts
        work.counts[FORCES_IN_LANES] = work.counts[FORCES]
        return code

    def _in_blocks(self, n: int) -> int:
        """Does n steps; before each AGAIN of them it is asked whether bodies can meet."""
        run, work, passage, code = self._run, self._work, self._passage, SOLVED
        while n and code == SOLVED:
            block, done = divmod(run.checkpoint.first + work.done, AGAIN)
            if block != self._looked_at and work.watch != NEVER and passage.size:
                self._looked_at = block
                q, v = (tuple(work.state[row, : run.problem.q0.size].tolist()) for row in (0, 2))
                self._may_meet = can_meet(run.problem, q, v, run.method, run.step)
            part = min(n, AGAIN - done)
            progress = *self._progress[:-1], passage if self._may_meet else NO_PASSAGES
            code = int(self._kernel(
                self._motion.functions, self._motion.numbers, self.tables, self._plan, part,
                progress, self._scratch, self._saved,
            ))  # fmt: skip
            n -= part
        if passage.size and passage[0] > work.passage[0]:
            work.passage[:FOUND] = passage[:FOUND]
        return code


def _scratch(motion: Motion, tables: tuple[Any, ...], shape: tuple[int, ...]) -> Any:
    """Rows of the stages, of those of the first pass, what the functions need, and a state of that
    shape."""
    rows, width, few = motion.sizes.size, tables[1].size, tables[-1][2].size
    arrays = aligned(
        *(shape for m in (width, few)
          for shape in ((rows, m), (rows, m), (5, m), (motion.guesses, m))),
        (motion.work, LANES), shape,
    )  # fmt: skip
    return tuple(arrays[:4]), tuple(arrays[4:8]), arrays[8], arrays[9]


@lru_cache(maxsize=32)
def can_meet(
    problem: Problem, places: tuple[float, ...], velocities: tuple[float, ...], method: Galerkin,
    step: float,
) -> bool:  # fmt: skip
    """Whether two bodies may pass each other so close that `may_pass` looks at them, on the
    orbits about the heaviest one of a state, wherever they are on these, up to ``MARGIN``."""
    system = problem.system
    if not isinstance(system, NBody):
        return False
    q, v = (np.array(rows).reshape(problem.q0.shape) for rows in (places, velocities))
    star, masses = int(np.argmax(system.masses)), system.masses
    others = np.flatnonzero(np.arange(masses.size) != star)
    mu, q, v = system.G * (masses[star] + masses[others]), q[others] - q[star], v[others] - v[star]
    r, speed, along = np.linalg.norm(q, axis=1), np.sum(v**2, axis=1), np.sum(q * v, axis=1)
    with np.errstate(all="ignore"):
        energy, spin = speed - 2.0 * mu / r, np.maximum(r**2 * speed - along**2, 0.0)
        e = np.sqrt(np.maximum(1.0 + energy * spin / mu**2, 0.0))
        near = spin / (mu * (1.0 + e)) / (1.0 + MARGIN)
        far = np.where(e < 1.0, spin / (mu * (1.0 - e)), np.inf) * (1.0 + MARGIN)
    apart = (near[:, None] > far) | (near > far[:, None])
    apart |= np.add.outer(masses[others], masses[others]) == 0.0
    time = 2.0 * NEAR * abs(step) / (method.space.dimension - 1)
    if np.count_nonzero(np.triu(~apart, 1)) > MANY:
        return True
    return any(
        not (e[i] < 1.0 and e[j] < 1.0) or _orbits_near(mu, q, v, i, j, time, pull)
        for i, j in np.argwhere(np.triu(~apart, 1))
        if (pull := system.G * (masses[others[i]] + masses[others[j]]))
    )


def _orbits_near(
    mu: Array, q: Array, v: Array, i: int, j: int, time: float, pull: float
) -> bool:  # fmt: skip
    """Whether two ellipses come nearer to each other than their relative velocity and their own
    attraction move them in a time, and than they bend each other.

    Where they are nearest, their distance is perpendicular to both: places beside those add the
    square of their own distance.
    """
    bent = BENT * max(float(np.linalg.norm(q[k])) for k in (i, j)) * np.cbrt(pull / (3.0 * mu[i]))
    bent += np.cbrt(2.0 * pull * time**2)
    for places in AROUND:
        one, other = (_ellipse(float(mu[k]), q[k], v[k], places) for k in (i, j))
        square, fast = (
            np.sum(a * a, axis=1)[:, None] + np.sum(b * b, axis=1) - 2.0 * a @ b.T
            for a, b in zip(one[:2], other[:2], strict=True)
        )
        beside = 0.25 * (one[2] + other[2]) ** 2
        reach = time * np.sqrt(np.maximum(fast, 0.0)) + bent
        if not np.any((1.0 - MARGIN) ** 2 * square - beside < reach**2):
            return False
    return True


def _ellipse(mu: float, q: Array, v: Array, count: int) -> tuple[Array, Array, float]:
    """Places and velocities (count, dimension) on the ellipse of a state, and the largest distance
    of two neighbours."""
    r = np.linalg.norm(q)
    eccentric = ((v @ v - mu / r) * q - (q @ v) * v) / mu
    a, e = float(mu / (2.0 * mu / r - v @ v)), float(np.linalg.norm(eccentric))
    first = eccentric / e if e > 0.0 else q / r
    across = q - (q @ first) * first if abs(q @ first) < 0.7 * r else v - (v @ first) * first
    across = across / np.linalg.norm(across)
    across = across if (v @ across) * (q @ first) >= (v @ first) * (q @ across) else -across
    u = 2.0 * np.pi * np.arange(count)[:, None] / count
    minor = a * math.sqrt(max(1.0 - e * e, 0.0))
    places = a * (np.cos(u) - e) * first + minor * np.sin(u) * across
    pace = np.sqrt(mu / a**3) / (1.0 - e * np.cos(u))
    speeds = pace * (minor * np.cos(u) * across - a * np.sin(u) * first)
    return places, speeds, 2.0 * np.pi * a / count


@lru_cache(maxsize=32)
def checks_of(
    problem: Problem, method: Galerkin, step: float, tolerance: float
) -> tuple[float, float, float, float]:
    """Passes of a step, the usual change in the last of them, and what further ones may leave.

    Unless the frame says how many, the fewest with which the first `PROBED` steps end, each from
    the same state, within the tolerance of one that has converged, in their mean. They depend on
    the problem's start alone, so that they are the same in each part of a continued run.
    """
    left = FINEST if tolerance == ROUND_OFF else tolerance
    converged = _probed(problem, method, step, CONVERGED)
    if not converged:
        return 2.0, -1.0, left, 0.0  # the run finds the same, and says it
    given, most = frame_of(method).passes, max(one.passes for one in converged)
    few = range(2, most + 1) if given is None else (min(given, collocation.MOST_PASSES),)
    seen = converged
    for passes in few:
        checks = float(passes), np.inf, left, 0.0
        tried = _probed(problem, method, step, checks, [one.start for one in converged])
        if len(tried) < len(converged):
            continue
        gaps = [one.end - true.end for one, true in zip(tried, converged, strict=True)]
        seen = tried
        if np.mean(np.max(np.abs(np.sum(gaps, axis=1)), axis=1)) <= left:
            break
    change = max(one.change for one in seen)
    return float(passes), max(USUAL * change, collocation.NOISE), left, 0.0


class Probe(NamedTuple):
    """One of the first steps of a run.

    start   the state before it (8, m)
    passes  that it took
    change  the last one that was measured
    end     (2, 2 n) the state in the frame after it and its low part, over their sizes
    """

    start: Array
    passes: int
    change: float
    end: Array


def _probed(
    problem: Problem, method: Galerkin, step: float, checks: tuple[float, ...],
    states: list[Array] | None = None,
) -> list[Probe]:  # fmt: skip
    """The first steps of a run, each from its own state if given, up to one that fails."""
    run = RunRequest(problem, method, step, PROBED, from_start(curves=False))
    work = RunArrays.of(run, frame_start(problem, method), 2, (0, 0), watched=False)
    kernel = FrameKernel(run, work, np.array(checks))
    sizes = motion_of(problem, method, step).sizes
    n, found = sizes.size // 2, []
    for k in range(PROBED if states is None else len(states)):
        before = int(work.counts[ITERATIONS])
        work.state[:] = work.state if states is None else states[k]
        start = work.state.copy()
        if kernel.advance(1) != SOLVED:
            break
        end = np.stack([work.state[row::2, :n].ravel() for row in (4, 5)])
        passes = int(work.counts[ITERATIONS]) - before
        found.append(
            Probe(start, passes, float(kernel.tables[-2][collocation.CHANGE]), end / sizes)
        )
    return found


def falls_back(checks: tuple[float, ...]) -> bool:
    """Whether the first step converged, so that others that do not are done elsewhere."""
    return checks[collocation.ALARM] >= 0.0


def enter_again(problem: Problem, method: Galerkin, q: Array, v: Array) -> Array:
    """The state at the end of a step that was done elsewhere."""
    return frame_of(method).enter(problem, q, v)


@lru_cache(maxsize=32)
def frame_start(problem: Problem, method: Galerkin) -> State:
    """State, stages and solver_state before the first step."""
    state = frame_of(method).enter(problem, problem.q0, problem.v0)
    solver_state = np.array([NOTHING, 0, 0], dtype=np.int64)
    return fixed(state, np.zeros((0, method.stages)), solver_state)


@lru_cache(maxsize=32)
def _from_pairs(problem: Problem, method: Galerkin) -> Array:
    """The matrix (d, d) from places of pairs and of the barycentre to those of bodies."""
    d = problem.q0.size
    w = np.zeros((d + 1, 2, d))
    w[:, 0] = 1.0 + np.eye(d + 1, d, -1)
    q = frame_of(method).flow(problem, w, np.zeros(d + 1)).reshape(d + 1, d)
    matrix: Array = (q[1:] - q[0]).T
    return np.ascontiguousarray(matrix)


@dataclass(frozen=True, eq=False)
class Path:
    """The curves' frame, see `galvi.curves.curves.MovingPath`."""

    problem: Problem
    method: Galerkin
    step: float
    clock: tuple[float, float, float]
    stretch: float
    elsewhere: Any

    def node(self, number: Array, tau: Array) -> tuple[Array, Array]:
        """See `MovingPath`: inverts what galvi.lanes.frames.rows.place_nodes does."""
        turns, e, phase = (self.clock[k] for k in (TURNS, ECCENTRICITY, PHASE))
        if e < 0.0:
            return tau, np.ones_like(tau)
        begin = turns * number + phase
        begin -= np.floor(begin)
        (u_0, u_1), (t_0, t_1) = revolution(TWO_PI * np.stack([begin, begin + turns]), e)
        time = t_0 + tau * (t_1 - t_0)
        u = u_0 + tau * (u_1 - u_0)
        low, high, moves = np.minimum(u_0, u_1), np.maximum(u_0, u_1), np.ones(u.shape, dtype=bool)
        for _ in range(50):  # each place by itself, whatever others are asked for
            new = u - (u - e * np.sin(u) - time) / (1.0 - e * np.cos(u))
            new = np.where(moves, np.clip(new, low, high), u)
            moves, u = moves & (np.abs(new - u) > SETTLED * np.abs(new)), new
            if not moves.any():
                break
        place = np.clip((2.0 * u - u_0 - u_1) / (u_1 - u_0), -1.0, 1.0)
        y = place
        if self.stretch >= 1e-8:
            y = np.sin(np.arcsin(self.stretch) * place) / self.stretch
        pace = stretched(y, self.stretch)[1]
        slope = (t_1 - t_0) / ((1.0 - e * np.cos(u)) * (u_1 - u_0) * pace)
        return 0.5 * (1.0 + y), slope

    def times(self, number: Any, c: Array) -> tuple[Array, Array]:
        """Times since a step's centre and weights of the nodes c, as in the kernel; of several
        steps (k, 1) they are (k, P) unless they are the same."""
        turns, e, phase = (self.clock[k] for k in (TURNS, ECCENTRICITY, PHASE))
        if e < 0.0:
            return (c - 0.5) * self.step, np.full(c.size, self.step)
        begin = turns * number + phase
        (u_0, u_1), (t_0, t_1) = revolution(TWO_PI * np.array([begin, begin + turns]), e)
        place, pace = stretched(2.0 * c - 1.0, self.stretch)
        u = 0.5 * (u_0 + u_1 + (u_1 - u_0) * place)
        scale = self.step / (t_1 - t_0)
        weights = scale * (u_1 - u_0) * pace * (1.0 - e * np.cos(u))
        return (u - e * np.sin(u) - t_0) * scale - 0.5 * self.step, weights

    def flow(self, w: Array, t: Array) -> Array:
        return frame_of(self.method).flow(self.problem, w, t)

    def places(self, curves: FrameCurves, index: Any, c: Array, since: Array) -> Array:
        """See `MovingPath`."""
        psi = curves.space.basis(np.append(c, 0.0))[:, 1:]
        psi = (psi[:-1] - psi[-1]).reshape(*c.shape, -1)
        bases, parts = curves.bases[index], curves.coefficients[index]
        (k, P), D, n = c.shape, self.problem.q0.shape[-1], parts.shape[1] // 2
        if not isinstance(self.method.chart, KeplerFrame):
            w = np.repeat(bases[:, None], P, axis=1)
            w[:, :, :2, :n] += np.matmul(psi, parts.transpose(0, 2, 1)).reshape(k, P, 2, n)
            q = self.flow(w.reshape(-1, *bases.shape[1:]), since.ravel())
            return q.reshape(k, P, -1).transpose(0, 2, 1)
        numbers, pairs = motion_of(self.problem, self.method, self.step).numbers, n // D
        masses, places = numbers[HEAD + pairs * MASS :][:pairs].copy(), np.empty((k, n + D, P))
        (rows,) = aligned((2 * D + 1, -(-P // WIDE) * WIDE))
        compiled_places_in_steps(D)(
            (0,) * D, masses, bases, parts, np.ascontiguousarray(psi.transpose(0, 2, 1)),
            np.array(since, order="C"), rows, places,
        )  # fmt: skip
        return np.matmul(_from_pairs(self.problem, self.method), places)

    def states(self, bases: Array, numbers: Any, lengths: Array) -> tuple[Array, Array, Any] | None:
        """See `MovingPath`."""
        if not isinstance(self.method.chart, KeplerFrame):
            return None
        motion = motion_of(self.problem, self.method, self.step)
        tables = tables_of(motion, self.method, np.array(CONVERGED))
        (k, _, m), d = bases.shape, self.problem.q0.size
        scratch = _scratch(motion, tables, (8, m))
        (state,) = aligned((8, m))
        phases = self.clock[TURNS] * numbers + self.clock[PHASE]
        states, codes, counts = np.empty((2, k, d)), np.zeros(k, np.int64), np.zeros(8, np.int64)
        with np.errstate(all="ignore"):
            compiled_states_in_steps()(
                motion.functions, motion.numbers.copy(), tables, motion.stretch,
                (bases, lengths, phases - np.floor(phases)), (*scratch, state),
                (states, codes, counts),
            )  # fmt: skip
        return states[0], states[1], codes

    def curves(self, number: int, base: Array) -> Curves:
        t, q, v = self.problem.t0 + number * self.step, *base[:2, : self.problem.q0.size]
        return self.elsewhere(self.problem, self.step, t, q, v)
