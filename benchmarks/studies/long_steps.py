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
from benchmarks.measures.refinement import method_of
from benchmarks.statistics import readings
from benchmarks.store.frames import frame, number, pick, row
from galvi import Problem, Trajectory
from references.rebound import ias15

DISTANCE, AT_END = "distance to IAS15", "distance to IAS15 at the end"
ENERGY = "energy error"
CHANGE, DIFFERENCE = "change of extent", "extent against IAS15"
TURN, SHIFT = "perihelion against IAS15", "perihelion against IAS15, times the eccentricity"
ALONG = "distance to IAS15 on the curve"
MEAN = "mean distance"
FRAME_DISTANCE = "distance to IAS15, in the Kepler frame"
FRAME_ENERGY = "energy error, in the Kepler frame"
CURVE, ENDS = "position on the curve", "position at step ends"


@dataclass(frozen=True, eq=False)
class LongSteps:
    """A planetary problem in a few long steps.

    step, steps  size, in days, and number
    ns           numbers of basis functions; orbits and shapes are those of the first
    watched      bodies whose extent and perihelion are measured
    samples      of the orbits, a multiple of steps
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
        'frame'      with n - 1 Gauss points in the Kepler frame: distance to IAS15, largest over
                     step ends, and energy error
        'reference'  distance between IAS15 with its two step criteria, at the end
        """
        report("IAS15")
        duration = self.step * self.steps
        truth = ias15.IAS15.run(self.problem, duration, {"samples": self.samples})
        other = ias15.IAS15.run(self.problem, duration, {"samples": 1, **ias15.GLOBAL})
        gap = np.linalg.norm(truth.q[-1] - other.q[-1], axis=-1)
        rows = [
            row(study="reference", quantity=AT_END, label=body, value=gap[k])
            for k, body in enumerate(self.bodies)
        ]
        for n in self.ns:
            report(f"n = {n}, {self.steps} steps of {self.step:g} d")
            method = method_of(make_method, n)
            run = galvi.integrate(self.problem, method, self.step, self.steps)
            rows += self._errors(run, truth, n)
            if n == self.ns[0]:
                rows += self._orbits(run) + self._shapes(run, truth)
        report(f"the Kepler frame, {self.steps} steps of {self.step:g} d")
        return frame(rows + self._in_frame(make_method, truth))

    def _in_frame(self, make_method: MakeMethod, truth: Trajectory) -> list[dict[str, Any]]:
        n = self.ns[0]
        space, rule = galvi.Polynomials(n - 1), galvi.gauss(n - 1)
        method = make_method(space, rule, galvi.KeplerFrame())
        run = galvi.integrate(self.problem, method, self.step, self.steps)
        distance = np.linalg.norm(run.q - truth.q[:: self.samples // self.steps], axis=-1)
        known = {"study": "frame", "n": n, "step": self.step, "steps": self.steps,
                 "status": "" if run.success else run.status,
                 "force_evaluations": run.counts["force_evaluations"]}  # fmt: skip
        energy = float(np.max(np.abs(energy_errors(run))))
        return [row(quantity=FRAME_ENERGY, value=energy, **known)] + [
            row(quantity=FRAME_DISTANCE, label=body, value=float(np.max(distance[:, k])), **known)
            for k, body in enumerate(self.bodies)
        ]

    def _errors(self, run: Trajectory, truth: Trajectory, n: int) -> list[dict[str, Any]]:
        settings = {
            "study": f"n = {n}",
            "n": n,
            "step": self.step,
            "steps": self.steps,
            "status": "" if run.success else run.status,
            "force_evaluations": run.counts["force_evaluations"],
        }
        distance = np.linalg.norm(run.q - truth.q[:: self.samples // self.steps], axis=-1)
        energy = float(np.max(np.abs(energy_errors(run))))
        rows = [row(quantity=ENERGY, value=energy, **settings)]
        for k, body in enumerate(self.bodies):
            largest = float(np.max(distance[:, k]))
            rows.append(row(quantity=DISTANCE, label=body, value=largest, **settings))
            rows.append(row(quantity=AT_END, label=body, value=distance[-1, k], **settings))
        return rows

    def _orbits(self, run: Trajectory) -> list[dict[str, Any]]:
        times = curve_times(run, PER_STEP)
        rows = []
        for quantity, t, q in ((CURVE, times, run(times)), (ENDS, run.t, run.q)):
            place = q - q[:, :1]
            for k, body in enumerate(self.bodies):
                rows += [
                    row(study="orbit", quantity=quantity, n=self.ns[0], label=body, t=s,
                        x=x, y=y, z=z)
                    for s, (x, y, z) in zip(t, place[:, k], strict=True)
                ]  # fmt: skip
        return rows

    def _shapes(self, run: Trajectory, truth: Trajectory) -> list[dict[str, Any]]:
        q, end = run(truth.t), float(truth.t[-1])
        rows = []
        for body in self.watched:
            k = self.bodies.index(body)
            year = period(self.problem, k)
            first, last, exact = (
                np.array(extent(truth.t, places, k, start, start + year))
                for places, start in ((q, 0.0), (q, end - year), (truth.q, end - year))
            )
            towards, there = perihelion(run, k)[-1], perihelion(truth, k)[-1]
            turned = angle(towards, there)
            for quantity, value in (
                ("closest distance, first revolution", first[0]),
                ("farthest distance, first revolution", first[1]),
                ("closest distance, last revolution", last[0]),
                ("farthest distance, last revolution", last[1]),
                (CHANGE, np.max(np.abs(last - first)) / np.mean(first)),
                (DIFFERENCE, np.max(np.abs(last - exact))),
                (TURN, turned),
                (SHIFT, turned * np.linalg.norm(there)),
                (MEAN, np.mean(first)),
                (ALONG, np.max(np.linalg.norm(q[:, k] - truth.q[:, k], axis=-1))),
            ):
                rows.append(
                    row(study="shape", quantity=quantity, n=self.ns[0], label=body, value=value)
                )
        return rows


def distance_at_end(table: pd.DataFrame, n: int, body: str) -> float:
    """Distance from IAS15 at the end in au; NaN when it was not measured."""
    return number(table, study=f"n = {n}", quantity=AT_END, label=body)


def farthest_at_end(table: pd.DataFrame, n: int, bodies: Sequence[str]) -> float:
    """The largest `distance_at_end`; NaN when one is missing."""
    return readings.largest([distance_at_end(table, n, body) for body in bodies])


def energy_error(table: pd.DataFrame, n: int) -> float:
    """Largest relative energy error over step ends; NaN when it was not measured."""
    return number(table, study=f"n = {n}", quantity=ENERGY)


def worst_relative(
    table: pd.DataFrame, bodies: Sequence[str], quantity: str, study: str = "shape"
) -> float:
    """The largest over the bodies of a length over the mean distance; NaN when one is missing."""
    rows, mean = pick(table, study=study, quantity=quantity), pick(table, quantity=MEAN)
    return readings.largest(
        [number(rows, label=body) / number(mean, label=body) for body in bodies]
    )


def worst_shape(table: pd.DataFrame, quantity: str, bodies: Sequence[str]) -> float:
    """The largest of a quantity of series 'shape' over the bodies; NaN when one is missing."""
    rows = pick(table, study="shape", quantity=quantity)
    return readings.largest([number(rows, label=body) for body in bodies])


def farthest_in_frame(table: pd.DataFrame, bodies: Sequence[str]) -> float:
    """The largest distance from IAS15 at step ends in the Kepler frame, au."""
    rows = pick(table, study="frame", quantity=FRAME_DISTANCE)
    return readings.largest([number(rows, label=body) for body in bodies])


def energy_in_frame(table: pd.DataFrame) -> float:
    """Largest relative energy error over step ends in the Kepler frame."""
    return number(table, study="frame", quantity=FRAME_ENERGY)
