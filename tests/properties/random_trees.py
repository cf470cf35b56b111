"""Random trees of rigid bodies as MJCF, without contacts."""

import numpy as np

FLAGS = '<flag contact="disable"/>'


def text(numbers):
    """Numbers with the digits that determine them."""
    return " ".join(repr(float(x)) for x in np.ravel(numbers))


def _joint(joint_type, random, springs, damping, armature_needed):
    normal, settings = random.normal, ""
    if armature_needed or random.random() < 0.5:
        settings += f' armature="{random.uniform(0.05, 0.5)}"'
    if springs and random.random() < 0.5:
        settings += f' stiffness="{random.uniform(0.1, 4.0)}"'
    if damping and random.random() < 0.5:
        settings += f' damping="{random.uniform(0.05, 0.5)}"'
    if joint_type in ("hinge", "slide"):
        axis = normal(size=3) if random.random() < 0.6 else np.eye(3)[random.integers(3)]
        settings += f' axis="{text(axis if random.random() < 0.7 else -axis)}"'
        if random.random() < 0.5:
            settings += f' ref="{normal()}" springref="{normal()}"'
    if joint_type != "free":
        settings += f' pos="{text(0.3 * normal(size=3) * (random.random() < 0.7))}"'
    return f'<joint type="{joint_type}"{settings}/>'


def _inertia(random):
    root = random.normal(size=(4, 3))
    moments = np.trace(root.T @ root) * np.eye(3) - root.T @ root
    full = text(moments[[0, 1, 2, 0, 0, 1], [0, 1, 2, 1, 2, 2]] + [0.1, 0.1, 0.1, 0, 0, 0])
    centre, mass = text(0.4 * random.normal(size=3)), random.uniform(0.3, 3.0)
    return f'<inertial pos="{centre}" mass="{mass}" fullinertia="{full}"/>'


def random_tree(joints, seed, springs=True, damping=True, kinds=("hinge", "slide", "ball", "free")):
    """MJCF of random trees with ``joints`` joints in all, up to three on a body."""
    random = np.random.default_rng(seed)
    bodies, joints_left = [], joints  # joints, parent
    while joints_left > 0:
        parent = int(random.integers(-1, len(bodies))) if random.random() < 0.9 else -1
        joint_count = min(joints_left, int(random.choice([0, 1, 1, 1, 2, 3])))
        joint_types = [str(random.choice(kinds)) for _ in range(joint_count)]
        if "free" in joint_types:
            parent, joint_types = -1, ["free"]
        if "ball" in joint_types:  # MuJoCo wants it last among rotations
            joint_types = [kind for kind in joint_types if kind != "ball"] + ["ball"]
        if parent == -1 and not joint_types:
            continue
        bodies.append((joint_types, parent))
        joints_left -= len(joint_types)
    elements = [""] * len(bodies)
    for k, (joint_types, parent) in reversed(list(enumerate(bodies))):
        # Without armature, slides in a row and joints about one point may make M singular.
        armature_needed = "slide" in joint_types or len(joint_types) > 1
        inner = "".join(
            _joint(kind, random, springs, damping, armature_needed) for kind in joint_types
        )
        position, quaternion = text(0.5 * random.normal(size=3)), text(random.normal(size=4))
        unrotated = random.random() < 0.4
        opening = f'<body pos="{position}"' + ("" if unrotated else f' quat="{quaternion}"') + ">"
        elements[k] = f"{opening}{inner}{_inertia(random)}{elements[k]}</body>"
        if parent >= 0:
            elements[parent] = elements[k] + elements[parent]
            elements[k] = ""
    gravity = text(random.normal(size=3) * [1.0, 1.0, 5.0])
    return (
        f'<mujoco><compiler angle="radian"/><option gravity="{gravity}">{FLAGS}</option>'
        f"<worldbody>{''.join(elements)}</worldbody></mujoco>"
    )


def random_state(model, seed):
    """qpos with unit quaternions, and qvel."""
    import mujoco

    random = np.random.default_rng(seed)
    qpos, qvel = random.normal(size=model.nq), random.normal(size=model.nv)
    mujoco.mj_normalizeQuat(model, qpos)
    return qpos, qvel
