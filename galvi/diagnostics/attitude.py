"""The attitudes of a run as SciPy rotations, and their orthogonality defect."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from galvi.arrays import Array
from galvi.groups.se3 import SE3
from galvi.groups.so3 import SO3
from galvi.input_checks import shown
from galvi.trajectory import Trajectory

if TYPE_CHECKING:
    from scipy.spatial.transform import Rotation


def rotations(run: Trajectory, t: Any = None) -> Rotation:
    """The attitudes at steps, or on the curve at t, as `scipy.spatial.transform.Rotation`.

    It converts further: ``.as_quat(scalar_first=True)``, ``.as_euler("zyx")``, ``.magnitude()``.
    For runs on SO(3) and SE(3); raises ValueError for others and for states past a failure,
    TypeError for something that is not a Trajectory.
    """
    R = _matrices(run, t)
    if not np.all(np.isfinite(R)):
        raise ValueError(
            "the run failed, and its states past the failure are NaN; take them out first, e.g. "
            "with t up to the failed step."
        )
    from scipy.spatial.transform import Rotation  # a fifth of galvi's import

    return Rotation.from_matrix(R)


def orthogonality_defect(run: Trajectory, t: Any = None) -> Array:
    """The largest entry of |R^T R - I|, (saved,) at steps, or of t's shape on the curve."""
    R = _matrices(run, t)
    square = np.einsum("...ki,...kj->...ij", R, R)
    defect: Array = np.max(np.abs(square - np.eye(3)), axis=(-2, -1))
    return defect


def _matrices(run: Trajectory, t: Any) -> Array:
    if not isinstance(run, Trajectory):
        raise TypeError(f"run must be a galvi.Trajectory; received {shown(run)}.")
    group = getattr(run.problem.system, "group", None)
    if not isinstance(group, (SO3, SE3)):
        raise ValueError(
            f"attitudes need a run on SO(3) or SE(3), such as of a galvi.RigidBody; received "
            f"{run!r}."
        )
    q: Array = run.q if t is None else run(t)
    return q[..., :3, :3]
