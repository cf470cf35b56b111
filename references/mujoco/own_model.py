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

The program assesses nothing, so that all releases are assessed alike.
"""

from __future__ import annotations

import copy
import json
import math
import sys
from concurrent.futures import ThreadPoolExecutor
from typing import Any

# Beginnings of the sentences on failures: the release has no such integrator; MuJoCo warned.
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
    """Data at the start; the entries of later mappings replace those of earlier ones."""
    import mujoco

    mj_data = mujoco.MjData(model)
    key = starts[0].get("key")
    if key is not None:
        number = model.key(key).id if isinstance(key, str) else key
        mujoco.mj_resetDataKeyframe(model, mj_data, number)
    for start in starts:
        for name in ("qpos", "qvel", "ctrl"):
            if start.get(name) is not None:
                getattr(mj_data, name)[:] = start[name]
    return mj_data


def energy(model: Any, mj_data: Any) -> list[float]:
    """Potential and kinetic energy of the state."""
    import mujoco

    evaluated = mujoco.MjData(model)
    evaluated.qpos[:], evaluated.qvel[:] = mj_data.qpos, mj_data.qvel
    evaluated.mocap_pos[:], evaluated.mocap_quat[:] = mj_data.mocap_pos, mj_data.mocap_quat
    mujoco.mj_fwdPosition(model, evaluated)
    mujoco.mj_fwdVelocity(model, evaluated)
    mujoco.mj_energyPos(model, evaluated)
    mujoco.mj_energyVel(model, evaluated)
    return evaluated.energy.tolist()


PARTS = 100  # largest number of parts of the steps between rows; after each, rounding is imitated


def advance(model: Any, mj_data: Any, count: int, signs: Any) -> None:
    """Take ``count`` steps. With ``signs``, a random generator, each entry is perturbed by the
    accumulated error of one ulp a step."""
    import mujoco

    part = count if signs is None else math.ceil(count / PARTS)
    for first in range(0, count, part):
        steps = min(part, count - first)
        mujoco.mj_step(model, mj_data, nstep=steps)
        if signs is not None:
            for values in (mj_data.qpos, mj_data.qvel):
                ulps = math.sqrt(steps) * signs.choice((-1.0, 1.0), values.size)
                values *= 1.0 + sys.float_info.epsilon * ulps


def run(model: Any, job: dict[str, Any], request: dict[str, Any]) -> dict[str, Any]:
    """The rows of one run of the job, up to its failure if it fails."""
    import mujoco
    import numpy as np

    run_model = copy.copy(model)
    rows: dict[str, Any] = {"qpos": [], "qvel": [], "energy": [], "kinetic": [], "failure": ""}
    if request.get("integrator") is not None:
        kind = getattr(mujoco.mjtIntegrator, f"mjINT_{request['integrator'].upper()}", None)
        if kind is None:
            return {**rows, "failure": f"{NO_INTEGRATOR} {request['integrator']}."}
        run_model.opt.integrator = kind
    if request.get("step") is not None:
        run_model.opt.timestep = request["step"]
    mj_data = at_start(run_model, job, request)
    signs = np.random.default_rng(request["rounding"]) if "rounding" in request else None
    for _ in range(request["steps"] // request["every"]):
        advance(run_model, mj_data, request["every"], signs)
        mujoco.mj_checkPos(run_model, mj_data)
        mujoco.mj_checkVel(run_model, mj_data)
        warned = [index for index, warning in enumerate(mj_data.warning) if warning.number]
        if warned:
            name = mujoco.mjtWarning(warned[0]).name.removeprefix("mjWARN_")
            return {**rows, "failure": f"{WARNED} {name} by t = {mj_data.time:g}."}
        rows["qpos"].append(mj_data.qpos.tolist())
        rows["qvel"].append(mj_data.qvel.tolist())
        parts = energy(run_model, mj_data)
        rows["energy"].append(sum(parts))
        rows["kinetic"].append(parts[1])
    return rows


def acceleration(model: Any, mj_data: Any) -> list[float]:
    """qacc at the state."""
    import mujoco

    mujoco.mj_forward(model, mj_data)
    return mj_data.qacc.tolist()


def answer(job: dict[str, Any]) -> dict[str, Any]:
    """The answer to a job."""
    import mujoco

    mujoco.set_mju_user_warning(lambda message: None)
    model = loaded(job)
    start = at_start(model, job)
    states = [at_start(model, job, state) for state in job.get("states", [])]
    with ThreadPoolExecutor(job.get("threads", 1)) as pool:
        runs = list(pool.map(lambda request: run(model, job, request), job.get("runs", [])))
    return {
        "release": mujoco.__version__,
        "integrator": mujoco.mjtIntegrator(model.opt.integrator).name.removeprefix("mjINT_"),
        "step": model.opt.timestep,
        "qpos": start.qpos.tolist(),
        "qvel": start.qvel.tolist(),
        "runs": runs,
        "energies": [sum(energy(model, mj_data)) for mj_data in states],
        "accelerations": [acceleration(model, mj_data) for mj_data in states],
    }


if __name__ == "__main__":
    json.dump(answer(json.load(sys.stdin)), sys.stdout)
