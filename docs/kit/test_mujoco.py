"""MuJoCo's integrators have their orders on all models. Run it in the folder of the kit."""

import json
import math
import unittest
from pathlib import Path

import mujoco
import numpy as np


def largest_error(model, truth, integrator, step):
    model.opt.integrator = getattr(mujoco.mjtIntegrator, f"mjINT_{integrator.upper()}")
    model.opt.timestep = step
    data, off = mujoco.MjData(model), np.zeros(model.nv)
    mujoco.mj_resetDataKeyframe(model, data, 0)
    mujoco.mj_step(model, data, nstep=round(truth["t"] / step))
    mujoco.mj_differentiatePos(model, off, 1.0, data.qpos, np.array(truth["qpos"]))
    return abs(off).max()


class Models(unittest.TestCase):
    def test_orders(self):
        for name in json.loads(Path("manifest.json").read_text())["models"]:
            case = json.loads(Path(f"models/{name}.json").read_text())
            model = mujoco.MjModel.from_xml_path(f"models/{name}.xml")
            for integrator, shown in case["orders"].items():
                if shown:
                    truth, steps = case["truth"][shown["at"]], shown["steps"]
                    errors = [largest_error(model, truth, integrator, h) for h in steps]
                    with self.subTest(name, integrator=integrator):
                        order = math.log2(errors[1] / errors[2])
                        self.assertAlmostEqual(order, shown["order"], delta=0.3)


if __name__ == "__main__":
    unittest.main()
