"""heyoka on rigid bodies: Taylor's method on quaternions and body momentum, compiled once."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from decimal import Decimal, localcontext
from functools import lru_cache
from typing import Any, ClassVar

import numpy as np

from galvi import Problem, Trajectory
from galvi.arrays import Array
from galvi.extended_precision import decimals
from references.as_trajectory import as_trajectory
from references.closed_forms.double_double import DIGITS
from references.closed_forms.top_motion import is_known_body
from references.contender import times_of_run
from references.heyoka import engine as heyoka_engine
from references.heyoka.engine import DOUBLE
from references.newton import is_thrown
from references.rigid_equations import rotation
from references.setting import described


@dataclass(frozen=True)
class HeyokaRigid:
    """A RigidBody, free or with its weight, or a FreeBody, in double or quadruple precision.

    Attributes
    ----------
    precision
        "double", or "real128": numbers, times and states are quadruple throughout

    Notes
    -----
    Setting as in `references.heyoka.taylor.HeyokaTaylor`. Quaternions describe the rotation since
    the start and are normalised where they become matrices.
    """

    fixed_step: ClassVar[bool] = False
    engine: ClassVar[str] = "heyoka"

    name: str = "heyoka, rigid bodies"
    precision: str = "double"
    exact: bool = False

    @property
    def missing(self) -> str:
        """Why heyoka cannot be used here; empty when it can."""
        return heyoka_engine.missing(self.precision)

    def supports(self, problem: Problem) -> bool:
        """A RigidBody that is free or has its weight, or a FreeBody in gravity alone."""
        return is_known_body(problem) or is_thrown(problem)

    def run(self, problem: Problem, duration: float, setting: Mapping[str, Any]) -> Trajectory:
        """Adaptive steps; see `Contender`."""
        times = times_of_run(self, problem, duration, setting, *DOUBLE)
        options = heyoka_engine.options(setting, self.precision)
        number = heyoka_engine.number_type(self.precision)
        moving, numbers = _numbers(problem)
        kind = "thrown" if is_thrown(problem) else "heavy" if len(numbers) > 9 else "free"
        engine = _compiled(kind, self.precision, *heyoka_engine.checked_options(options))
        engine.pars[:] = [_rounded(x, number) for x in numbers]
        start = np.array([number(x) for x in (1.0, 0.0, 0.0, 0.0)])
        start = np.append(start, [_rounded(x, number) for x in moving])
        states, steps, failure = heyoka_engine.propagate(
            engine, start, times - problem.t0, problem.t0, "the state is not finite."
        )
        turned = rotation(states[:, :4])[:, None]  # (saved, 1, 3, 3)
        q0 = problem.q0[:3, :3].astype(number)
        q = np.sum(q0[:, :, None] * turned, axis=-2).astype(np.float64)
        p = states[:, 4:].astype(np.float64)
        if kind == "thrown":
            q, p = _as_rigid_motion(problem, q, p)
        p[0] = problem.p0
        return as_trajectory(
            problem,
            described(self.name, {**setting, **options}, heyoka_engine.engine_name(self.precision)),
            times,
            q,
            p=p,
            counts={"steps": steps},
            failure=failure,
        )


def _numbers(problem: Problem) -> tuple[list[Decimal], list[Decimal]]:
    """The initial values that follow those of the quaternion, and the constants of the equations.

    start      J w0; then, of a FreeBody, position and velocity of its centre in space
    constants  J^-1 by rows; then, with weight, mass g in the frame of the start and the centre of
               mass; of a FreeBody, g
    """
    with localcontext(DIGITS):
        system: Any = problem.system
        J = decimals(system.inertia)
        adjugate = np.array([np.cross(J[(i + 1) % 3], J[(i + 2) % 3]) for i in range(3)])
        constants = list((adjugate / (J[0] @ adjugate[0])).ravel())
        moving = list(J @ decimals(problem.v0[:3]))
        if is_thrown(problem):
            speed = decimals(problem.q0[:3, :3]) @ decimals(problem.v0[3:])
            return [*moving, *decimals(problem.q0[:3, 3]), *speed], [
                *constants,
                *decimals(system.g),
            ]
        weight = system.potential
        if weight is not None:
            force = decimals(problem.q0).T @ (Decimal(weight.mass) * decimals(weight.g))
            constants += [*force, *decimals(weight.centre)]
        return moving, constants


def _as_rigid_motion(problem: Problem, R: Array, moving: Array) -> tuple[Array, Array]:
    """q (saved, 4, 4) and p (saved, 6) of a FreeBody from R (saved, 3, 3) and J w, position,
    velocity."""
    q = np.zeros((len(R), 4, 4))
    q[:, :3, :3], q[:, :3, 3], q[:, 3, 3] = R, moving[:, 3:6], 1.0
    drift = problem.system.mass * np.einsum("nji,nj->ni", R, moving[:, 6:])
    return q, np.concatenate([moving[:, :3], drift], axis=-1)


def _rounded(x: Decimal, number: Any) -> Any:
    """The number in the engine's precision, as a sum of three doubles."""
    total = number(0.0)
    with localcontext(DIGITS):
        for _ in range(3):
            total, x = total + number(float(x)), x - Decimal(float(x))
    return total


@lru_cache(maxsize=16)
def _compiled(kind: str, precision: str, tolerance: float, accurate: bool, compact: bool) -> Any:
    """heyoka's integrator of a body that is "free", "heavy" or "thrown", for any start."""
    import heyoka

    number = heyoka_engine.number_type(precision)
    w, x, y, z, *p = state = heyoka.make_vars("w", "x", "y", "z", "a", "b", "c")
    par = heyoka.par
    u, v, r = (sum(par[3 * i + j] * p[j] for j in range(3)) for i in range(3))
    turning = _cross(p, (u, v, r))
    if kind == "heavy":
        force, centre = ([par[9 + 3 * k + i] for i in range(3)] for k in range(2))
        still = w * w - x * x - y * y - z * z
        up = sum(a * b for a, b in zip((x, y, z), force, strict=True))
        across = _cross(force, (x, y, z))
        turned_force = [
            still * f + 2.0 * up * e + 2.0 * w * c
            for f, e, c in zip(force, (x, y, z), across, strict=True)
        ]
        turning = [a + b for a, b in zip(turning, _cross(centre, turned_force), strict=True)]
    half = 0.5
    slopes = [
        -half * (x * u + y * v + z * r),
        half * (w * u + y * r - z * v),
        half * (w * v + z * u - x * r),
        half * (w * r + x * v - y * u),
        *turning,
    ]
    if kind == "thrown":
        position, speed = (heyoka.make_vars(*(f"{name}{i}" for i in range(3))) for name in "sd")
        state, slopes = (
            [*state, *position, *speed],
            [*slopes, *speed, *(par[9 + i] for i in range(3))],
        )
    return heyoka.taylor_adaptive(
        list(zip(state, slopes, strict=True)),
        np.array([1.0, *[0.0] * (len(state) - 1)]).astype(number),
        pars=np.zeros({"free": 9, "heavy": 15, "thrown": 12}[kind]).astype(number),
        time=number(0.0),
        tol=number(tolerance),
        high_accuracy=accurate,
        compact_mode=compact,
        fp_type=number,
    )


def _cross(a: Any, b: Any) -> list[Any]:
    return [a[i - 2] * b[i - 1] - a[i - 1] * b[i - 2] for i in range(3)]


HEYOKA_RIGID = HeyokaRigid()
HEYOKA_RIGID_QUADRUPLE = HeyokaRigid(
    "heyoka, rigid bodies, quadruple precision", precision="real128", exact=True
)
