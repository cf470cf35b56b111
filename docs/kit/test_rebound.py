"""REBOUND's IAS15 reaches the stated error, and its leapfrog has order 2. Run in the kit's folder."""

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
    def test_ias15_and_leapfrog(self):
        for name in json.loads(Path("manifest.json").read_text())["point_masses"]:
            problem = json.loads(Path(f"point_masses/{name}.json").read_text())
            for truth in problem["truth"]:
                with self.subTest(name, t=truth["t"]):
                    self.assertLessEqual(largest_error(problem, truth, "ias15"), truth["error_q"])
            if seen := problem["orders"]["leapfrog"]:
                truth = problem["truth"][seen["at"]]
                errors = [largest_error(problem, truth, "leapfrog", h) for h in seen["steps"]]
                for coarse, fine in zip(errors, errors[1:], strict=False):
                    with self.subTest(name, step=seen["steps"]):
                        self.assertAlmostEqual(math.log2(coarse / fine), seen["order"], delta=0.3)


if __name__ == "__main__":
    unittest.main()
