"""The time of a step of a grain, in the cloud and in a single run."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

import galvi
from benchmarks.applications.brownout.cloud import (
    CONSTANT_DRAG,
    DIAMETERS,
    DRAG_COEFFICIENTS,
    END_TIME,
    REYNOLDS_DRAG,
    Cloud,
)
from benchmarks.applications.brownout.statistics import particle_shares, total
from benchmarks.statistics.timing import interleaved, once
from benchmarks.store.provenance import today, version
from benchmarks.store.row_files import RowFiles, stored_rows
from benchmarks.work_precision.galvi_methods import gauss_collocation
from galvi.run.ensemble import processors

COLUMNS: Mapping[str, type] = {
    "drag": str, "micrometres": float, "runs": str, "degree": int, "grains": int, "threads": int,
    "steps": int, "passes": float, "microseconds": float, "single": float, "optical_depth": float,
    "uncertainty": float, "status": str, "commit": str, "date": str,
}  # fmt: skip
STEPS = 200
ROUNDS = 3
GRAINS, QUICK_GRAINS = 6000, 1000
MILLION, FOLDER = 1_000_000, "brownout-cloud"
CLOUD = "cloud"
SINGLE_DIAMETERS = (100e-6, 400e-6)  # m, diameters of single runs
OTHER_DEGREES = (1, 4)  # degrees beside 2, at 100 micrometres
EXPLANATION = (
    "Grains of sand in the wind of a landing rotor, from where the wind lifts them to the end or "
    "to the ground: eight to an instruction, each in a lane, step and iteration of its own, and "
    f"the next one where one has landed. {STEPS} steps of {END_TIME / STEPS:g} s, fewer for grains "
    "that are lifted later; iterated to rounding. A pass evaluates wind and drag at every stage. "
    "Beside them a step of a single run of the same method, by galvi.integrate. What a cloud's "
    "optical depth gains from a high degree is in claim V25."
)


def cost_of_clouds(
    quick: bool = False, report: Callable[[str], None] = lambda sentence: None
) -> pd.DataFrame:
    """One row for each drag law, size and degree, in one thread.

    passes        passes of the iteration for each step
    microseconds  microseconds for each step
    single        ratio of the time of a step of a single run to this; NaN where there is none
    """
    n = QUICK_GRAINS if quick else GRAINS
    cases = [(drag, d, 2) for drag in (CONSTANT_DRAG, REYNOLDS_DRAG) for d in DIAMETERS]
    cases += [(REYNOLDS_DRAG, 100e-6, s) for s in OTHER_DEGREES]
    calls: list[Callable[[], Any]] = []
    runs, singles = [], []
    for drag, diameter, degree in cases:
        report(f"{drag}, {diameter * 1e6:g} micrometres, degree {degree}")
        cloud = Cloud(diameter, drag, np.arange(n))
        fly = partial(cloud.flights, _gauss(degree), STEPS, threads=1)
        runs.append(fly())
        calls += [fly, cloud.starts]
        singles.append(
            None if diameter not in SINGLE_DIAMETERS or degree != 2 else _single(drag, diameter)
        )
        calls += [singles[-1]] if singles[-1] else []
    times = iter([timing.seconds for timing in interleaved(calls, ROUNDS, 0.02)])
    rows = []
    for (drag, diameter, degree), run, single in zip(cases, runs, singles, strict=True):
        steps = int(run.steps.sum())
        seconds = (next(times) - next(times)) / steps
        single_seconds = next(times) / STEPS if single else math.nan
        rows.append(
            {
                **_row(drag, diameter, degree, run),
                "runs": CLOUD,
                "threads": 1,
                "microseconds": 1e6 * seconds,
                "single": single_seconds / seconds,
            }
        )
    return pd.DataFrame(rows, columns=list(COLUMNS))


def _gauss(degree: int) -> galvi.Galerkin:
    return gauss_collocation(degree).method


def _single(drag: str, diameter: float) -> Callable[[], Any]:
    """A call of a single run of STEPS steps that does not reach the ground."""
    problem = galvi.problems.brownout(diameter, drag_coefficient=DRAG_COEFFICIENTS[drag])
    problem = problem.with_initial_state([12.0, 0.0, 3.0], [0.0, 0.0, 1.0])
    return partial(galvi.integrate, problem, _gauss(2), END_TIME / STEPS, STEPS, save_every=STEPS)


def _row(drag: str, diameter: float, degree: int, run: Any) -> dict[str, Any]:
    failed = int(np.sum(~run.success))
    return {
        "drag": drag,
        "micrometres": 1e6 * diameter,
        "degree": degree,
        "grains": len(run.t),
        "steps": int(run.steps.sum()),
        "passes": float(run.passes.sum() / run.steps.sum()),
        "status": f"{failed} grains failed" if failed else "",
    }


@dataclass(frozen=True)
class SizeRun:
    """The run of one size of grains in a cloud of MILLION grains, equally many of each size."""

    diameter: float
    files: RowFiles
    code: str

    @property
    def name(self) -> str:
        """The name of its file."""
        return f"{self.diameter * 1e6:g}-micrometres_{MILLION // len(DIAMETERS)}-grains_{self.code}"

    @property
    def title(self) -> str:
        """The title for progress output."""
        return f"{MILLION // len(DIAMETERS)} grains of {self.diameter * 1e6:g} micrometres"

    def is_complete(self) -> bool:
        """Whether its row exists."""
        return self.files.read(self.name) is not None

    def run(self, report: Callable[[str], None]) -> None:
        """Compute and write its row; the time includes the starts, in all threads."""
        report(self.title)
        cloud = Cloud(self.diameter, grains=np.arange(MILLION // len(DIAMETERS)))
        replace(cloud, grains=np.arange(8)).flights(_gauss(2), STEPS)
        run, seconds = once(lambda: cloud.flights(_gauss(2), STEPS))
        depth = total(particle_shares({self.diameter: cloud}, _gauss(2), STEPS).depth)
        row = {
            **_row(REYNOLDS_DRAG, self.diameter, 2, run),
            "runs": CLOUD,
            "threads": processors(),
            "microseconds": 1e6 * seconds / int(run.steps.sum()),
            "single": math.nan,
            "optical_depth": depth.value,
            "uncertainty": depth.uncertainty,
            "commit": self.code,
            "date": today(),
        }
        self.files.write(self.name, pd.DataFrame([row], columns=list(COLUMNS)))


def parts(studies: Path, report: Callable[[str], None]) -> list[SizeRun]:
    """The runs of the long form."""
    files, code = RowFiles(studies / FOLDER, COLUMNS, report), version()
    return [SizeRun(diameter, files, code) for diameter in DIAMETERS]


stored = stored_rows(FOLDER, COLUMNS)
