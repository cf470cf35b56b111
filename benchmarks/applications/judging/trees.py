"""Truths, integrators and errors of the joints for a judgement of trees of rigid bodies."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Mapping
from dataclasses import replace
from typing import Any

import numpy as np
import pandas as pd

from benchmarks.applications.judging.candidate import Candidate, Model, Source, UserSetting
from benchmarks.work_precision.galvi_methods import gauss_collocation
from benchmarks.work_precision.problem import galvi_label
from galvi import Problem, Trajectory
from galvi.arrays import Array
from galvi.interop.mujoco_model import check_reading
from references import Contender
from references.mujoco.accelerations_ivp import MUJOCO_ACCELERATIONS
from references.mujoco.steps import (
    MUJOCO_DISCRETE,
    MUJOCO_EULER,
    MUJOCO_IMPLICIT,
    MUJOCO_IMPLICITFAST,
    MUJOCO_RK4,
)
from references.mujoco.users import of_user
from references.pinocchio.tree import PINOCCHIO_ACCELERATIONS

DEFAULT_DURATION = 10.0
INTEGRATORS = {  # by their names in MuJoCo, in lower case
    "euler": MUJOCO_EULER,
    "rk4": MUJOCO_RK4,
    "implicit": MUJOCO_IMPLICIT,
    "implicitfast": MUJOCO_IMPLICITFAST,
    "discrete": MUJOCO_DISCRETE,
}
ADAPTIVE: tuple[str, ...] = ()
PART, ENGINE = "joint", "mujoco-core"
ENGINE_HINT = "install the extra trees (pip install pin) for Pinocchio as a second"
UNITS = {"length": " rad or m", "time": " s"}
REST_LIMIT = 1e-9  # rad or m: a joint that moves by no more is at rest
ANOTHER = (
    ", with --key 0 for the first keyframe, where the model has one, or --qpos and --qvel, in "
    "galvi.judge key=0, qpos=..., qvel=..."
)
TIGHT, LOOSE = 1e-13, 1e-11  # tolerances
SECOND_SOURCE_STEPS = 30_000  # steps of the second source
COARSEST = 200  # steps of MuJoCo's integrators in the whole time, to begin with
GALVI_DEGREES = (4, 8)  # degrees
GALVI_COARSEST = 100
QPOS_ENTRIES = {"hinge": 1, "slide": 1, "ball": 4, "free": 7}


def model(problem: Problem) -> Model:
    """The model of a problem; MuJoCo's model is made from it with MuJoCo's default options."""
    note = "MuJoCo's model was made from the problem, with MuJoCo's default options."
    return Model(problem, notes=(note,))


def default_duration(problem: Problem) -> float:
    """10 units of time."""
    return DEFAULT_DURATION


def states(problem: Problem, duration: float) -> int:
    """Always 1: trees have no encounters to find."""
    return 1


def span(duration: float, step: float) -> float:
    """The duration; ValueError for a negative one, since MuJoCo does not run backwards."""
    if duration < 0.0:
        raise ValueError(
            f"a model of MuJoCo's goes forwards in time: duration must be positive; received "
            f"{duration:g}."
        )
    return duration


def own_contender(model: Model, name: str) -> Contender:
    """The integrator of this name on the user's own model, with all its options."""
    return _on(model, INTEGRATORS[name])


def _on(model: Model, contender: Any) -> Any:
    return contender if model.native is None else of_user(contender, model.native, model.problem)


def label(contender: Contender, options: Mapping[str, Any]) -> str:
    """The integrator's name."""
    return contender.name


def engine_hint(model: Model) -> str:
    """How to install Pinocchio; "" with forces beside springs and damping, which it lacks."""
    return ENGINE_HINT if model.problem.system.given_force[0] is None else ""


def check(model: Model, truth: Trajectory) -> None:
    """Raise ValueError where MuJoCo's accelerations at states of the truth are not the
    problem's."""
    if model.native is not None:
        rows = np.linspace(0, len(truth.t) - 1, 4).astype(int)
        check_reading(model.native, model.problem, [(truth.q[k], truth.v[k]) for k in rows])


def unit(problem: Problem, dimension: str) -> str:
    """MuJoCo's unit with a space before it."""
    return UNITS[dimension]


def notes(model: Model, user_setting: UserSetting, truth: Trajectory) -> list[str]:
    """A warning where a floating model moves as one rigid body; otherwise no sentences."""
    system = truth.problem.system
    inner = np.array([joint.type != "free" for joint in system.tree.joints])
    if inner.all() or not inner.any() or _largest_motion(truth)[inner].max() > REST_LIMIT:
        return []
    return [
        "Warning: from this start the model moves as one rigid body, and nothing moves in its "
        "joints, so that this run says nothing of their errors. Start from a keyframe (--key, in "
        "galvi.judge key=...) or from velocities (--qvel, qvel=...) at which the joints move."
    ]


def sources(model: Model, duration: float, user_setting: UserSetting) -> list[Source]:
    """DOP853 on MuJoCo's accelerations of the user's model and on Pinocchio's, or at two tolerances
    where Pinocchio is missing; MuJoCo's RK4 and galvi at small steps."""
    problem, no_pinocchio = model.problem, bool(PINOCCHIO_ACCELERATIONS.missing)
    accelerations = _on(model, MUJOCO_ACCELERATIONS)
    all_sources = [
        _dop853("MuJoCo", accelerations, TIGHT),
        _dop853("MuJoCo", accelerations, LOOSE)
        if no_pinocchio
        else _dop853("Pinocchio", PINOCCHIO_ACCELERATIONS, TIGHT),
        Source(
            "MuJoCo RK4, small steps",
            "MuJoCo",
            _on(model, MUJOCO_RK4),
            {},
            duration / SECOND_SOURCE_STEPS,
        ),
        Source("galvi degree 8", "", gauss_collocation(8), {}, duration / 2000),
    ]
    return [
        source
        for source in all_sources
        if not source.contender.missing and source.contender.supports(problem)
    ]


def _dop853(engine: str, contender: Contender, tolerance: float) -> Source:
    label = f"DOP853 on {engine}'s accelerations, tolerance {tolerance:g}"
    return Source(label, engine, contender, {"tolerance": tolerance})


def candidates(
    model: Model, duration: float, user_setting: UserSetting
) -> Iterator[list[Candidate]]:
    """Yield the steps to begin with, for galvi and for each integrator of MuJoCo but the user's, on
    the user's model."""
    for degree in GALVI_DEGREES:
        yield [Candidate(galvi_label(degree), gauss_collocation(degree), {}, GALVI_COARSEST)]
    for contender in INTEGRATORS.values():
        on_model = _on(model, contender)
        can_run = not on_model.missing and on_model.supports(model.problem)
        if can_run and contender.name != user_setting.name:
            yield [Candidate(contender.name, on_model, {}, COARSEST)]


def shifted(problem: Problem, amount: float, signs: Any) -> Problem:
    """The problem from angles and lengths that differ by `amount`, relative where above 1."""
    system = problem.system
    qpos, qvel = system.to_mujoco(problem.q0, problem.v0)
    shifted_qpos = qpos + amount * np.maximum(np.abs(qpos), 1.0) * signs[: qpos.size]
    return problem.with_initial_state(*system.from_mujoco(shifted_qpos, qvel))


def errors(run: Trajectory, truth: Trajectory) -> Array:
    """The error of each joint, (saved, joints): an angle, a length, or the larger of both."""
    return joint_errors(run.problem.system, run.q, truth.q)


def joint_errors(system: Any, q: Array, true_q: Array) -> Array:
    """The errors (saved, joints) of configurations of a tree, (saved, ...)."""
    # `to_mujoco` needs velocities, which do not change qpos
    velocities = np.zeros((len(q), system.group.dimension))
    qpos, true_qpos = (
        system.to_mujoco(configurations, velocities)[0] for configurations in (q, true_q)
    )
    columns, offset = [], 0
    for joint in system.tree.joints:
        part, true_part = (
            x[:, offset : offset + QPOS_ENTRIES[joint.type]] for x in (qpos, true_qpos)
        )
        offset += QPOS_ENTRIES[joint.type]
        if joint.type in ("hinge", "slide"):
            columns.append(np.abs(part - true_part)[:, 0])
            continue
        angle = _angle(part[:, -4:], true_part[:, -4:])
        length = np.linalg.norm(part[:, :-4] - true_part[:, :-4], axis=1)
        columns.append(np.maximum(angle, length))
    return np.stack(columns, axis=1)


def size(truth: Trajectory) -> float:
    """The largest distance of a joint from its start."""
    return float(np.max(_largest_motion(truth)))


def _largest_motion(truth: Trajectory) -> Array:
    """The largest distance of each joint from its start."""
    start = replace(truth, q=np.broadcast_to(truth.q[0], truth.q.shape))
    return errors(truth, start).max(axis=0)


def _angle(left: Array, right: Array) -> Array:
    """The angle between rotations given by unit quaternions (saved, 4)."""
    along = np.sum(left * right, axis=1)
    across = np.linalg.norm(left - np.copysign(1.0, along)[:, None] * right, axis=1)
    return 4.0 * np.arcsin(np.minimum(0.5 * across, 1.0))


def names(problem: Problem) -> list[str]:
    """The names of the joints; a joint without a name has its type and its link's name."""
    system = problem.system
    labels = []
    for k, link in enumerate(system.links):
        link_name = link.name or f"link {k}"
        unnamed_counts = Counter(joint.type for joint in link.joints if not joint.name)
        type_counts: Counter[str] = Counter()
        for joint in link.joints:
            type_counts[joint.type] += 1
            suffix = f" {type_counts[joint.type]}" if unnamed_counts[joint.type] > 1 else ""
            labels.append(joint.name or f"{joint.type}{suffix} of {link_name}")
    return labels


def entries(problem: Problem) -> list[str]:
    """The names of the entries of qpos, after their joints."""
    system = problem.system
    labels = []
    for joint, name in zip(system.tree.joints, names(problem), strict=True):
        count = QPOS_ENTRIES[joint.type]
        letters = ("x", "y", "z", "qw", "qx", "qy", "qz")[-count:]
        labels += [name] if count == 1 else [f"{name} {letter}" for letter in letters]
    return labels


def by_part(run: Trajectory, truth: Trajectory) -> pd.DataFrame:
    """The largest and the last error of each joint."""
    joint_errors_over_time = errors(run, truth)
    columns: dict[str, Any] = {
        "joint": names(run.problem),
        "largest_error": joint_errors_over_time.max(axis=0),
    }
    return pd.DataFrame({**columns, "last_error": joint_errors_over_time[-1]})


def encounters(truth: Trajectory) -> pd.DataFrame:
    """There are none: contacts are no part of these models."""
    return pd.DataFrame()
