"""The states of a run at the quadrature points of its steps."""

from __future__ import annotations

import numpy as np

from galvi.arrays import Array
from galvi.curves.frame_curves import FrameCurves
from galvi.trajectory import Trajectory


def stage_states(run: Trajectory) -> tuple[Array, Array, Array, Array]:
    """Times (steps, s), q (steps, s, ...), velocities (steps, s, ...) and h times the weights (s,).

    Raises ValueError for a run without curves, such as one by a reference, or in a moving frame.
    """
    curves, step = run.curves, run.step
    if isinstance(curves, FrameCurves):
        raise ValueError(
            "this needs curves between stages of one rule in time; a run in a moving frame has "
            "others. Integrate with another chart."
        )
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
    bases = np.repeat(curves.bases[:, None], table.c.size, axis=1)
    return t, curves.chart.place(bases, xi), curves.chart.velocity(lambda: xi, rate), step * table.b
