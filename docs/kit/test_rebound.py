"""IAS15 reaches the stated errors; leapfrog and WHFast have order 2. Run it in the kit's folder."""

import json
import math
import unittest
from pathlib import Path

import rebound


def largest_error(problem, truth, integrator, step=1e-3):
    sim = rebound.Simulation()
    sim.G, sim.t, sim.integrator, sim.dt = problem["G"], problem["t0"], integrator, step
    for body in problem["bodies"]:
        sim.add(**body)
    sim.integrate(truth["t"])
    pairs = zip(sim.particles, truth["q"], strict=True)
    return max(math.dist(particle.xyz, q) for particle, q in pairs)


class PointMasses(unittest.TestCase):
    def test_errors_and_orders(self):
        for name in json.loads(Path("manifest.json").read_text())["point_masses"]:
            problem = json.loads(Path(f"point_masses/{name}.json").read_text())
            for truth in problem["truth"]:
                with self.subTest(name, t=truth["t"]):
                    self.assertLessEqual(largest_error(problem, truth, "ias15"), truth["error_q"])
            for integrator in ("leapfrog", "whfast"):
                if shown := problem["orders"][integrator]:
                    truth, steps = problem["truth"][shown["at"]], shown["steps"]
                    errors = [largest_error(problem, truth, integrator, h) for h in steps]
                    with self.subTest(name, integrator=integrator):
                        self.assertAlmostEqual(math.log2(errors[1] / errors[2]), 2, delta=0.3)


if __name__ == "__main__":
    unittest.main()
