"""Common parts of the work-precision problems of Lagrangians on R^d."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np

from benchmarks.work_precision.galvi_methods import gauss_collocation
from benchmarks.work_precision.problem import (
    COORDINATES,
    EPS,
    Participant,
    Setting,
    Truth,
    WorkPrecisionProblem,
    adaptive,
    fixed,
    galvi_label,
    largest_difference,
    stopped_early_too,
)
from galvi import Problem
from references import Contender
from references.heyoka.lagrangian import HEYOKA_LAGRANGIAN
from references.stored.lagrangian import STORED_LAGRANGIAN

TOLERANCES = (1e-5, 1e-7, 1e-9, 1e-11, 1e-13)  # of heyoka; at the last it is at round-off


def on_coordinates(
    problem: Problem,
    duration: float,
    quick: bool,
    ours: Mapping[int, Sequence[int]],
    peer: Contender,
    truth: Callable[[], Truth] | None = None,
    **timed: Any,
) -> WorkPrecisionProblem:
    """galvi, heyoka and a DOP853; two settings of each when quick.

    ours   degree: numbers of steps of galvi's, from coarse to fine
    peer   the DOP853
    truth  None for the stored one
    timed  `repeated_run` or `net_time`
    """

    def stored() -> Truth:
        kept = STORED_LAGRANGIAN.run(problem, duration, {"samples": 1})
        error = 0.5 * EPS * float(np.max(np.abs(kept.q[-1])))
        return Truth(kept.q[-1], error, f"{kept.method}; to the rounding of the coordinates")

    def chosen(values: Sequence[Any]) -> Sequence[Any]:
        return values[1:3] if quick else values

    def steps(counts: Sequence[int]) -> list[Setting]:
        found = [fixed(duration, count) for count in chosen(counts)]
        return found if quick else stopped_early_too(found)

    participants = [
        Participant(galvi_label(degree), gauss_collocation(degree), steps(counts))
        for degree, counts in ours.items()
    ]
    participants += [
        Participant(
            HEYOKA_LAGRANGIAN.name, HEYOKA_LAGRANGIAN, adaptive("tolerance", chosen(TOLERANCES))
        ),
        Participant(peer.name, peer, adaptive("tolerance", chosen((1e-6, 1e-9, 1e-12)))),
    ]
    return WorkPrecisionProblem(
        problem,
        duration,
        tuple(participants),
        truth or stored,
        quantity=COORDINATES,
        distance=largest_difference,
        **timed,
    )
