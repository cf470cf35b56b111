"""Symplecticity defect of a map of states on a group, by finite differences of its results."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from benchmarks.measures.matrix_group import MatrixGroup
from galvi.arrays import Array
from galvi.groups.group import Group

StepMap = Callable[[Array, Array], tuple[Array, Array]]
NUDGE = 2.0**-6
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
            eta[column] = NUDGE
        else:
            shift[column - d] = NUDGE * size
        length = NUDGE if column < d else NUDGE * size
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
    turning = np.array([[mu @ matrices.vee(v @ w - w @ v) for w in e] for v in e])
    return np.block([[turning, np.eye(d)], [-np.eye(d), np.zeros((d, d))]])
