"""Rotations by quaternions: RK4 and DOP853, compiled."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cache
from typing import Any, ClassVar

import numpy as np
import scipy
from numba import types

from galvi import Problem, Trajectory, input_checks
from galvi.arrays import Array
from references.as_trajectory import Failure, as_trajectory, non_finite
from references.closed_forms.top_motion import PrincipalBody, is_known_body
from references.compiled import njit
from references.contender import steps_of_run, times_of_run
from references.forces.force import OPTIONS
from references.setting import described

# The compiled loops of RK4 and DOP853 for a rigid body, in quaternions and body momentum.
#
# s        (7,) tuple: quaternion w, x, y, z of the turn since the start, momentum along the
#          principal axes
# body     `PrincipalBody.numbers`: inverse (3,) of the principal moments; force (3,), mass g in the
#          frame of the start; centre (3,) of mass; heavy, whether these two act
# state    (7,) advanced in place
# saved    (n, 7) the states after every `save_every` steps, and the last
#
# The quaternion is divided by its norm after each accepted step.

jit: Any = njit(**OPTIONS)
WHOLE, REAL = types.int64, types.float64
ROW, ROWS = types.float64[::1], types.float64[:, ::1]
BODY = types.Tuple((ROW, ROW, ROW, types.boolean))
RK4_SIGNATURE = types.int64(BODY, ROW, REAL, WHOLE, WHOLE, WHOLE, WHOLE, ROWS)
DOP853_SIGNATURE = types.UniTuple(WHOLE, 3)(
    BODY, ROW, types.Tuple((ROWS, ROW, ROW)), REAL, ROW, WHOLE
)
STAGES = 12
SAFETY, MIN_FACTOR, MAX_FACTOR, EXPONENT = 0.9, 0.2, 10.0, -1.0 / 8.0
EPS = 2.0**-52
CHUNK = 100_000  # number of steps or tries between two checks for Ctrl-C
SMALLEST_TOLERANCE = 1e-16  # below it the error is round-off
FIRST_STEP = 0.01  # over the time in which the body turns by a radian
DEFAULT: Mapping[str, Any] = {"tolerance": 1e-9}
DEFAULT_NOTE = (
    "With the default tolerance of 1e-9 it is no truth: for a truth, set tolerance=1e-15."
)
TIGHT: Mapping[str, Any] = {"tolerance": 1e-15}


@jit
def slopes(s, inverse, force, centre, heavy):
    """The derivative s' (7,) of a state with a quaternion of norm 1."""
    w, x, y, z, a, b, c = s
    u, v, r = inverse[0] * a, inverse[1] * b, inverse[2] * c
    da, db, dc = b * r - c * v, c * u - a * r, a * v - b * u
    if heavy:
        f, g, k = force
        up = 2.0 * (x * f + y * g + z * k)
        still = w * w - (x * x + y * y + z * z)
        i = still * f + up * x + 2.0 * w * (g * z - k * y)
        j = still * g + up * y + 2.0 * w * (k * x - f * z)
        l = still * k + up * z + 2.0 * w * (f * y - g * x)
        da += centre[1] * l - centre[2] * j
        db += centre[2] * i - centre[0] * l
        dc += centre[0] * j - centre[1] * i
    return (
        -0.5 * (x * u + y * v + z * r),
        0.5 * (w * u + y * r - z * v),
        0.5 * (w * v + z * u - x * r),
        0.5 * (w * r + x * v - y * u),
        da,
        db,
        dc,
    )


@jit
def moved_state(s, h, k):
    """s + h k."""
    return (
        s[0] + h * k[0],
        s[1] + h * k[1],
        s[2] + h * k[2],
        s[3] + h * k[3],
        s[4] + h * k[4],
        s[5] + h * k[5],
        s[6] + h * k[6],
    )


@jit
def normalised(s):
    """The state with its quaternion divided by its norm."""
    shrunk = 1.0 / np.sqrt(s[0] * s[0] + s[1] * s[1] + s[2] * s[2] + s[3] * s[3])
    return (s[0] * shrunk, s[1] * shrunk, s[2] * shrunk, s[3] * shrunk, s[4], s[5], s[6])


@jit
def as_tuple(row):
    """The seven entries of a row as a tuple."""
    return (row[0], row[1], row[2], row[3], row[4], row[5], row[6])


@jit
def store(s, row):
    """row <- s."""
    row[0], row[1], row[2], row[3], row[4], row[5], row[6] = s


@jit
def constants(body):
    """The arrays of a body as tuples of three numbers, and whether it is heavy."""
    inverse, force, centre, heavy = body
    return (
        (inverse[0], inverse[1], inverse[2]),
        (force[0], force[1], force[2]),
        (centre[0], centre[1], centre[2]),
        heavy,
    )


@jit
def rk4(body, state, h, first, last, total, save_every, saved):
    """Take the steps first + 1 .. last of ``total``; returns the number of the step that failed
    (0: none)."""
    numbers = constants(body)
    s = as_tuple(state)
    for k in range(first, last):
        a = slopes(s, *numbers)
        b = slopes(moved_state(s, 0.5 * h, a), *numbers)
        c = slopes(moved_state(s, 0.5 * h, b), *numbers)
        d = slopes(moved_state(s, h, c), *numbers)
        s = moved_state(
            moved_state(moved_state(moved_state(s, h / 6.0, a), h / 3.0, b), h / 3.0, c), h / 6.0, d
        )
        s = normalised(s)
        residue = (s[0] - s[0]) + (s[4] + s[5] + s[6]) * 0.0
        if residue != 0.0:  # only a NaN or an infinity leaves one
            return k + 1
        if (k + 1) % save_every == 0 or k + 1 == total:
            store(s, saved[(k + save_every) // save_every])
    store(s, state)
    return 0


@jit
def weighted(s, h, K, row, stages):
    """s + h sum_j row_j K_j."""
    for j in range(stages):
        if row[j] != 0.0:
            s = moved_state(s, h * row[j], as_tuple(K[j]))
    return s


@jit
def error_of(s, new, h, K, E3, E5, tolerance):
    """The step's estimated error over its tolerance (Hairer, Norsett and Wanner I, II.10)."""
    zero = (0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0)
    third, fifth = weighted(zero, 1.0, K, E3, STAGES), weighted(zero, 1.0, K, E5, STAGES)
    low = high = 0.0
    for i in range(7):
        scale = tolerance + tolerance * max(abs(s[i]), abs(new[i]))
        low += (third[i] / scale) ** 2
        high += (fifth[i] / scale) ** 2
    if high == 0.0:
        return 0.0
    return abs(h) * high / np.sqrt(7.0 * (high + 0.01 * low))


@jit
def dop853(body, state, tableau, tolerance, clock, budget):
    """Try up to ``budget`` steps towards the time clock[1]; returns 0 (arrived), 1 (budget spent)
    or -1 (step too small), the number of tries and the number of accepted steps.

    Parameters
    ----------
    tableau
        as `dop853_tableau` returns it
    clock : array, shape (3,)
        time, end and next step; time and next step are updated in place
    """
    numbers = constants(body)
    A, E3, E5 = tableau
    K = np.empty((STAGES, 7))
    s, max_growth, accepted = as_tuple(state), MAX_FACTOR, 0
    t, end, next_step = clock[0], clock[1], clock[2]
    store(slopes(s, *numbers), K[0])
    for attempt in range(budget):
        left = end - t
        ends = abs(next_step) >= abs(left)
        h = left if ends else next_step
        if not (ends or abs(h) > 10.0 * EPS * abs(end)):
            return -1, attempt, accepted
        for j in range(1, STAGES):
            store(slopes(weighted(s, h, K, A[j], j), *numbers), K[j])
        new = weighted(s, h, K, A[STAGES], STAGES)
        error = error_of(s, new, h, K, E3, E5, tolerance)
        if error <= 1.0:
            factor = (
                min(max_growth, max(MIN_FACTOR, SAFETY * error**EXPONENT))
                if error > 0.0
                else max_growth
            )
            next_step = max(abs(next_step), abs(h * factor)) * np.sign(h) if ends else h * factor
            s, max_growth = normalised(new), MAX_FACTOR
            t = end if ends else t + h
            accepted += 1
            store(s, state)
            clock[0], clock[2] = t, next_step
            if ends:
                return 0, attempt + 1, accepted
            store(slopes(s, *numbers), K[0])
        else:  # NaN comes here too
            factor = max(MIN_FACTOR, SAFETY * error**EXPONENT) if error > 0.0 else MIN_FACTOR
            next_step, max_growth = h * factor, 1.0
    clock[2] = next_step
    return 1, budget, accepted


@cache
def compiled(name: str) -> Callable[..., Any]:
    """The loop 'rk4' or 'dop853', compiled once and cached on disk."""
    sources: dict[str, Any] = {"rk4": (rk4, RK4_SIGNATURE), "dop853": (dop853, DOP853_SIGNATURE)}
    source, signature = sources[name]
    return njit(signature, **OPTIONS)(source.py_func)


@dataclass(frozen=True)
class QuaternionRK4:
    """The classical Runge-Kutta method on (quaternion, body momentum); setting: step, save_every.

    It computes in the principal axes, where w = J^-1 p costs three products, and allocates nothing.
    The quaternion is divided by its norm after every step, the momentum is not changed.
    """

    fixed_step: ClassVar[bool] = True

    name: str = "RK4 on quaternions, compiled"
    order: int = 4
    exact: bool = False
    missing: str = ""

    def supports(self, problem: Problem) -> bool:
        """A RigidBody that is free or has its weight."""
        return is_known_body(problem)

    def run(self, problem: Problem, duration: float, setting: Mapping[str, Any]) -> Trajectory:
        """Equal steps; see `Contender`."""
        steps = steps_of_run(self, problem, duration, setting)
        times = steps.times(problem.t0)
        body = PrincipalBody.of(problem)
        advance = compiled("rk4")
        state = body.start()
        saved = np.full((len(times), 7), np.nan)
        saved[0] = state
        save_every = int(steps.saved[1])
        failed = steps_done = 0
        while steps_done < steps.count and not failed:
            last = min(steps_done + CHUNK, steps.count)
            failed = advance(
                body.numbers, state, steps.step, steps_done, last, steps.count, save_every, saved
            )
            steps_done = failed - 1 if failed else last
        q, p = body.states(problem, saved)
        return as_trajectory(
            problem,
            described(self.name, setting),
            times,
            q,
            p=p,
            counts={"steps": steps_done, "force_evaluations": 4 * (steps_done + (failed > 0))},
            step=steps.step,
            failure=non_finite(failed, steps.saved, times) if failed else None,
        )


QUATERNION_RK4 = QuaternionRK4()


@dataclass(frozen=True)
class QuaternionDOP853:
    """Adaptive steps on (quaternion, body momentum), tableau and error estimate as in SciPy.

    Setting: samples; tolerance, both relative and absolute. The default of 1e-9 leaves about eight
    digits: add TIGHT for a truth. Samples are ends of steps.
    Otherwise as `references.textbook.quaternions.QuaternionRK4`.
    """

    fixed_step: ClassVar[bool] = False

    name: str = "DOP853 on quaternions, compiled"
    order: int = 8
    exact: bool = False
    missing: str = ""

    def supports(self, problem: Problem) -> bool:
        """A RigidBody that is free or has its weight."""
        return is_known_body(problem)

    def run(self, problem: Problem, duration: float, setting: Mapping[str, Any]) -> Trajectory:
        """Adaptive steps; see `Contender`."""
        times = times_of_run(self, problem, duration, setting, "tolerance")
        tolerance = input_checks.positive(
            "tolerance", setting.get("tolerance", DEFAULT["tolerance"])
        )
        if tolerance < SMALLEST_TOLERANCE:
            raise ValueError(
                f"tolerance must be at least {SMALLEST_TOLERANCE:g}, below which only round-off is "
                f"left; received {tolerance!r}."
            )
        body = PrincipalBody.of(problem)
        advance = compiled("dop853")
        state = body.start()
        saved = np.full((len(times), 7), np.nan)
        saved[0] = state
        angular_speed = np.max(np.abs(body.numbers[0] * body.p0))
        first = FIRST_STEP / angular_speed if angular_speed else abs(duration)
        clock = np.array([0.0, 0.0, np.copysign(min(first, abs(duration)), duration)])
        tries = steps = 0
        failure = None
        for row, t in enumerate(times[1:] - problem.t0, start=1):
            clock[1], status = t, 1
            while status == 1:
                status, attempts, accepted = advance(
                    body.numbers, state, dop853_tableau(), tolerance, clock, CHUNK
                )
                tries, steps = tries + attempts, steps + accepted
            if status < 0:
                failure = Failure(row=row, step=steps + 1, why=_stuck(problem.t0 + clock[0]))
                break
            saved[row] = state
        q, p = body.states(problem, saved)
        engine = f"tableau of scipy {scipy.__version__}"
        return as_trajectory(
            problem,
            described(self.name, {**setting, "tolerance": tolerance}, engine),
            times,
            q,
            p=p,
            counts={
                "steps": steps,
                "rejected_steps": tries - steps,
                "force_evaluations": 11 * tries + steps + 1,
            },
            failure=failure,
            notes=[] if "tolerance" in setting else [DEFAULT_NOTE],
        )


def _stuck(t: float) -> str:
    return (
        f"The step became too small at t = {t:.6g}: the state is not finite, or the "
        "tolerance cannot be reached. Loosen it, or end the run earlier."
    )


@cache
def dop853_tableau() -> tuple[Array, Array, Array]:
    """A with the weights as its last row (13, 12), and the two error estimates (12,)."""
    from scipy.integrate import DOP853

    method: Any = DOP853
    A = np.vstack([method.A, method.B])
    return tuple(np.ascontiguousarray(x) for x in (A, method.E3[:-1], method.E5[:-1]))


QUATERNION_DOP853 = QuaternionDOP853()
