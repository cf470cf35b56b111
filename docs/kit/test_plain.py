"""A leapfrog in plain Python has order 2 on three bodies. Run it in the folder of the kit."""

import json
import math
import unittest
from pathlib import Path


def kick(G, masses, q, v, h):
    for a, speed in zip(q, v, strict=True):
        for m, b in zip(masses, q, strict=True):
            if a is not b:
                pull = h * G * m / math.dist(a, b) ** 3
                speed[:] = [s + pull * (y - x) for s, x, y in zip(speed, a, b, strict=True)]


def drift(q, v, h):
    for x, speed in zip(q, v, strict=True):
        x[:] = [y + h * s for y, s in zip(x, speed, strict=True)]


class Leapfrog(unittest.TestCase):
    def test_order(self):
        problem = json.loads(Path("point_masses/figure_eight.json").read_text())
        shown, errors = problem["orders"]["leapfrog"], []
        truth = problem["truth"][shown["at"]]
        for h in shown["steps"]:
            masses = [body["m"] for body in problem["bodies"]]
            q, v = ([[body[x] for x in xs] for body in problem["bodies"]]
                    for xs in (("x", "y", "z"), ("vx", "vy", "vz")))  # fmt: skip
            for _ in range(round((truth["t"] - problem["t0"]) / h)):
                drift(q, v, h / 2)
                kick(problem["G"], masses, q, v, h)
                drift(q, v, h / 2)
            errors.append(max(map(math.dist, q, truth["q"])))
        self.assertAlmostEqual(math.log2(errors[1] / errors[2]), 2, delta=0.3)


if __name__ == "__main__":
    unittest.main()
