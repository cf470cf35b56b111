"""MuJoCo's integrators converge with their orders on all models.

In the folder of the kit: python tests/test_mujoco.py
"""

import json
import math
import unittest
from itertools import pairwise
from pathlib import Path

import mujoco
import numpy as np


def largest_error(model, truth, integrator, step):
    model.opt.integrator = getattr(mujoco.mjtIntegrator, f"mjINT_{integrator.upper()}")
    model.opt.timestep = step
    data = mujoco.MjData(model)
    mujoco.mj_resetDataKeyframe(model, data, 0)
    mujoco.mj_step(model, data, nstep=round(truth["t"] / step))
    difference = np.zeros(model.nv)
    mujoco.mj_differentiatePos(model, difference, 1.0, data.qpos, np.array(truth["qpos"]))
    return np.abs(difference).max()


class Models(unittest.TestCase):
    def check_order(self, name, integrator, convergence, truth):
        model = mujoco.MjModel.from_xml_path(f"models/{name}.xml")
        steps = convergence["steps"]
        errors = [largest_error(model, truth, integrator, step) for step in steps]
        for coarse, fine in pairwise(errors):
            with self.subTest(name, integrator=integrator):
                order = math.log2(coarse / fine)
                self.assertAlmostEqual(order, convergence["order"], delta=0.3)

    def test_integrators_converge_with_their_orders(self):
        for name in json.loads(Path("manifest.json").read_text())["models"]:
            content = json.loads(Path(f"models/{name}.json").read_text())
            for integrator, convergence in content["orders"].items():
                if convergence is not None:
                    truth = content["truth"][convergence["truth_index"]]
                    self.check_order(name, integrator, convergence, truth)


if __name__ == "__main__":
    unittest.main()
