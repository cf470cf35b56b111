"""Steps in vectors of four and of eight numbers: `python -m benchmarks.experiments.vector_lengths`.

Which of them a run uses, `galvi.fast.lanes.vectors.lanes_for` decides. Here each run is timed
with both, in turn, and the fastest of `ROUNDS` counts. Eight stages run in eights on any processor:
their ratio shows how quiet the machine was.
"""

from __future__ import annotations

import time
from unittest import mock

import pandas as pd

import galvi
from galvi.fast.lanes import vectors

STAGES, ROUNDS, STEPS = (2, 4, 8, 9, 12), 12, 1000
PROBLEMS = {  # and a step that all of them solve, for each stage
    galvi.problems.henon_heiles(): 0.05,
    galvi.problems.double_pendulum(): 0.004,
    galvi.problems.planar_chain(5): 0.001,
    galvi.problems.free_rigid_body(): 0.03,
    galvi.problems.pendulum_3d(): 0.02,
    galvi.problems.free_body_se3(): 0.02,
}


def seconds(problem: galvi.Problem, stages: int, per_stage: float, eight: bool) -> float:
    """The time of a run as on a processor with AVX-512 (``eight``), or as on one without."""
    method = galvi.Galerkin(galvi.Polynomials(stages), galvi.gauss(stages))
    with mock.patch.object(vectors, "AVX512", eight):
        galvi.integrate(problem, method, stages * per_stage, 2)
        clock = time.perf_counter()
        run = galvi.integrate(problem, method, stages * per_stage, STEPS, save_every=STEPS)
        taken = time.perf_counter() - clock
    assert run.success and run.counts["linear_solves"] == 0, run.status
    return taken


def ratios() -> pd.DataFrame:
    """One row for each problem: the time with eight over that with four, by number of stages."""
    rows = []
    for problem, per_stage in PROBLEMS.items():
        row: dict[str, object] = {"problem": problem.name}
        for stages in STAGES:
            times = [
                [seconds(problem, stages, per_stage, eight) for eight in (True, False)]
                for _ in range(ROUNDS)
            ]
            eight, four = (min(column) for column in zip(*times, strict=True))
            row[f"{stages} stages"] = round(eight / four, 2)
        rows.append(row)
    return pd.DataFrame(rows)


if __name__ == "__main__":
    print(ratios().to_string(index=False))
