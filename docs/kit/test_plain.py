"""A leapfrog integrator in plain Python converges with order 2 on three bodies.

In the folder of the kit: python tests/test_plain.py
"""

import json
import math
import unittest
from itertools import pairwise
from pathlib import Path


def accelerations(G, masses, positions):
    return [
        [
            sum(
                G * mass * (source[axis] - position[axis]) / math.dist(source, position) ** 3
                for mass, source in zip(masses, positions, strict=True)
                if source is not position
            )
            for axis in range(3)
        ]
        for position in positions
    ]


def advanced(vectors, rates, time):
    return [
        [x + time * rate for x, rate in zip(vector, derivative, strict=True)]
        for vector, derivative in zip(vectors, rates, strict=True)
    ]


def leapfrog(problem, step, count):
    masses = [body["m"] for body in problem["bodies"]]
    positions = [[body["x"], body["y"], body["z"]] for body in problem["bodies"]]
    velocities = [[body["vx"], body["vy"], body["vz"]] for body in problem["bodies"]]
    for _ in range(count):
        positions = advanced(positions, velocities, step / 2)
        rates = accelerations(problem["G"], masses, positions)
        velocities = advanced(velocities, rates, step)
        positions = advanced(positions, velocities, step / 2)
    return positions


class Leapfrog(unittest.TestCase):
    def test_it_converges_with_order_2(self):
        problem = json.loads(Path("point_masses/figure_eight.json").read_text())
        convergence = problem["orders"]["leapfrog"]
        truth = problem["truth"][convergence["truth_index"]]
        errors = []
        for step in convergence["steps"]:
            count = round((truth["t"] - problem["t0"]) / step)
            positions = leapfrog(problem, step, count)
            errors.append(max(map(math.dist, positions, truth["q"])))
        for coarse, fine in pairwise(errors):
            self.assertAlmostEqual(math.log2(coarse / fine), 2, delta=0.3)


if __name__ == "__main__":
    unittest.main()
