"""The states of a run at the quadrature points of its steps."""

from __future__ import annotations

import numpy as np

from galvi.arrays import Array
from galvi.charts.maps import place, tangent
from galvi.curves.group_curves import GroupCurves
from galvi.trajectory import Trajectory


def stage_states(run: Trajectory) -> tuple[Array, Array, Array, Array]:
    """Times (steps, s), q (steps, s, ...), velocities (steps, s, ...) and h times the weights (s,).

    Raises ValueError for a run without curves, such as one by a reference.
    """
    curves, step = run.curves, run.step
    if curves is None or step is None:
        raise ValueError(
            "this needs the Galerkin curves of a run; integrate with curves=True or save_every=1 "
            "(references keep none)."
        )
    table = run.method.table
    coefficients = curves.coefficients
    xi = np.einsum("kdi,si->ksd", coefficients, table.psi)
    rate = np.einsum("kdi,si->ksd", coefficients, table.slope) / step
    t = curves.t0 + (np.arange(len(xi))[:, None] + table.c) * step
    if isinstance(curves, GroupCurves):
        bases = np.repeat(curves.bases[:, None], table.c.size, axis=1)
        q = place(curves.chart, curves.group, bases, xi)
        v = np.einsum("ksab,ksb->ksa", tangent(curves.chart, curves.group, xi), rate)
        return t, q, v, step * table.b
    shape = (*xi.shape[:2], *curves.shape)
    q = (curves.bases[:, None] + xi).reshape(shape)
    return t, q, rate.reshape(shape), step * table.b
