"""IAS15 meets the stated errors; leapfrog and WHFast converge with order 2.

In the folder of the kit: python tests/test_rebound.py
"""

import json
import math
import unittest
from itertools import pairwise, product
from pathlib import Path

import rebound


def largest_error(problem, truth, integrator, step=1e-3):
    simulation = rebound.Simulation()
    simulation.integrator = integrator
    simulation.G = problem["G"]
    simulation.t = problem["t0"]
    simulation.dt = step
    for body in problem["bodies"]:
        simulation.add(**body)
    simulation.integrate(truth["t"])
    positions = [particle.xyz for particle in simulation.particles]
    return max(map(math.dist, positions, truth["q"]))


class PointMasses(unittest.TestCase):
    def setUp(self):
        names = json.loads(Path("manifest.json").read_text())["point_masses"]
        self.problems = [
            json.loads(Path(f"point_masses/{name}.json").read_text()) for name in names
        ]

    def test_ias15_meets_the_stated_errors(self):
        for problem in self.problems:
            for truth in problem["truth"]:
                with self.subTest(problem["name"], t=truth["t"]):
                    error = largest_error(problem, truth, "ias15")
                    self.assertLessEqual(error, truth["error_q"])

    def test_leapfrog_and_whfast_converge_with_order_2(self):
        for problem, integrator in product(self.problems, ("leapfrog", "whfast")):
            convergence = problem["orders"][integrator]
            if convergence is None:
                continue
            truth = problem["truth"][convergence["truth_index"]]
            steps = convergence["steps"]
            errors = [largest_error(problem, truth, integrator, step) for step in steps]
            for coarse, fine in pairwise(errors):
                with self.subTest(problem["name"], integrator=integrator):
                    self.assertAlmostEqual(math.log2(coarse / fine), 2, delta=0.3)


if __name__ == "__main__":
    unittest.main()
