"""Runs models in another MuJoCo version: a program for the Python of that environment.

It reads {"models": {joint: {"mjcf": ..., "qpos": [...], "qvel": [...]}}, "steps": [...],
"duration": T, "samples": n} from its input, as JSON, and writes {"version": ..., "runs": [...]},
each run with joint, integrator, step and the rows of qpos and qvel after T / n, 2 T / n, ... T.
Nothing is judged here, so that all versions are judged alike.
"""

from __future__ import annotations

import json
import sys
from typing import Any

INTEGRATORS = ("Euler", "RK4", "implicit", "implicitfast", "discrete")


def runs(job: dict[str, Any]) -> dict[str, Any]:
    """Every model by every integrator that this version offers, at every step."""
    import mujoco

    mujoco.set_mju_user_warning(lambda message: None)
    found = []
    for joint, given in job["models"].items():
        model = mujoco.MjModel.from_xml_string(given["mjcf"])
        data = mujoco.MjData(model)
        for integrator in INTEGRATORS:
            kind = getattr(mujoco.mjtIntegrator, f"mjINT_{integrator.upper()}", None)
            if kind is None:
                continue
            model.opt.integrator = kind
            for step in job["steps"]:
                model.opt.timestep = step
                mujoco.mj_resetData(model, data)
                data.qpos[:], data.qvel[:] = given["qpos"], given["qvel"]
                rows: dict[str, list[list[float]]] = {"qpos": [], "qvel": []}
                for _ in range(job["samples"]):
                    mujoco.mj_step(
                        model, data, nstep=round(job["duration"] / job["samples"] / step)
                    )
                    rows["qpos"].append(data.qpos.tolist())
                    rows["qvel"].append(data.qvel.tolist())
                found.append({"joint": joint, "integrator": integrator, "step": step, **rows})
    return {"version": mujoco.__version__, "runs": found}


if __name__ == "__main__":
    json.dump(runs(json.load(sys.stdin)), sys.stdout)
