"""A run as a result of SciPy's solvers."""

from __future__ import annotations

from typing import Any

import numpy as np

from galvi.arrays import Array
from galvi.trajectory import Trajectory


def to_scipy(run: Trajectory) -> Any:
    """A `scipy.optimize.OptimizeResult` with the fields of `scipy.integrate.solve_ivp`'s result.

    t        (saved,)
    y        (n, saved): the entries of q, one after the other, then those of v
    sol      t -> y on the curves, (n,) or (n, k); None for a run of a reference
    status   0 for a success, else -1; with `message` and `success`
    nfev     force evaluations; njev those of its derivative; nlu linear systems solved
    """

    from scipy.optimize import OptimizeResult  # a fifth of galvi's import

    def rows(q: Array, v: Array, times: int) -> Array:
        parts = [np.reshape(x, (times, -1)) for x in (q, v)]
        return np.concatenate(parts, axis=1).T

    def sol(t: Any) -> Array:
        times = np.atleast_1d(np.asarray(t, dtype=np.float64))
        y = rows(run(times), run.velocity(times), times.size)
        return y if np.ndim(t) else y[:, 0]

    counts = run.counts
    return OptimizeResult(
        t=run.t,
        y=rows(run.q, run.v, len(run.t)),
        sol=None if run.curves is None and run.again is None else sol,
        t_events=None,
        y_events=None,
        nfev=counts.get("force_evaluations", 0),
        njev=counts.get("hessian_evaluations", 0),
        nlu=counts.get("linear_solves", 0),
        status=0 if run.success else -1,
        message=run.status,
        success=run.success,
    )
