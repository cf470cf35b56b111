"""Small claims, tables and sections, so that the report can be tested without its studies."""

from __future__ import annotations

from dataclasses import replace
from functools import partial

import numpy as np
import pandas as pd

from benchmarks.checks.claim import Claim, Row
from benchmarks.store.tables import row, table_of
from benchmarks.work_precision.dependable import dependable
from reports.results.section import Section
from reports.results.suite import Suite
from reports.tables.study_table import readable_table

ROW = Row(
    id="V1",
    quantity="base of the error",
    source="H fig. 2.3",
    setup="oscillator; n = 3",
    claimed="O(0.5^n)",
    bound="at most 0.5",
    measured=0.25,
    uncertainty=0.01,
    expected="holds",
    reason="so says | the theory",
    reference="closed form",
    verdict="holds",
)
PROVENANCE = {"date": "2026-01-02 03:04 UTC", "commit": "0123456789abcdef+dirty", "numpy": "2.4"}


def series(**where):
    """Errors that fall geometrically with n."""
    return [row(n=n, value=0.5**n, **where) for n in range(4, 30)]


def claim(id="V1", rows=(ROW,), raises=None):
    """A claim whose judge returns `rows`, and whose study raises `raises` if that is given."""

    def study(make_method, quick, report):
        report("half way")
        if raises is not None:
            raise raises
        return table_of(series(study="n-refinement", quantity="one-step error"))

    return Claim(id, f"title of {id}", study, lambda table: [replace(r, id=id) for r in rows])


def work_precision(quick, report):
    """One problem: galvi wins at 1e-8, a peer at 1e-4; one run failed, one is the truth."""
    runs = [
        ("galvi degree 8, Gauss 8", "step=2", 1e-3, 0.010, ""),
        ("galvi degree 8, Gauss 8", "step=1", 1e-9, 0.020, ""),
        ("galvi degree 8, Gauss 8", "step=3", 1e-2, 0.030, ""),
        ("SciPy DOP853", "tolerance=1e-6", 1e-5, 0.002, ""),
        ("Leapfrog", "step=1", np.nan, np.nan, "The run failed: use smaller steps."),
        ("Taylor", "order=30", np.nan, 0.4, ""),
    ]
    table = pd.DataFrame(
        [
            {
                "problem": "kepler e=0.6",
                "contender": contender,
                "settings": settings,
                "quantity": "position",
                "error": error,
                "seconds": seconds,
                "seconds_low": 0.9 * seconds,
                "seconds_high": 1.2 * seconds,
                "evaluations": np.nan,
                "steps": 10.0,
                "is_truth": contender == "Taylor",
                "stops_early": False,
                "status": status,
                "reference": "Taylor",
            }
            for contender, settings, error, seconds, status in runs
        ]
    )
    return dependable(table)


def cost(quick, report):
    """Two methods, the second of which failed."""
    solved = {
        "problem": "kepler e=0.6",
        "method": "Gauss collocation, 2 stages",
        "order": 4,
        "step": 0.1,
        "solver": "fixed point",
        "iterations_per_step": 3.5,
        "forces_per_step": 7.0,
        "seconds_per_step": 2e-6,
        "status": "",
    }
    return pd.DataFrame([solved, {**solved, "seconds_per_step": np.nan, "status": "It failed."}])


def sky(quick, report):
    """Two bodies, one without a number."""
    return pd.DataFrame(
        {"body": ["Sun", "Mars"], "days": [1000, 1000], "away": [np.nan, 1.2345e-7], "note": ""}
    )


SKY = Section(
    name="sky_and_model",
    title="Model against sky",
    text="Far below 1e-6 au.",
    measure=sky,
    table=partial(
        readable_table,
        headings={"body": "body", "days": "days", "away": "distance [au]", "note": "note"},
    ),
    compared=True,
)


def provenance(command):
    return {**PROVENANCE, "command": command}


def suite_of(*claims: Claim, **overrides):
    """A suite of the given claims, by default one that holds."""
    parts = {"work_precision": work_precision, "cost": cost, "sections": (SKY,), **overrides}
    return Suite(claims or (claim(),), provenance=provenance, **parts)
