"""The curves of steps in a moving frame, and states within them."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import numpy as np

from galvi.arrays import Array
from galvi.curves.curves import Curves, FrameCurves
from galvi.frames.frame import revolution
from galvi.frames.kepler_frame import KeplerFrame
from galvi.kernels.constants import TWO_PI
from galvi.lanes.frames.kepler_motion import HEAD, MASS
from galvi.lanes.frames.rows import ECCENTRICITY, PHASE, REVOLUTIONS
from galvi.lanes.within_steps import (
    POINTS_AT_ONCE,
    compiled_places_in_steps,
    compiled_states_in_steps,
)
from galvi.method import Galerkin
from galvi.problem import Problem
from galvi.run.in_frame.inertial import inertial_curves
from galvi.run.in_frame.kernel import frame_of, motion_of, scratch_of, stretched_nodes, tables_of
from galvi.run.in_frame.passes import CONVERGED
from galvi.run.in_lanes.tables import aligned

ANOMALY_TOLERANCE = 2.0**-51  # relative change up to which Newton's method for an anomaly converged


@lru_cache(maxsize=32)
def _bodies_from_pairs(problem: Problem, method: Galerkin) -> Array:
    """The matrix (d, d) from positions of pairs and of the barycentre to positions of bodies."""
    d = problem.q0.size
    w = np.zeros((d + 1, 2, d))
    w[:, 0] = 1.0 + np.eye(d + 1, d, -1)
    q = frame_of(method).flow(problem, w, np.zeros(d + 1)).reshape(d + 1, d)
    return np.ascontiguousarray((q[1:] - q[0]).T)


@dataclass(frozen=True, eq=False)
class FrameOfRun:
    """The moving frame of a run, in which `galvi.curves.curves.FrameCurves` are evaluated."""

    problem: Problem
    method: Galerkin
    step: float
    clock: tuple[float, float, float]
    stretch: float

    def node(self, number: Array, tau: Array) -> tuple[Array, Array]:
        """The node c and dc/dtau at fractions tau (k,) of the steps ``number`` (k,) since the
        problem's start; the inverse of galvi.lanes.frames.rows.place_nodes."""
        revolutions_per_step, e, phase = (self.clock[k] for k in (REVOLUTIONS, ECCENTRICITY, PHASE))
        if e < 0.0:
            return tau, np.ones_like(tau)
        begin = revolutions_per_step * number + phase
        begin -= np.floor(begin)
        (u_0, u_1), (t_0, t_1) = revolution(
            TWO_PI * np.stack([begin, begin + revolutions_per_step]), e
        )
        time = t_0 + tau * (t_1 - t_0)
        u = u_0 + tau * (u_1 - u_0)
        low, high, is_moving = (
            np.minimum(u_0, u_1),
            np.maximum(u_0, u_1),
            np.ones(u.shape, dtype=bool),
        )
        for _ in range(50):  # an anomaly that has converged stays, whatever the others do
            new_u = u - (u - e * np.sin(u) - time) / (1.0 - e * np.cos(u))
            new_u = np.where(is_moving, np.clip(new_u, low, high), u)
            is_moving, u = (
                is_moving & (np.abs(new_u - u) > ANOMALY_TOLERANCE * np.abs(new_u)),
                new_u,
            )
            if not is_moving.any():
                break
        scaled_anomaly = np.clip((2.0 * u - u_0 - u_1) / (u_1 - u_0), -1.0, 1.0)
        y = scaled_anomaly
        if self.stretch >= 1e-8:
            y = np.sin(np.arcsin(self.stretch) * scaled_anomaly) / self.stretch
        stretch_rate = stretched_nodes(y, self.stretch)[1]
        slope = (t_1 - t_0) / ((1.0 - e * np.cos(u)) * (u_1 - u_0) * stretch_rate)
        return 0.5 * (1.0 + y), slope

    def times(self, number: Any, c: Array) -> tuple[Array, Array]:
        """Times (k, P) since the centres of steps ``number`` (k, 1) at nodes c (P,), and dt/dc, as
        in the kernel; both (P,) where they are the same for all steps."""
        turns, e, phase = (self.clock[k] for k in (REVOLUTIONS, ECCENTRICITY, PHASE))
        if e < 0.0:
            return (c - 0.5) * self.step, np.full(c.size, self.step)
        begin = turns * number + phase
        (u_0, u_1), (t_0, t_1) = revolution(TWO_PI * np.array([begin, begin + turns]), e)
        scaled_anomaly, stretch_rate = stretched_nodes(2.0 * c - 1.0, self.stretch)
        u = 0.5 * (u_0 + u_1 + (u_1 - u_0) * scaled_anomaly)
        scale = self.step / (t_1 - t_0)
        weights = scale * (u_1 - u_0) * stretch_rate * (1.0 - e * np.cos(u))
        return (u - e * np.sin(u) - t_0) * scale - 0.5 * self.step, weights

    def flow(self, w: Array, t: Array) -> Array:
        """q (k, *shape) at times t (k,) after w (k, 2, m), or (k, 4, m) with its low parts."""
        return frame_of(self.method).flow(self.problem, w, t)

    def positions(self, curves: FrameCurves, index: Any, c: Array, since: Array) -> Array:
        """q (k, d, P) on the steps ``index`` (k,) of these curves at nodes c (k, P), whose times
        since the centres of the steps are ``since`` (k, P)."""
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
        masses, positions = numbers[HEAD + pairs * MASS :][:pairs].copy(), np.empty((k, n + D, P))
        (rows,) = aligned((2 * D + 1, -(-P // POINTS_AT_ONCE) * POINTS_AT_ONCE))
        compiled_places_in_steps(D)(
            (0,) * D,
            masses,
            bases,
            parts,
            np.ascontiguousarray(psi.transpose(0, 2, 1)),
            np.array(since, order="C"),
            rows,
            positions,
        )
        return np.matmul(_bodies_from_pairs(self.problem, self.method), positions)

    def states(self, bases: Array, numbers: Any, lengths: Array) -> tuple[Array, Array, Any] | None:
        """q and v (k, d) after shortened steps of times ``lengths`` (k,) from the starts of the
        steps with these bases and numbers, and codes (k,), which are not 0 where one failed; None
        unless the frame is a `KeplerFrame`."""
        if not isinstance(self.method.chart, KeplerFrame):
            return None
        motion = motion_of(self.problem, self.method, self.step)
        tables = tables_of(motion, self.method, np.array(CONVERGED))
        (k, _, m), d = bases.shape, self.problem.q0.size
        scratch = scratch_of(motion, tables, (8, m))
        (state,) = aligned((8, m))
        phases = self.clock[REVOLUTIONS] * numbers + self.clock[PHASE]
        states, codes, counts = np.empty((2, k, d)), np.zeros(k, np.int64), np.zeros(8, np.int64)
        with np.errstate(all="ignore"):
            compiled_states_in_steps()(
                motion.functions,
                motion.numbers.copy(),
                tables,
                motion.stretch,
                (bases, lengths, phases - np.floor(phases)),
                (*scratch, state),
                (states, codes, counts),
            )
        return states[0], states[1], codes

    def curves(self, number: int, base: Array) -> Curves:
        """The curves of a step that was done in the inertial frame; it begins at time 0."""
        t, q, v = self.problem.t0 + number * self.step, *base[:2, : self.problem.q0.size]
        return inertial_curves(self.problem, self.step, t, q, v)
