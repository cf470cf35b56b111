"""MuJoCo's XML of bodies that nothing touches, read back bit for bit, in their principal axes."""

from __future__ import annotations

from typing import Any

import numpy as np

from galvi.arrays import Array

OFF = (
    *("contact", "constraint", "equality", "frictionloss", "limit", "spring", "damper"),
    *("clampctrl", "actuation", "sensor", "eulerdamp", "island", "warmstart", "autoreset"),
)  # what lone bodies have not, 4 % of a step; and the reset that would hide a failure


def document(gravity: Any, bodies: str, off: tuple[str, ...] = OFF) -> str:
    """The XML of a model with these bodies and gravity (3,); angles are in radians.

    off  names of what is disabled
    """
    flags = " ".join(f'{name}="disable"' for name in off)
    return (
        f'<mujoco><compiler angle="radian"/><option gravity="{text(gravity)}">'
        f"<flag {flags}/></option><worldbody>{bodies}</worldbody></mujoco>"
    )


def text(numbers: Any) -> str:
    """Numbers separated by spaces, each with the digits that determine its float64."""
    return " ".join(repr(float(number)) for number in numbers)


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
