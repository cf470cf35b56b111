"""Models of MuJoCo without contacts, and two sources of the truth of each."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cached_property, partial
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks.applications.judging.trees import INTEGRATORS, joint_errors, shifted
from benchmarks.applications.kit.orders import Convergence, Method, convergence
from benchmarks.applications.kit.truths import (
    SAMPLES,
    SHIFT,
    Source,
    States,
    Truth,
    agreed_truth,
    completed,
    restarted,
)
from benchmarks.work_precision.galvi_methods import gauss_collocation
from galvi import (
    Canonical,
    CosinePotential,
    FreeBody,
    LinearSpring,
    Problem,
    RigidBody,
    problems,
)
from galvi.arrays import Array
from galvi.interop.from_mujoco import read
from references.closed_forms.oscillator import OSCILLATOR
from references.closed_forms.pendulum import PENDULUM
from references.closed_forms.top_motion import FREE_TOP, THROWN_BODY
from references.mujoco.accelerations_ivp import MUJOCO_ACCELERATIONS
from references.mujoco.body import from_mujoco, to_mujoco
from references.mujoco.users import of_user
from references.stored.attitude import STORED_ATTITUDE
from references.stored.chain import STORED_CHAIN

FOLDER = Path(__file__).parent / "mjcf"
DURATION = 5.0  # s
TOLERANCE = 1e-13  # of DOP853
DEGREE, STEPS = 8, 1000  # of galvi, where it is the second source
GALVI_SOURCE = Source(
    f"galvi, degree {DEGREE}, {STEPS} steps",
    lambda problem, duration: completed(
        gauss_collocation(DEGREE).run(
            problem, duration, {"step": duration / STEPS, "save_every": STEPS // SAMPLES}
        ),
        "galvi",
    ),
)
MUJOCO_INTEGRATORS = {
    "Euler": "euler",
    "implicit": "implicit",
    "implicitfast": "implicitfast",
    "RK4": "rk4",
}
Motion = Callable[[Problem, float], States]  # (problem of a tree, duration) -> qpos, qvel


def _pendulum(problem: Problem, duration: float) -> States:
    """States of one hinge normal to gravity, with the centre of mass below it at angle 0."""
    link, system = problem.system.links[0], problem.system
    axis, lever = link.joints[0].axis, float(np.linalg.norm(link.centre))
    inertia = float(axis @ link.inertia @ axis) + link.mass * lever**2
    weight = link.mass * lever * float(np.linalg.norm(system.gravity))
    equivalent = Problem(Canonical(inertia, CosinePotential(weight)), problem.q0, problem.v0)
    return completed(PENDULUM.run(equivalent, duration, {"samples": SAMPLES}), PENDULUM.name)


def _spring(problem: Problem, duration: float) -> States:
    """States of one upright slide with a spring."""
    link, system = problem.system.links[0], problem.system
    joint = link.joints[0]
    equilibrium = joint.rest + link.mass * float(joint.axis @ system.gravity) / joint.stiffness
    spring = Canonical(link.mass, LinearSpring(joint.stiffness))
    equivalent = Problem(spring, problem.q0 - equilibrium, problem.v0)
    q, v = completed(OSCILLATOR.run(equivalent, duration, {"samples": SAMPLES}), OSCILLATOR.name)
    return q + equilibrium, v


def _turning_body(problem: Problem, duration: float) -> States:
    """States of one body on a ball joint at its centre of mass."""
    R, w = from_mujoco("ball", *_start(problem))
    equivalent = Problem(RigidBody(problem.system.links[0].inertia), R[0], w[0])
    run = FREE_TOP.run(equivalent, duration, {"samples": SAMPLES})
    return to_mujoco("ball", *completed(run, FREE_TOP.name))


def _thrown_body(problem: Problem, duration: float) -> States:
    """States of one body on a free joint, made of fixed links with parallel axes."""
    links = problem.system.links
    masses, centres = np.array([link.mass for link in links]), np.array([x.centre for x in links])
    centre, inertia = masses @ centres / masses.sum(), np.zeros((3, 3))
    for link in links:
        r = link.centre - centre
        inertia += link.inertia + link.mass * (r @ r * np.eye(3) - np.outer(r, r))
    q, v = from_mujoco("free", *_start(problem))
    q, v = q[0].copy(), v[0].copy()
    q[:3, 3] += q[:3, :3] @ centre
    v[3:] += np.cross(v[:3], centre)
    body = FreeBody(float(masses.sum()), inertia, problem.system.gravity)
    run = THROWN_BODY.run(Problem(body, q, v), duration, {"samples": SAMPLES})
    q, v = (x.copy() for x in completed(run, THROWN_BODY.name))
    q[:, :3, 3] -= q[:, :3, :3] @ centre
    v[:, 3:] -= np.cross(v[:, :3], centre)
    return to_mujoco("free", q, v)


def _start(problem: Problem) -> States:
    """qpos (1, nq) and qvel (1, nv)."""
    qpos, qvel = problem.system.to_mujoco(problem.q0, problem.v0)
    return qpos[None], qvel[None]


def _stored(
    reference: Any, make: Callable[[], Problem], joint: str, problem: Problem, duration: float
) -> States:
    """States of the stored truth of the problem that `make` returns, which has the same bodies."""
    run = reference.run(make(), duration, {"samples": SAMPLES})
    return to_mujoco(joint, *completed(run, reference.name))


STORED_SERIES = "heyoka's Taylor series in quadruple precision, stored with galvi"
ELLIPTIC_FUNCTIONS = "Jacobi's elliptic functions in 80 digits"
INDEPENDENT: Mapping[str, tuple[str, Motion]] = {  # truths that need no engine
    "pendulum": (ELLIPTIC_FUNCTIONS, _pendulum),
    "slide_spring": ("sines", _spring),
    "free_body_on_a_ball": (ELLIPTIC_FUNCTIONS, _turning_body),
    "free_body": (ELLIPTIC_FUNCTIONS, _thrown_body),
    "nested_free_body": (ELLIPTIC_FUNCTIONS, _thrown_body),
    "thrown_body": (ELLIPTIC_FUNCTIONS, _thrown_body),
    "heavy_top": (STORED_SERIES, partial(_stored, STORED_ATTITUDE, problems.heavy_top, "ball")),
    "ball_pendulum": (
        STORED_SERIES,
        partial(_stored, STORED_ATTITUDE, problems.pendulum_3d, "ball"),
    ),
    "double_pendulum": (
        STORED_SERIES,
        partial(_stored, STORED_CHAIN, problems.double_pendulum, "chain"),
    ),
    "chain_5": (STORED_SERIES, partial(_stored, STORED_CHAIN, problems.planar_chain, "chain")),
}


@dataclass(frozen=True, eq=False)
class Model:
    """An MJCF model with a keyframe, from which it starts.

    Attributes
    ----------
    name
        name of its files, without suffix
    """

    name: str

    @cached_property
    def mjcf(self) -> str:
        """The XML of the model."""
        return (FOLDER / f"{self.name}.xml").read_text(encoding="ascii")

    @cached_property
    def _read(self) -> tuple[Problem, Any]:
        return read(self.mjcf, key=0)

    @property
    def problem(self) -> Problem:
        """The problem that galvi reads, from MuJoCo's own start."""
        return self._read[0]

    def start(self) -> dict[str, list[float]]:
        """qpos, qvel and ctrl of the keyframe."""
        state = self._read[1].start_data()
        return {name: getattr(state, name).tolist() for name in ("qpos", "qvel", "ctrl")}

    @property
    def sources(self) -> tuple[Source, Source]:
        """Two sources of the tree's configurations and velocities."""
        if self.name in INDEPENDENT:
            label, motion = INDEPENDENT[self.name]

            def states(problem: Problem, duration: float) -> States:
                return problem.system.from_mujoco(*motion(problem, duration))

            return Source(label, states), self._accelerations
        return self._accelerations, GALVI_SOURCE

    @property
    def _accelerations(self) -> Source:
        label = f"SciPy DOP853 on MuJoCo's accelerations, tolerance {TOLERANCE:g}"
        return restarted(self._on(MUJOCO_ACCELERATIONS), label, {"tolerance": TOLERANCE})

    def _on(self, contender: Any) -> Any:
        return of_user(contender, self._read[1], self.problem)

    def truth(self) -> Truth:
        """Configurations and velocities of galvi's tree on which two sources agree."""
        shifted_problem = shifted(self.problem, SHIFT, np.ones(self.problem.q0.size))
        differences = self.differences, np.subtract
        return agreed_truth(self.problem, DURATION, self.sources, shifted_problem, differences)

    def orders(self, truth: Truth) -> dict[str, Convergence | None]:
        """Measured orders by the names of MuJoCo's integrators."""
        orders = {}
        for name, key in MUJOCO_INTEGRATORS.items():
            method = Method(self._on(INTEGRATORS[key]), {})
            orders[name] = convergence(
                self.problem, truth, INTEGRATORS[key].order, (method,), self.differences
            )
        return orders

    def differences(self, q: Array, true_q: Array) -> Array:
        """Lengths and angles by which each joint differs, (rows, joints)."""
        return joint_errors(self.problem.system, q, true_q)


def all_models() -> tuple[Model, ...]:
    """The models of the kit."""
    return tuple(Model(path.stem) for path in sorted(FOLDER.glob("*.xml")))
