"""Energy errors of short runs from many states of an exact motion.

A symplectic method with a constant step conserves a modified energy. The energy error of a run is
therefore D(x) - D(x0), where D is the difference of both energies, and is at any time at most max D
- min D over the motion. Short runs from many states measure that range without a long run.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from typing import Any

import numpy as np

import galvi
from benchmarks.claims.kit import Problem, failure, row
from benchmarks.measures.errors import energy_errors
from references import Contender

SHORT = "short runs"
STARTS, STEPS = 64, 22


def short_runs(
    quantity: str, problem: Problem, truth: Contender, duration: float, method: Any, step: float
) -> Iterator[dict[str, Any]]:
    """Rows of the largest relative energy error of STEPS steps, for each of STARTS starts, evenly
    spaced in time along the truth's motion; NaN for a failed run."""
    motion = truth.run(problem, duration, {"samples": STARTS})
    for t, q, v in zip(motion.t[1:], motion.q[1:], motion.v[1:], strict=True):
        run = galvi.integrate(replace(problem, q0=q, v0=v), method, step, STEPS)
        yield row(
            study=SHORT,
            quantity=quantity,
            value=float(np.max(np.abs(energy_errors(run)))),
            step=step,
            steps=STEPS,
            t=t,
            status=failure(run),
        )
