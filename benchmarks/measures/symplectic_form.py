"""Symplecticity of a step: its derivative, and the form on vector spaces and groups."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

import galvi
from benchmarks.measures.matrix_group import MatrixGroup
from galvi import Problem
from galvi.arrays import Array
from galvi.groups.group import Group

NUDGE = 2.0**-8  # change of a start, relative or of length 1, by which a step is differenced


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
    """Largest entry of DF^T J DF - J over |DF|^2, J = [[0, 1], [-1, 0]]; NaN where DF is."""
    if np.any(np.isnan(DF)):
        return float("nan")
    d = len(DF) // 2
    J = np.block([[np.zeros((d, d)), np.eye(d)], [-np.eye(d), np.zeros((d, d))]])
    return float(np.max(np.abs(DF.T @ J @ DF - J)) / max(1.0, np.linalg.norm(DF, 2) ** 2))


StepMap = Callable[[Array, Array], tuple[Array, Array]]
GROUP_NUDGE = 2.0**-6
WEIGHTS = (4.0 / 5.0, -1.0 / 5.0, 4.0 / 105.0, -1.0 / 280.0)  # central, of order eight


def form_defect(step: StepMap, group: Group, g: Array, mu: Array) -> float:
    """Largest entry of DF^T W(mu1) DF - W(mu) over |DF|^2 at (g, mu), accurate to about 1e-12.

    step  (g, mu) -> (g1, mu1)
    W(mu) is the matrix of <d mu2, eta1> - <d mu1, eta2> + <mu, [eta1, eta2]> (H 3.1.1, claim L16),
    with eta = g^-1 dg, differenced in the entries of the matrices.
    """
    matrices, d = MatrixGroup(group), group.dimension
    size = float(np.max(np.abs(mu))) or 1.0
    g1, mu1 = step(g, mu)
    inverse = np.linalg.inv(matrices.matrix(g1))
    at_zero = matrices.matrix(np.zeros(group.shape))
    DF = np.zeros((2 * d, 2 * d))
    for column in range(2 * d):
        eta, shift = np.zeros(d), np.zeros(d)
        if column < d:
            eta[column] = GROUP_NUDGE
        else:
            shift[column - d] = GROUP_NUDGE * size
        length = GROUP_NUDGE if column < d else GROUP_NUDGE * size
        slope_g, slope_mu = np.zeros_like(inverse), np.zeros(d)
        for k, weight in enumerate(WEIGHTS, start=1):
            ends = [step(matrices.moved(g, s * k * eta), mu + s * k * shift) for s in (1.0, -1.0)]
            slope_g += weight * (matrices.matrix(ends[0][0] - ends[1][0]) - at_zero) / length
            slope_mu += weight * (ends[0][1] - ends[1][1]) / length
        DF[:, column] = np.concatenate([matrices.vee(inverse @ slope_g), slope_mu])
    scale = max(1.0, float(np.linalg.norm(DF, 2)) ** 2)
    return float(np.max(np.abs(DF.T @ _form(matrices, mu1) @ DF - _form(matrices, mu)))) / scale


def _form(matrices: MatrixGroup, mu: Array) -> Array:
    e, d = matrices.basis, mu.size
    bracket_form = np.array([[mu @ matrices.vee(v @ w - w @ v) for w in e] for v in e])
    return np.block([[bracket_form, np.eye(d)], [-np.eye(d), np.zeros((d, d))]])
