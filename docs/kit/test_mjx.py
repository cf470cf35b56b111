"""MJX's RK4 converges with order 4 on three models.

In the folder of the kit: python tests/test_mjx.py
"""

import json
import math
import unittest
from itertools import pairwise
from pathlib import Path

import jax
import mujoco
import numpy as np
from mujoco import mjx

jax.config.update("jax_enable_x64", True)


@jax.jit
def advance(model, data, count):
    return jax.lax.fori_loop(0, count, lambda _, state: mjx.step(model, state), data)


def largest_error(model, truth, step):
    model.opt.integrator = mujoco.mjtIntegrator.mjINT_RK4
    model.opt.timestep = step
    start = mujoco.MjData(model)
    mujoco.mj_resetDataKeyframe(model, start, 0)
    count = round(truth["t"] / step)
    end = advance(mjx.put_model(model), mjx.put_data(model, start), count)
    difference = np.zeros(model.nv)
    qpos = np.array(end.qpos)
    mujoco.mj_differentiatePos(model, difference, 1.0, qpos, np.array(truth["qpos"]))
    return np.abs(difference).max()


class Models(unittest.TestCase):
    def test_rk4_converges_with_order_4(self):
        for name in ("pendulum", "free_body", "heavy_top"):
            content = json.loads(Path(f"models/{name}.json").read_text())
            model = mujoco.MjModel.from_xml_path(f"models/{name}.xml")
            convergence = content["orders"]["RK4"]
            truth = content["truth"][convergence["truth_index"]]
            errors = [largest_error(model, truth, step) for step in convergence["steps"]]
            for coarse, fine in pairwise(errors):
                with self.subTest(name):
                    self.assertAlmostEqual(math.log2(coarse / fine), 4, delta=0.3)


if __name__ == "__main__":
    unittest.main()
