"""Common parts of the work-precision problems of planets: participants, settings, stored truth."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from benchmarks.work_precision.galvi_methods import gauss_collocation
from benchmarks.work_precision.problem import (
    EPS,
    Participant,
    Setting,
    Truth,
    WorkPrecisionProblem,
    adaptive,
    fixed,
    frame_label,
    galvi_label,
)
from galvi import KeplerFrame, Problem
from references.heyoka import taylor as heyoka_taylor
from references.rebound import ias15, saba, whfast
from references.scipy.ivp import DOP853
from references.stored.planets import STORED_TRUTH

# Steps per period, plus a third, for Wisdom-Holman maps: up to where rounding limits WHFast on the
# outer planets (10,000 years: 4.5e-9 with 120, 1.5e-9 with 240, 4.0e-9 with 480).
WISDOM = (10, 15, 20, 30, 60, 120, 240)
# Stages and passes: with None energies do not drift; two are the fewest that are accurate, where
# planets are a thousand times lighter than their star.
IN_FRAME = {
    (8, 2): (0.8, 1.1, 1.7, 3.2),
    (16, 2): (0.75, 0.85, 1.5, 1.9),
    (8, None): (1.4, 3.2, 4, 6, 8),
    (16, None): (0.75, 1.2, 1.5, 1.9, 2.5, 3, 4, 5),
}


def planets(
    problem: Problem, duration: float, period: float, few: bool, others: Sequence[Any]
) -> WorkPrecisionProblem:
    """galvi, REBOUND, heyoka and SciPy on planets; the truth is the stored one.

    duration  duration of the stored truth, in the problem's unit of time
    period    period of the fastest planet, likewise, to which numbers of steps refer
    few       fewer settings of the references, including their defaults and their best
    others    (label, contender, steps per period, options), for this problem only
    """

    def truth() -> Truth:
        kept = STORED_TRUTH.run(problem, duration, {"samples": 1})
        speed = np.max(np.abs(problem.system.velocity(kept.p[-1])))
        error = EPS * (float(np.max(np.abs(kept.q[-1]))) + duration * float(speed))
        text = f"{kept.method}; to the rounding of positions and times, {error:.0e} au"
        return Truth(kept.q[-1], error, text)

    def steps(*per_period: float, **options: Any) -> list[Setting]:
        # Never a whole number of steps a period: errors that resonate with it say little.
        counts = [round(duration * (k + 1.0 / 3.0) / period) for k in per_period]
        return [{**fixed(duration, count), **options} for count in counts]

    def once(**options: Any) -> Setting:
        return {"samples": 1, **options}

    best = [
        {**one, "kernel": kernel}
        for kernel, per_period in (("LAZY", WISDOM), ("DEFAULT", () if few else WISDOM[:5]))
        for one in steps(*per_period, **whfast.BEST)
    ]
    looser = [
        {**mode, "epsilon": epsilon}
        for mode, fine in ((ias15.DEFAULT, 1e-3), (ias15.GLOBAL, 1e-7))
        for epsilon in ((1e-5,) if few else (1e-5, fine))
    ]
    taylor = [heyoka_taylor.DEFAULT, heyoka_taylor.BEST]
    taylor += (
        [] if few else [{**heyoka_taylor.DEFAULT, "tolerance": one} for one in (1e-6, 1e-9, 1e-12)]
    )
    return WorkPrecisionProblem(
        problem,
        duration,
        (
            *(
                Participant(galvi_label(s), gauss_collocation(s), steps(*per_period))
                for s, per_period in {
                    8: (4, 6, 8, 10, 12),
                    12: (2, 3, 4, 5, 8),
                    16: (1.5, 2, 2.5, 3, 4),
                }.items()
            ),
            *(
                Participant(
                    frame_label(s, passes),
                    gauss_collocation(s, KeplerFrame(passes=passes)),
                    steps(*per_period),
                )
                for (s, passes), per_period in IN_FRAME.items()
            ),
            Participant("REBOUND IAS15", ias15.IAS15, [once(**ias15.DEFAULT)]),
            Participant("REBOUND IAS15, GLOBAL", ias15.IAS15, [once(**ias15.GLOBAL)]),
            Participant(
                "REBOUND IAS15, looser", ias15.IAS15, [once(**options) for options in looser]
            ),
            Participant("REBOUND WHFast, best", whfast.WHFAST, best),
            Participant("REBOUND WHFast, default", whfast.WHFAST, steps(30, 120, **whfast.DEFAULT)),
            Participant("REBOUND SABA(10,6,4)", saba.SABA, steps(3, 5, 7, 10, 20, **saba.BEST)),
            Participant("heyoka", heyoka_taylor.HEYOKA, [once(**options) for options in taylor]),
            Participant("SciPy DOP853", DOP853, adaptive("tolerance", (1e-8, 1e-10, 1e-12))),
            *(
                Participant(label, contender, steps(*k, **more))
                for label, contender, k, more in others
            ),
        ),
        truth,
    )
