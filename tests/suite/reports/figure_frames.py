"""Rows for each figure of the catalogue: plausible numbers, and failed runs among them."""

from __future__ import annotations

import matplotlib.style
import numpy as np

from benchmarks.applications.brownout.step_errors import GRAINS, SAMPLING, STEP_ERROR, WORK
from benchmarks.store.tables import row, table_of
from reports.figures.picture import STYLE, draw_canvas
from reports.figures.plots.convergence import convergence
from reports.figures.plots.lines import (
    departures,
    energies,
    history,
    jumps,
    limits,
    lines,
    sampling,
)
from reports.figures.plots.paths import clouds, moving_cloud, paths
from reports.figures.plots.spheres import momentum_spheres, pendulum_spheres


def lay_out(figure, table):
    """Draw a figure without writing files, which would take most of the time; raises NoData."""
    with matplotlib.style.context(STYLE):
        draw_canvas(figure, table)


def table_for(figure):
    """A table with the rows that the figure's plot reads."""
    return table_of(ROWS[figure.draw](figure.options))


def _clouds(options):
    return [
        row(study=options["study"], label=label, t=t, x=k + t, y=0.0, z=0.5 * t)
        for k, label in enumerate(options["labels"])
        for t in options.get("times", (0.0, 1.0, 2.0))
    ]


def _statistics(options):
    """Errors of the step that fall with its degree's order, one of them unknown."""
    quantity = options["quantity"]
    rows = [
        row(study=quantity, quantity=name, value=value)
        for name, value in ((SAMPLING, 1e-3), (GRAINS, 2e4))
    ]
    for degree in options["degrees"]:
        for steps in (48, 96, 192):
            error = np.nan if (degree, steps) == (1, 48) else (10.0 / steps) ** (2 * degree)
            where = {"n": degree + 1, "steps": steps}
            rows += [
                row(study=quantity, quantity=STEP_ERROR, value=error, **where),
                row(study=quantity, quantity=f"{SAMPLING} of it", value=1e-5, **where),
                row(study=WORK, quantity=WORK, value=5.0 * degree * steps, **where),
            ]
    return rows


def _convergence(options):
    return [row for rate in options["rates"] for row in _errors(rate)]


def _errors(rate):
    where = {"study": rate.study, "quantity": rate.quantity}
    if rate.algebraic:
        return [row(n=n, value=0.5 / n, **where) for n in range(8, 90, 9)]
    if rate.n is None:
        base = rate.claimed or 0.4
        failed = [
            row(n=5, value=np.nan, status="It failed.", **where),
            row(n=6, value=1e9, **where),
        ]
        return failed + [row(n=n, value=base**n, **where) for n in range(7, 50, 2)]
    power = rate.claimed or rate.n
    sizes = min(1.0, rate.until) * 2.0 ** -np.arange(1.0, 9.0)
    errors = 0.1 * 2.0 ** (-power * np.arange(1.0, 9.0))
    return [
        row(n=rate.n, step=h, value=error, **where) for h, error in zip(sizes, errors, strict=True)
    ]


def _history(options):
    size = 1e-14 if options.get("rounding") else 0.01
    return [
        row(study="history", quantity=options["quantity"], t=2.0 * k, value=size * np.sin(k))
        for k in range(100)
    ]


def _energies(options):
    """The first energy falls, and its run ends early; those of the others do not fall."""
    return [
        row(
            study=study,
            quantity=options["quantity"],
            t=10.0 * t,
            value=(k - 1) * 1e-3 * t,
            status="" if k else "It failed.",
        )
        for k, study in enumerate(options["labels"])
        for t in range(40 if k else 20)
    ]


def _paths(options):
    return [
        row(
            study=panel.study,
            quantity=quantity,
            label=body,
            t=t,
            x=k * np.cos(t),
            y=k * np.sin(t),
            z=0.0,
        )
        for panel in options["panels"]
        for quantity, count in ((panel.quantity, 200), (panel.ends, 20))
        for k, body in enumerate(options["bodies"], start=1)
        for t in np.linspace(0.0, 6.0, count)
    ]


def _on_spheres(options):
    return [
        row(study=study, quantity=options[kind], t=t, x=np.sin(t), y=0.0, z=np.cos(t))
        for study in options["panels"]
        for kind, count in (("curve", 100), ("ends", 10))
        for t in np.linspace(0.0, 6.0, count)
    ]


def _momenta(options):
    """Two starts with the energy of the ellipsoid, and one with another energy."""
    starts = {"0": (0.6, 0.8), "1": (0.6, -0.8), "2": (0.8, 0.6)}
    return [
        row(study=study, quantity="momentum", label=label, t=t, x=x, y=y * (-1) ** t, z=0.0)
        for study in sorted({panel.study for panel in options["panels"]})
        for label, (x, y) in starts.items()
        for t in range(20)
    ]


def _departures(options):
    return [
        row(study=study, quantity=quantity, t=t, value=0.0 if k == 2 else 1e-9 * t)
        for quantity in options["quantities"]
        for k, study in enumerate(options["labels"])
        for t in range(30)
    ]


def _jumps(options):
    """Runs, of which the later ones end earlier, and single steps, some of them not solved."""
    rows = [
        row(
            study=study,
            quantity=options["quantity"],
            t=t,
            value=1e-15 * (t + k),
            status="It failed." if k == len(options["runs"]) - 1 else "",
        )
        for k, study in enumerate(options["runs"])
        for t in np.linspace(0.0, 30.0, 51)[: 51 - 10 * k]
    ]
    for study in options["steps"]:
        for t in np.linspace(0.0, 10.0, 21):
            change = np.nan if t > 8.0 else 10.0 ** (t - 16.0)
            rows += [
                row(study=study, quantity=options["turn"], t=t, value=0.3 * t),
                row(study=study, quantity=options["change"], t=t, value=change),
            ]
    return rows


def _lines(options):
    rows = []
    for k, study in enumerate(options["labels"]):
        for steps in 2.0 ** np.arange(3.0, 9.0):
            where = {"study": study, "step": 1.0 / steps, "steps": steps}
            rows += [
                row(quantity=options["quantity"], value=steps ** -(k + 1.0), **where),
                row(quantity=options["against"], value=steps * (k + 1.0), **where),
            ]
    return rows


def _limits(options):
    return [
        row(
            study=study,
            quantity=options["quantity"],
            step=angle,
            value=1e-15 if angle < limit else np.nan,
        )
        for study, (limit, _) in options["charts"].items()
        for angle in np.linspace(0.1, 7.5, 40)
    ]


ROWS = {
    convergence: _convergence,
    history: _history,
    energies: _energies,
    lines: _lines,
    departures: _departures,
    jumps: _jumps,
    limits: _limits,
    sampling: _statistics,
    paths: _paths,
    clouds: _clouds,
    moving_cloud: _clouds,
    momentum_spheres: _momenta,
    pendulum_spheres: _on_spheres,
}
