"""Planets in steps longer than the period of some of them: the studies of V9 and V10."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import pandas as pd

import galvi
from benchmarks.checks.claim import MakeMethod, Report
from benchmarks.measures.errors import PER_STEP, curve_times, energy_errors
from benchmarks.measures.orbit_shape import angle, extent, perihelion, period
from benchmarks.measures.refinement import method_of, outcome
from benchmarks.store.tables import history, number, pick, row, rows, table_of
from galvi import Problem, Trajectory
from references.rebound import ias15

DISTANCE, AT_END = "distance to IAS15", "distance to IAS15 at the end"
ENERGY = "energy error"
CHANGE, DIFFERENCE = "change of extent", "extent against IAS15"
TURN, SHIFT = "perihelion against IAS15", "perihelion against IAS15, times the eccentricity"
ALONG = "distance to IAS15 on the curve"
MEAN = "mean distance"
IN_FRAME = ", in the Kepler frame"  # after DISTANCE and ENERGY
CURVE, ENDS = "position on the curve", "position at step ends"


@dataclass(frozen=True, eq=False)
class LongSteps:
    """A planetary problem in a few long steps.

    Attributes
    ----------
    step, steps
        step size in days, and number of steps
    ns
        numbers of basis functions; orbits and shapes are measured with the first
    watched
        bodies whose extent and perihelion are measured
    samples
        number of samples of the orbits, a multiple of `steps`
    """

    problem: Problem
    step: float
    steps: int
    ns: tuple[int, ...]
    watched: tuple[str, ...]
    samples: int

    @property
    def bodies(self) -> tuple[str, ...]:
        return self.problem.parameters["bodies"]

    def study(self, make_method: MakeMethod, report: Report) -> pd.DataFrame:
        """Series, with the body in `label` (au, rad, relative for the energy):

        'n = ...'    distance to IAS15, largest over step ends and at the end; energy error
        'shape'      extents over the first and the last revolution, their mean and their change
                     relative to it, their difference from IAS15's; the perihelion's direction, also
                     times the eccentricity: how far that turns the ellipse, relative to its size;
                     largest distance to IAS15 on the curve
        'orbit'      positions from the first body, 'position on the curve' and 'at step ends'
        'frame'      with n - 1 Gauss points in the Kepler frame: as 'n = ...'
        'reference'  distance between IAS15 with its two step criteria, at the end
        """
        report("IAS15")
        duration, n = self.step * self.steps, self.ns[0]
        truth = ias15.IAS15.run(self.problem, duration, {"samples": self.samples})
        by_global = ias15.IAS15.run(self.problem, duration, {"samples": 1, **ias15.GLOBAL})
        gap = np.linalg.norm(truth.q[-1] - by_global.q[-1], axis=-1)
        observations = [
            row(study="reference", quantity=AT_END, label=body, value=gap[k])
            for k, body in enumerate(self.bodies)
        ]
        chart = galvi.KeplerFrame()
        in_frame = make_method(galvi.Polynomials(n - 1), galvi.gauss(n - 1), chart)
        methods = {f"n = {k}": (k, method_of(make_method, k), "") for k in self.ns}
        for name, (k, method, suffix) in {**methods, "frame": (n, in_frame, IN_FRAME)}.items():
            report(f"{name}, {self.steps} steps of {self.step:g} d")
            run = galvi.integrate(self.problem, method, self.step, self.steps)
            observations += self._errors(run, truth, suffix, study=name, n=k)
            if name == f"n = {n}":
                observations += self._orbits(run) + self._shapes(run, truth)
        return table_of(observations)

    def _errors(
        self, run: Trajectory, truth: Trajectory, suffix: str, **settings: Any
    ) -> list[dict[str, Any]]:
        settings |= {"step": self.step, "steps": self.steps, **outcome(run)}
        distance = np.linalg.norm(run.q - truth.q[:: self.samples // self.steps], axis=-1)
        energy = float(np.max(np.abs(energy_errors(run))))
        observations = [row(quantity=ENERGY + suffix, value=energy, **settings)]
        for k, body in enumerate(self.bodies):
            values = {DISTANCE + suffix: np.max(distance[:, k]), AT_END + suffix: distance[-1, k]}
            observations += rows(values, label=body, **settings)
        return observations

    def _orbits(self, run: Trajectory) -> list[dict[str, Any]]:
        times = curve_times(run, PER_STEP)
        return [
            observation
            for quantity, t, q in ((CURVE, times, run(times)), (ENDS, run.t, run.q))
            for k, body in enumerate(self.bodies)
            for observation in history(
                quantity, t, q[:, k] - q[:, 0], study="orbit", n=self.ns[0], label=body
            )
        ]

    def _shapes(self, run: Trajectory, truth: Trajectory) -> list[dict[str, Any]]:
        q, end = run(truth.t), float(truth.t[-1])
        observations = []
        for body in self.watched:
            k = self.bodies.index(body)
            revolution = period(self.problem, k)
            first, last, exact = (
                np.array(extent(truth.t, positions, k, start, start + revolution))
                for positions, start in (
                    (q, 0.0),
                    (q, end - revolution),
                    (truth.q, end - revolution),
                )
            )
            direction, exact_direction = perihelion(run, k)[-1], perihelion(truth, k)[-1]
            angle_between = angle(direction, exact_direction)
            values = {
                "closest distance, first revolution": first[0],
                "farthest distance, first revolution": first[1],
                "closest distance, last revolution": last[0],
                "farthest distance, last revolution": last[1],
                CHANGE: np.max(np.abs(last - first)) / np.mean(first),
                DIFFERENCE: np.max(np.abs(last - exact)),
                TURN: angle_between,
                SHIFT: angle_between * np.linalg.norm(exact_direction),
                MEAN: np.mean(first),
                ALONG: np.max(np.linalg.norm(q[:, k] - truth.q[:, k], axis=-1)),
            }
            observations += rows(values, study="shape", n=self.ns[0], label=body)
        return observations


def worst(
    table: pd.DataFrame,
    bodies: Sequence[str],
    quantity: str,
    study: str = "shape",
    relative: bool = False,
) -> float:
    """The largest value over the bodies, relative to the mean distance where `relative`; NaN when
    one is missing."""
    sizes = pick(table, study=study, quantity=quantity)
    means = pick(table, quantity=MEAN)
    scale = {body: number(means, label=body) if relative else 1.0 for body in bodies}
    return float(np.max([number(sizes, label=body) / scale[body] for body in bodies]))
