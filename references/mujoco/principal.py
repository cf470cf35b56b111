"""Principal axes of an inertia, as MuJoCo takes them."""

from __future__ import annotations

import numpy as np

from galvi.arrays import Array

SLACK = 1e-12  # relative: below that, moments are zero, and a flat body's are flat


def principal(inertia: Array) -> tuple[Array, Array]:
    """Moments, (3,), and the quaternion of their axes, (4,), with w first.

    MuJoCo's own ``fullinertia`` is off by some 10 roundings, and its order of the axes is its own.
    """
    from scipy.spatial.transform import Rotation

    moments, axes = np.diag(inertia).copy(), np.eye(3)
    if np.any(inertia != np.diag(moments)):
        moments, axes = np.linalg.eigh(inertia)
        axes[:, 0] *= np.linalg.det(axes)
    k = int(np.argmax(moments))
    rest = float(np.sum(np.delete(moments, k)))
    if moments[k] <= rest * (1.0 + SLACK):
        moments[k] = min(moments[k], rest)  # a flat body may be off by a rounding; MuJoCo's may not
    return moments, Rotation.from_matrix(axes).as_quat()[[3, 0, 1, 2]]
