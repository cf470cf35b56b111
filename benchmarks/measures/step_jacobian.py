"""The derivative of one step as a map of states, by finite differences of its results."""

from __future__ import annotations

from typing import Any

import numpy as np

import galvi
from benchmarks.measures.symplectic_form import WEIGHTS
from galvi import Problem
from galvi.arrays import Array

NUDGE = 2.0**-8


def map_derivative(problem: Problem, method: Any, step: float) -> Array:
    """D(q1, v1)/D(q0, v0), (2 d, 2 d), by central differences of order eight.

    For vector spaces with unit masses. All NaN when a step fails.
    """
    d = problem.q0.size
    derivative = np.zeros((2 * d, 2 * d))
    for column, unit in enumerate(NUDGE * np.eye(2 * d)):
        for k, weight in enumerate(WEIGHTS, start=1):
            for sign in (1.0, -1.0):
                q, v = (sign * k * unit).reshape(2, *problem.q0.shape)
                start = Problem(problem.system, problem.q0 + q, problem.v0 + v, problem.t0)
                run = galvi.integrate(start, method, step, 1)
                end = np.concatenate([run.q[-1].ravel(), run.p[-1].ravel()])
                derivative[:, column] += sign * weight * end / NUDGE
    return derivative


def canonical_defect(DF: Array) -> float:
    """Largest entry of DF^T J DF - J over |DF|^2, J = [[0, 1], [-1, 0]]."""
    d = len(DF) // 2
    J = np.block([[np.zeros((d, d)), np.eye(d)], [-np.eye(d), np.zeros((d, d))]])
    return float(np.max(np.abs(DF.T @ J @ DF - J)) / max(1.0, np.linalg.norm(DF, 2) ** 2))
