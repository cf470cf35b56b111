"""The orders of galvi's four classes of methods, as `galvi.convergence` measures them.

python -m benchmarks.studies.orders                   the table, in Markdown
python -m benchmarks.studies.orders --write FILE      the table as CSV, such as docs/orders.csv
"""

from __future__ import annotations

import argparse
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

import galvi
from benchmarks.store.atomic import write
from galvi import Galerkin, Problem

OUTER_DURATION = 36_525.0  # of the outer planets: 100 years


def gauss(points: int, **options: Any) -> Galerkin:
    """Collocation at Gauss nodes."""
    return Galerkin(galvi.Polynomials(points), galvi.gauss(points), **options)


@dataclass(frozen=True, eq=False)
class Case:
    """A problem with methods of one class: label -> (method, numbers of steps)."""

    where: str
    problem: Problem
    duration: float
    methods: Mapping[str, tuple[Galerkin, Sequence[int]]]


def cases() -> tuple[Case, ...]:
    """The cases on vector spaces, on Lie groups, in moving frames and in clocks."""
    square = Galerkin(galvi.Polynomials(2), galvi.lobatto(3))
    six_points = Galerkin(galvi.Polynomials(3), galvi.gauss(6))
    frame, sundman, dynamical = galvi.KeplerFrame(), galvi.Sundman(), galvi.DynamicalTime()
    pair = galvi.Problem(
        galvi.NBody([0.6, 0.4]),
        np.array([[0.08, 0.0], [-0.12, 0.0]]),
        np.array([[0.0, 1.2], [0.0, -1.8]]),
        name="two bodies, e = 0.8",
    )
    return (
        Case("vector space", galvi.problems.kepler(0.3), 5.0, {
            "degree 1, Gauss 1": (gauss(1), (100, 200, 400, 800)),
            "degree 2, Gauss 2": (gauss(2), (40, 80, 160, 320)),
            "degree 3, Gauss 3": (gauss(3), (20, 30, 45, 68, 100)),
            "degree 4, Gauss 4": (gauss(4), (14, 20, 28, 40, 56)),
            "degree 2, Lobatto 3": (square, (40, 80, 160, 320)),
            "degree 3, Gauss 6": (six_points, (20, 30, 45, 68, 100)),
        }),
        Case("Lie group", galvi.problems.free_rigid_body(), 5.0, {
            "degree 1, Gauss 1, Cayley": (gauss(1), (50, 100, 200, 400)),
            "degree 2, Gauss 2, Cayley": (gauss(2), (80, 160, 320, 640)),
            "degree 3, Gauss 3, exponential":
                (gauss(3, chart=galvi.Exponential()), (30, 45, 68, 100)),
        }),
        Case("Lie group", galvi.problems.pendulum_3d(), 5.0, {
            "degree 2, Gauss 2, modified Rodrigues":
                (gauss(2, chart=galvi.ModifiedRodrigues()), (80, 160, 320, 640)),
        }),
        Case("moving frame", galvi.problems.outer_solar_system(), OUTER_DURATION, {
            "degree 1, Gauss 1, Kepler frame": (gauss(1, chart=frame), (60, 120, 240, 480)),
            "degree 2, Gauss 2, Kepler frame": (gauss(2, chart=frame), (60, 120, 240, 480)),
        }),
        Case("moving frame", galvi.problems.fermi_pasta_ulam_tsingou(), 20.0, {
            "degree 2, Gauss 2, harmonic frame":
                (gauss(2, chart=galvi.HarmonicFrame()), (40, 80, 160, 320)),
        }),
        Case("clock", galvi.problems.kepler(0.9), 5.0, {
            "degree 2, Gauss 2, Sundman's clock": (gauss(2, clock=sundman), (40, 80, 160, 320)),
            "degree 4, Gauss 4, Sundman's clock": (gauss(4, clock=sundman), (20, 28, 40, 56)),
        }),
        Case("clock", pair, 1.0, {
            "degree 2, Gauss 2, dynamical time": (gauss(2, clock=dynamical), (40, 80, 160, 320)),
        }),
    )  # fmt: skip


def rows() -> Iterator[dict[str, Any]]:
    """A row for each method: its theoretical order, the fit, and the largest defects in its
    window."""
    for case in cases():
        for name, (method, counts) in case.methods.items():
            table = galvi.convergence(
                case.problem, {name: method}, counts, case.duration, quick=True
            )
            used = table[table["fit"]]
            yield {
                "on, in": case.where,
                "method": name,
                "problem": case.problem.name,
                "order": method.order,
                "fitted": used["fitted"].mean(),
                "fitted_se": used["fitted_se"].mean(),
                "symmetry": used["symmetry"].max(),
                "symplecticity": used["symplecticity"].max(),
                "momentum": used["momentum"].max(),
            }


def as_text(table: pd.DataFrame) -> pd.DataFrame:
    """The table of a page, with the fit and its standard error in one column."""
    fits = [f"{row.fitted:.3f} ± {row.fitted_se:.3f}" for row in table.itertuples()]
    page_table = table.assign(fitted=fits).drop(columns="fitted_se")
    for name in ("symmetry", "symplecticity", "momentum"):
        page_table[name] = [f"{value:.0e}" if value == value else "-" for value in table[name]]
    return page_table.rename(columns={"order": "order of theory", "fitted": "order measured"})


def main() -> None:
    """Print the table, or write it."""
    parser = argparse.ArgumentParser(prog="python -m benchmarks.studies.orders")
    parser.add_argument(
        "--write", type=Path, metavar="FILE", help="as CSV, such as docs/orders.csv"
    )
    file: Path | None = parser.parse_args().write
    table = as_text(pd.DataFrame(rows()))
    if file is None:
        print(table.to_markdown(index=False, disable_numparse=True))
    else:
        write(file, table.to_csv(index=False))


if __name__ == "__main__":
    main()
