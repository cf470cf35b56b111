"""Random trees of rigid bodies as MJCF, without contacts."""

import numpy as np

FLAGS = '<flag contact="disable"/>'


def text(numbers):
    """Numbers with the digits that determine them."""
    return " ".join(repr(float(x)) for x in np.ravel(numbers))


def _joint(kind, random, springs, damping, heavy):
    size, settings = random.normal, ""
    if heavy or random.random() < 0.5:
        settings += f' armature="{random.uniform(0.05, 0.5)}"'
    if springs and random.random() < 0.5:
        settings += f' stiffness="{random.uniform(0.1, 4.0)}"'
    if damping and random.random() < 0.5:
        settings += f' damping="{random.uniform(0.05, 0.5)}"'
    if kind in ("hinge", "slide"):
        axis = size(size=3) if random.random() < 0.6 else np.eye(3)[random.integers(3)]
        settings += f' axis="{text(axis if random.random() < 0.7 else -axis)}"'
        if random.random() < 0.5:
            settings += f' ref="{size()}" springref="{size()}"'
    if kind != "free":
        settings += f' pos="{text(0.3 * size(size=3) * (random.random() < 0.7))}"'
    return f'<joint type="{kind}"{settings}/>'


def _inertia(random):
    root = random.normal(size=(4, 3))
    moments = np.trace(root.T @ root) * np.eye(3) - root.T @ root
    full = text(moments[[0, 1, 2, 0, 0, 1], [0, 1, 2, 1, 2, 2]] + [0.1, 0.1, 0.1, 0, 0, 0])
    centre, mass = text(0.4 * random.normal(size=3)), random.uniform(0.3, 3.0)
    return f'<inertial pos="{centre}" mass="{mass}" fullinertia="{full}"/>'


def random_tree(joints, seed, springs=True, damping=True, kinds=("hinge", "slide", "ball", "free")):
    """MJCF of some trees with this number of joints, some bodies with several, some with none."""
    random = np.random.default_rng(seed)
    bodies, left = [], joints  # joints, parent
    while left > 0:
        parent = int(random.integers(-1, len(bodies))) if random.random() < 0.9 else -1
        several = min(left, int(random.choice([0, 1, 1, 1, 2, 3])))
        chosen = [str(random.choice(kinds)) for _ in range(several)]
        if "free" in chosen:
            parent, chosen = -1, ["free"]
        if "ball" in chosen:  # MuJoCo wants it last among rotations
            chosen = [kind for kind in chosen if kind != "ball"] + ["ball"]
        if parent == -1 and not chosen:
            continue
        bodies.append((chosen, parent))
        left -= len(chosen)
    elements = [""] * len(bodies)
    for k, (chosen, parent) in reversed(list(enumerate(bodies))):
        # Slides that follow each other, and joints about one point, need it: else M is singular.
        heavy = "slide" in chosen or len(chosen) > 1
        inner = "".join(_joint(kind, random, springs, damping, heavy) for kind in chosen)
        position, turn = text(0.5 * random.normal(size=3)), text(random.normal(size=4))
        plain = random.random() < 0.4
        head = f'<body pos="{position}"' + ("" if plain else f' quat="{turn}"') + ">"
        elements[k] = f"{head}{inner}{_inertia(random)}{elements[k]}</body>"
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
