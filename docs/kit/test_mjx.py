"""MJX's RK4 has order 4 on three models. Run it in the folder of the kit."""

import json
import math
import unittest
from pathlib import Path

import jax
import mujoco
import numpy as np
from mujoco import mjx

jax.config.update("jax_enable_x64", True)
advance = jax.jit(lambda m, d, n: jax.lax.fori_loop(0, n, lambda k, d: mjx.step(m, d), d))


def largest_error(model, truth, step):
    model.opt.integrator, model.opt.timestep = mujoco.mjtIntegrator.mjINT_RK4, step
    data, off = mujoco.MjData(model), np.zeros(model.nv)
    mujoco.mj_resetDataKeyframe(model, data, 0)
    end = advance(mjx.put_model(model), mjx.put_data(model, data), round(truth["t"] / step))
    mujoco.mj_differentiatePos(model, off, 1.0, np.array(end.qpos), np.array(truth["qpos"]))
    return abs(off).max()


class Models(unittest.TestCase):
    def test_rk4(self):
        for name in ("pendulum", "free_body", "heavy_top"):
            case = json.loads(Path(f"models/{name}.json").read_text())
            model = mujoco.MjModel.from_xml_path(f"models/{name}.xml")
            shown = case["orders"]["RK4"]
            truth = case["truth"][shown["at"]]
            errors = [largest_error(model, truth, step) for step in shown["steps"]]
            with self.subTest(name):
                self.assertAlmostEqual(math.log2(errors[1] / errors[2]), 4, delta=0.3)


if __name__ == "__main__":
    unittest.main()
