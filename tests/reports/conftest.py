"""Small claims, frames and suites, so that the report can be tested without its studies."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace

import numpy as np
import pandas as pd
import pytest

from benchmarks.claim import Claim, Row
from benchmarks.tidy import frame, row
from reports.figures.catalogue import FIGURES
from reports.figures.convergence import convergence_in_h, convergence_in_n
from reports.figures.departures import departures
from reports.figures.energies import energies
from reports.figures.figure import Figure
from reports.figures.history import history
from reports.figures.jumps import jumps
from reports.figures.limits import limits
from reports.figures.momentum_spheres import momentum_spheres
from reports.figures.paths import paths
from reports.figures.sphere import sphere
from reports.figures.traces import traces
from reports.suite import Suite, Table

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


def series(**where: object) -> list[dict[str, object]]:
    """Errors that fall geometrically with n."""
    return [row(n=n, value=0.5**n, **where) for n in range(4, 30)]


def claim(id: str = "V1", rows: tuple[Row, ...] = (ROW,), raises: Exception | None = None) -> Claim:
    """Its judge gives these rows; its study can raise."""

    def study(make_method: object, quick: bool, report: Callable[[str], None]) -> pd.DataFrame:
        report("half way")
        if raises is not None:
            raise raises
        return frame(series(study="n-refinement", quantity="one-step error"))

    return Claim(id, f"title of {id}", study, lambda table: [replace(r, id=id) for r in rows])


def work_precision(quick: bool, report: Callable[[str], None]) -> pd.DataFrame:
    """One problem: galvi wins at 1e-8, a peer at 1e-4; one run failed, one is the truth."""
    runs = [
        ("galvi degree 8, Gauss 8", "step=2", 1e-3, 0.010, ""),
        ("galvi degree 8, Gauss 8", "step=1", 1e-9, 0.020, ""),
        ("galvi degree 8, Gauss 8", "step=3", 1e-2, 0.030, ""),
        ("SciPy DOP853", "tolerance=1e-6", 1e-5, 0.002, ""),
        ("Leapfrog", "step=1", np.nan, np.nan, "The run failed: use smaller steps."),
        ("Taylor", "order=30", np.nan, 0.4, "truth"),
    ]
    return pd.DataFrame(
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
                "status": status,
                "reference": "Taylor",
            }
            for contender, settings, error, seconds, status in runs
        ]
    )


def cost(quick: bool, report: Callable[[str], None]) -> pd.DataFrame:
    """Two methods, the second of which failed."""
    one = {
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
    return pd.DataFrame([one, {**one, "seconds_per_step": np.nan, "status": "It failed."}])


def sky(quick: bool, report: Callable[[str], None]) -> pd.DataFrame:
    """Two bodies, one without a number."""
    return pd.DataFrame(
        {"body": ["Sun", "Mars"], "days": [1000, 1000], "away": [np.nan, 1.2345e-7], "note": ""}
    )


SKY = Table(
    "sky_and_model",
    "Model against sky",
    "Far below 1e-6 au.",
    sky,
    {"body": "body", "days": "days", "away": "distance [au]", "note": "note"},
)


def provenance(command: str) -> Mapping[str, str]:
    return {**PROVENANCE, "command": command}


@pytest.fixture(scope="session")
def make_suite() -> Callable[..., Suite]:
    """A suite of the given claims, by default one that holds."""

    def make(*claims: Claim, **others: object) -> Suite:
        parts = {"work_precision": work_precision, "cost": cost, "tables": (SKY,), **others}
        return Suite(claims or (claim(),), None, provenance=provenance, **parts)

    return make


def frame_for(figure: Figure) -> pd.DataFrame:
    """What a figure of the catalogue reads: plausible numbers, and failed runs among them."""
    if figure.draw in (convergence_in_n, convergence_in_h):
        rows = [one for rate in figure.options["rates"] for one in _errors(rate)]
    elif figure.draw is history:
        rows = _history(figure.options["quantity"])
    elif figure.draw is energies:
        rows = _energies(figure.options)
    elif figure.draw is paths:
        rows = _paths(figure.options)
    elif figure.draw is sphere:
        rows = _on_spheres(figure.options)
    elif figure.draw is momentum_spheres:
        rows = _momenta(figure.options)
    elif figure.draw is departures:
        rows = _departures(figure.options)
    elif figure.draw is jumps:
        rows = _jumps(figure.options)
    elif figure.draw is limits:
        rows = _limits(figure.options)
    elif figure.draw is traces:
        rows = _traces(figure.options)
    else:
        rows = _orbits(figure.options)
    return frame(rows)


def _errors(rate) -> list[dict[str, object]]:
    where = {"study": rate.study, "quantity": rate.quantity}
    if rate.n is None:
        base = rate.claimed or 0.4
        failed = [
            row(n=5, value=np.nan, status="It failed.", **where),
            row(n=6, value=1e9, **where),
        ]
        return failed + [row(n=n, value=base**n, **where) for n in range(7, 50, 2)]
    power = rate.claimed or rate.n
    return [
        row(n=rate.n, step=h, value=0.1 * h**power, **where) for h in 2.0 ** -np.arange(1.0, 9.0)
    ]


def _history(quantity: str) -> list[dict[str, object]]:
    return [
        row(study="history", quantity=quantity, t=2.0 * k, value=0.01 * np.sin(k))
        for k in range(100)
    ]


def _energies(options: Mapping[str, object]) -> list[dict[str, object]]:
    """One falls and ends early, the others go on."""
    return [
        row(study=study, quantity=options["quantity"], t=10.0 * t, value=(k - 1) * 1e-3 * t)
        for k, study in enumerate(options["labels"])
        for t in range(40 if k else 20)
    ]


def _paths(options: Mapping[str, object]) -> list[dict[str, object]]:
    return [
        row(study=study, quantity="position", label=body, t=t, x=k + np.cos(t), y=np.sin(t), z=0.0)
        for panel in options["panels"]
        for k, study in enumerate(panel.studies)
        for body in options["bodies"]
        for t in np.linspace(0.0, 6.0, 50)
    ]


def _on_spheres(options: Mapping[str, object]) -> list[dict[str, object]]:
    return [
        row(study=study, quantity=options[kind], t=t, x=np.sin(t), y=0.0, z=np.cos(t))
        for study in options["panels"]
        for kind, count in (("curve", 100), ("ends", 10))
        for t in np.linspace(0.0, 6.0, count)
    ]


def _momenta(options: Mapping[str, object]) -> list[dict[str, object]]:
    """Two starts of one energy, which the ellipsoid is of, and another one."""
    starts = {"0": (0.6, 0.8), "1": (0.6, -0.8), "2": (0.8, 0.6)}
    return [
        row(study=study, quantity="momentum", label=label, t=t, x=x, y=y * (-1) ** t, z=0.0)
        for study in sorted({panel.study for panel in options["panels"]})
        for label, (x, y) in starts.items()
        for t in range(20)
    ]


def _departures(options: Mapping[str, object]) -> list[dict[str, object]]:
    return [
        row(study=study, quantity=quantity, t=t, value=0.0 if k == 2 else 1e-9 * t)
        for quantity in options["quantities"]
        for k, study in enumerate(options["labels"])
        for t in range(30)
    ]


def _jumps(options: Mapping[str, object]) -> list[dict[str, object]]:
    """Runs of which the last ends early, and single steps of which some were not solved."""
    rows = [
        row(study=study, quantity=options["quantity"], t=t, value=1e-15 * (t + k),
            status="It failed." if k == len(options["runs"]) - 1 else "")
        for k, study in enumerate(options["runs"])
        for t in np.linspace(0.0, 30.0, 51)[: 51 - 10 * k]
    ]  # fmt: skip
    for study in options["steps"]:
        for t in np.linspace(0.0, 10.0, 21):
            change = np.nan if t > 8.0 else 10.0 ** (t - 16.0)
            rows += [
                row(study=study, quantity=options["turn"], t=t, value=0.3 * t),
                row(study=study, quantity=options["change"], t=t, value=change),
            ]
    return rows


def _traces(options: Mapping[str, object]) -> list[dict[str, object]]:
    rows = []
    for k, study in enumerate(options["labels"]):
        for steps in 2.0 ** np.arange(3.0, 9.0):
            where = {"study": study, "step": 1.0 / steps, "steps": steps}
            rows += [
                row(quantity=options["quantity"], value=steps ** -(k + 1.0), **where),
                row(quantity=options["against"], value=steps * (k + 1.0), **where),
            ]
    return rows


def _limits(options: Mapping[str, object]) -> list[dict[str, object]]:
    return [
        row(study=study, quantity=options["quantity"], step=turn,
            value=1e-15 if turn < limit else np.nan)
        for study, (limit, _) in options["charts"].items()
        for turn in np.linspace(0.1, 7.5, 40)
    ]  # fmt: skip


def _orbits(options: Mapping[str, object]) -> list[dict[str, object]]:
    return [
        row(quantity=options[kind], label=body, t=t, x=k * np.cos(t), y=k * np.sin(t), z=0.0)
        for kind, count in (("curve", 200), ("ends", 20))
        for k, body in enumerate((options["centre"], *options["bodies"]))
        for t in np.linspace(0.0, 6.0, count)
    ]


@pytest.fixture(scope="session")
def drawn_frames() -> dict[str, pd.DataFrame]:
    """A frame for each figure of the catalogue, by its name."""
    return {figure.name: frame_for(figure) for figure in FIGURES}


@pytest.fixture(scope="session")
def make_row() -> Callable[..., Row]:
    """A row of a claim that holds, with some of its fields replaced."""
    return lambda **fields: replace(ROW, **fields)


@pytest.fixture(scope="session")
def make_claim() -> Callable[..., Claim]:
    """See `claim`."""
    return claim
