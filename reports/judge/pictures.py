"""The pictures of a judgement: the motion, and the errors over time."""

from __future__ import annotations

import io

import matplotlib
import matplotlib.style
import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure as Canvas

from benchmarks.applications.judging import trees
from benchmarks.applications.judging.bodies import names
from benchmarks.applications.judging.judgement import Judgement
from galvi import Multibody
from reports.figures.picture import STYLE
from reports.figures.style.identities import COLOURS, GUIDE
from reports.tables.number_format import readable

NAMED = 7  # bodies in colour
POINTS = 1500


def pictures(found: Judgement) -> bytes:
    """An SVG: orbits in the plane of x and y, or joints, on the left, errors on the right."""
    matplotlib.use("Agg")
    with matplotlib.style.context(STYLE):
        canvas = Canvas(figsize=(9.6, 4.2))  # a layout of matplotlib's takes half a second
        FigureCanvasAgg(canvas)
        motion, errors = canvas.subplots(1, 2)
        canvas.subplots_adjust(left=0.08, right=0.98, bottom=0.13, top=0.92, wspace=0.25)
        _motion(motion, found)
        _errors(errors, found)
        svg = io.BytesIO()
        nothing = dict.fromkeys(("Creator", "Date", "Format", "Type"))
        canvas.savefig(svg, format="svg", metadata=nothing)
    return svg.getvalue()


def _motion(axes, found: Judgement) -> None:  # type: ignore[no-untyped-def]
    if isinstance(found.problem.system, Multibody):
        _joints(axes, found)
    else:
        _orbits(axes, found)


def _joints(axes, found: Judgement) -> None:  # type: ignore[no-untyped-def]
    system, truth = found.problem.system, found.truth
    qpos, _ = system.to_mujoco(truth.q, np.zeros((len(truth.t), found.problem.v0.size)))  # type: ignore[attr-defined]
    for k, name in enumerate(trees.entries(found.problem)):
        axes.plot(truth.t, qpos[:, k], linewidth=0.9, label=name if k < NAMED else None)
    axes.set(
        xlabel=f"t{_in(found, 'time')}",
        ylabel="entries of qpos (rad, m, quaternions)",
        title="the motion",
    )
    axes.legend(fontsize=7, ncols=2)


def _orbits(axes, found: Judgement) -> None:  # type: ignore[no-untyped-def]
    q, labels = found.truth.q, names(found.problem)
    rows = slice(0, None, max(1, len(q) // POINTS))
    heavy = np.argsort(-found.problem.system.masses, kind="stable")[:NAMED]  # type: ignore[attr-defined]
    for k in range(q.shape[1]):
        if k not in heavy:
            axes.plot(*q[-1, k, :2], ".", color=GUIDE, markersize=2, zorder=0)
    for place, k in enumerate(heavy):
        color = COLOURS[place % len(COLOURS)]
        axes.plot(q[rows, k, 0], q[rows, k, 1], color=color, linewidth=0.5, alpha=0.7)
        axes.plot(*q[-1, k, :2], "o", color=color, markersize=4, label=labels[k])
    length = _in(found, "length")
    axes.set(xlabel=f"x{length}", ylabel=f"y{length}", title="the motion")
    axes.set_aspect("equal", adjustable="datalim")
    axes.legend(fontsize=7)


def _errors(axes, found: Judgement) -> None:  # type: ignore[no-untyped-def]
    shown = found.own_errors[found.own_errors["error"] > 0.0]
    axes.semilogy(shown["t"], shown["error"], color=COLOURS[1], label="your run")
    for k, one in enumerate(found.agreements):
        positive = one.apart > 0.0
        axes.semilogy(
            one.t[positive], one.apart[positive], color=COLOURS[(0, 2, 3, 4)[k % 4]], linewidth=0.9,
            label=f"truth against {one.source.label}",
        )  # fmt: skip
    axes.axhline(found.error, color=GUIDE, linestyle=(0, (4, 2)), label="error asked for")
    time, length = (_in(found, kind) for kind in ("time", "length"))
    axes.set(
        xlabel=f"t{time}", ylabel=f"largest error of a {found.kind.PART}{length}", title="errors"
    )
    axes.yaxis.set_major_formatter(  # quicker than mathtext
        lambda number, _: readable(number, 1).removeprefix("1·")
    )
    axes.yaxis.set_minor_formatter(lambda number, _: "")
    axes.legend(fontsize=7)


def _in(found: Judgement, dimension: str) -> str:
    """The unit in brackets."""
    return f" ({found.kind.unit(found.problem, dimension).strip()})"
