"""Runs a user's own MuJoCo model, as it is: a program for the Python of any release's environment.

It reads a job from its input and writes an answer, both as JSON:

    job     {"file": path} or {"mjcf": text}; "key", "qpos", "qvel", "ctrl": the start, each may be
            absent; "runs": a list of {"integrator": name, "step": h, "qpos", "qvel", each of which
            may be absent, "steps": n, "every": k, "rounding": seed, may be absent}; "states": a
            list of {"qpos", "qvel"}; "threads"
    answer  {"release", "integrator", "step", "qpos", "qvel": the model's own; "runs": for each the
            rows of qpos, qvel, energy and the kinetic part of it at every k-th step after the
            start, and "failure", a sentence or ""; "accelerations": qacc at each state, "energies":
            of each state}

Nothing is judged here, so that all releases are judged alike.
"""

from __future__ import annotations

import copy
import json
import math
import sys
from concurrent.futures import ThreadPoolExecutor
from typing import Any

# How failures begin: of a release that cannot run the model, and of one in which it diverges.
NO_INTEGRATOR, WARNED = "This release has no integrator", "MuJoCo warned of"


def loaded(job: dict[str, Any]) -> Any:
    """The model of a job."""
    import mujoco

    if "mjcf" in job:
        return mujoco.MjModel.from_xml_string(job["mjcf"])
    if job["file"].endswith(".mjb"):
        return mujoco.MjModel.from_binary_path(job["file"])
    return mujoco.MjModel.from_xml_path(job["file"])


def at_start(model: Any, *starts: dict[str, Any]) -> Any:
    """Data at the start: of each mapping what it has, the last one's first."""
    import mujoco

    data = mujoco.MjData(model)
    key = starts[0].get("key")
    if key is not None:
        number = model.key(key).id if isinstance(key, str) else key
        mujoco.mj_resetDataKeyframe(model, data, number)
    for start in starts:
        for name in ("qpos", "qvel", "ctrl"):
            if start.get(name) is not None:
                getattr(data, name)[:] = start[name]
    return data


def energy(model: Any, data: Any) -> list[float]:
    """Potential and kinetic energy of the state."""
    import mujoco

    seen = mujoco.MjData(model)
    seen.qpos[:], seen.qvel[:] = data.qpos, data.qvel
    seen.mocap_pos[:], seen.mocap_quat[:] = data.mocap_pos, data.mocap_quat
    mujoco.mj_fwdPosition(model, seen)
    mujoco.mj_fwdVelocity(model, seen)
    mujoco.mj_energyPos(model, seen)
    mujoco.mj_energyVel(model, seen)
    return seen.energy.tolist()


PARTS = 100  # of the steps between rows, after which rounding is imitated


def advance(model: Any, data: Any, count: int, signs: Any) -> None:
    """So many steps. With signs, a random generator, each entry is off by as much as errors of an
    ulp of it in each step add up to."""
    import mujoco

    part = count if signs is None else math.ceil(count / PARTS)
    for first in range(0, count, part):
        steps = min(part, count - first)
        mujoco.mj_step(model, data, nstep=steps)
        if signs is not None:
            for values in (data.qpos, data.qvel):
                ulps = math.sqrt(steps) * signs.choice((-1.0, 1.0), values.size)
                values *= 1.0 + sys.float_info.epsilon * ulps


def run(model: Any, job: dict[str, Any], asked: dict[str, Any]) -> dict[str, Any]:
    """One run of the job; up to its failure where it fails."""
    import mujoco
    import numpy as np

    mine = copy.copy(model)
    rows: dict[str, Any] = {"qpos": [], "qvel": [], "energy": [], "kinetic": [], "failure": ""}
    if asked.get("integrator") is not None:
        kind = getattr(mujoco.mjtIntegrator, f"mjINT_{asked['integrator'].upper()}", None)
        if kind is None:
            return {**rows, "failure": f"{NO_INTEGRATOR} {asked['integrator']}."}
        mine.opt.integrator = kind
    if asked.get("step") is not None:
        mine.opt.timestep = asked["step"]
    data = at_start(mine, job, asked)
    signs = np.random.default_rng(asked["rounding"]) if "rounding" in asked else None
    for _ in range(asked["steps"] // asked["every"]):
        advance(mine, data, asked["every"], signs)
        mujoco.mj_checkPos(mine, data)
        mujoco.mj_checkVel(mine, data)
        warned = [index for index, each in enumerate(data.warning) if each.number]
        if warned:
            name = mujoco.mjtWarning(warned[0]).name.removeprefix("mjWARN_")
            return {**rows, "failure": f"{WARNED} {name} by t = {data.time:g}."}
        rows["qpos"].append(data.qpos.tolist())
        rows["qvel"].append(data.qvel.tolist())
        parts = energy(mine, data)
        rows["energy"].append(sum(parts))
        rows["kinetic"].append(parts[1])
    return rows


def acceleration(model: Any, data: Any) -> list[float]:
    """qacc at the state."""
    import mujoco

    mujoco.mj_forward(model, data)
    return data.qacc.tolist()


def answer(job: dict[str, Any]) -> dict[str, Any]:
    """The answer to a job."""
    import mujoco

    mujoco.set_mju_user_warning(lambda message: None)
    model = loaded(job)
    start = at_start(model, job)
    states = [at_start(model, job, each) for each in job.get("states", [])]
    with ThreadPoolExecutor(job.get("threads", 1)) as pool:
        runs = list(pool.map(lambda asked: run(model, job, asked), job.get("runs", [])))
    return {
        "release": mujoco.__version__,
        "integrator": mujoco.mjtIntegrator(model.opt.integrator).name.removeprefix("mjINT_"),
        "step": model.opt.timestep,
        "qpos": start.qpos.tolist(),
        "qvel": start.qvel.tolist(),
        "runs": runs,
        "energies": [sum(energy(model, data)) for data in states],
        "accelerations": [acceleration(model, data) for data in states],
    }


if __name__ == "__main__":
    json.dump(answer(json.load(sys.stdin)), sys.stdout)
