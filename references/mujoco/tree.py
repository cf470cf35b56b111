"""Converts trees of rigid bodies to MuJoCo."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from galvi import Joint, Link, Multibody, Problem
from references.mujoco.mjcf import OFF, document, principal, text

SCALAR = ("hinge", "slide")


def is_tree(problem: Problem) -> bool:
    """Trees whose springs MJCF can say: a ball joint's at rest where the link is at its place."""
    system = problem.system
    return isinstance(system, Multibody) and not any(
        joint.type == "ball" and joint.stiffness and np.any(joint.rest != np.eye(3))
        for link in system.links
        for joint in link.joints
    )


@dataclass(frozen=True, eq=False)
class MujocoTree:
    """Nested bodies. ``joint`` is the system itself, which converts states."""

    joint: Multibody

    def mjcf(self) -> str:
        """MuJoCo's XML; its numbers are read back bit for bit, but for quaternions."""
        links = self.joint.links
        inner = [""] * len(links)
        bodies = ""
        for k in range(len(links) - 1, -1, -1):
            body = _body(links[k], inner[k])
            if links[k].parent is None:
                bodies = body + bodies
            else:
                inner[links[k].parent] = body + inner[links[k].parent]
        off = tuple(name for name in OFF if name not in ("spring", "damper", "eulerdamp"))
        return document(self.joint.gravity, bodies, off)


def _body(link: Link, inner: str) -> str:
    from scipy.spatial.transform import Rotation

    place, turn = link.place, link.attitude
    if any(joint.type == "free" for joint in link.joints):
        rest = link.joints[0].rest  # which a free joint's spring has from its body's place
        place, turn = rest[:3, 3], rest[:3, :3]
    inertial = ""
    if link.mass > 0.0:
        moments, axes = principal(link.inertia)
        inertial = (
            f'<inertial pos="{text(link.centre)}" quat="{text(axes)}" mass="{text([link.mass])}" '
            f'diaginertia="{text(moments)}"/>'
        )
    joints = "".join(_joint(joint) for joint in link.joints)
    quaternion = text(Rotation.from_matrix(turn).as_quat()[[3, 0, 1, 2]])
    return f'<body pos="{text(place)}" quat="{quaternion}">{joints}{inertial}{inner}</body>'


def _joint(joint: Joint) -> str:
    given: dict[str, Any] = {
        "armature": joint.armature, "stiffness": joint.stiffness, "damping": joint.damping,
    }  # fmt: skip
    if joint.type != "free":
        given["pos"] = joint.anchor
    if joint.type in SCALAR:
        given |= {"axis": joint.axis, "ref": joint.zero, "springref": joint.rest}
    settings = " ".join(f'{name}="{text(np.ravel(value))}"' for name, value in given.items())
    return f'<joint type="{joint.type}" {settings}/>'
