"""The pictures of a judgement: the motion, and the errors over time."""

from __future__ import annotations

from itertools import cycle

import matplotlib.style
import numpy as np
from matplotlib.axes import Axes

from benchmarks.applications.judging import trees
from benchmarks.applications.judging.bodies import names
from benchmarks.applications.judging.judgement import Judgement
from galvi import Multibody
from reports.figures.picture import STYLE, draw_canvas, picture_bytes
from reports.figures.plots.lines import LONG_DASH
from reports.figures.style.decades import set_decade_ticks
from reports.figures.style.identities import COLOURS, GUIDE
from reports.results.section import Figure

MAX_NAMED = 7  # bodies in colour, or coordinates in the legend
PATH_POINTS = 1500  # approximate number of drawn points of a path
PICTURE_SIZE = (4.8, 4.2)  # inches


def pictures(judgement: Judgement) -> list[str]:
    """Two SVGs: of the motion, as orbits in the x-y plane or as coordinates of joints; and of the
    errors."""
    draw = joints if isinstance(judgement.problem.system, Multibody) else orbits
    figures = (
        Figure("motion", "The motion", draw, size=PICTURE_SIZE),
        Figure("errors", "Errors", errors, size=PICTURE_SIZE),
    )
    with matplotlib.style.context(STYLE):
        svgs = [picture_bytes(draw_canvas(figure, judgement), "svg").decode() for figure in figures]
    return [svg[svg.index("<svg") :] for svg in svgs]


def joints(axes: Axes, judgement: Judgement) -> None:
    """Draw the entries of MuJoCo's qpos over time."""
    problem, truth = judgement.problem, judgement.truth
    qpos, _ = problem.system.to_mujoco(truth.q, np.zeros((len(truth.t), problem.v0.size)))
    for k, name in enumerate(trees.entries(problem)):
        axes.plot(truth.t, qpos[:, k], linewidth=0.9, label=name if k < MAX_NAMED else None)
    axes.set(xlabel=f"t{unit(judgement, 'time')}", ylabel="entries of qpos (rad, m, quaternions)")


def orbits(axes: Axes, judgement: Judgement) -> None:
    """Draw the paths of the MAX_NAMED heaviest bodies, and the last positions of all bodies."""
    problem, q = judgement.problem, judgement.truth.q
    by_mass = np.argsort(-problem.system.masses, kind="stable")
    axes.plot(*q[-1, by_mass[MAX_NAMED:], :2].T, ".", color=GUIDE, markersize=2, zorder=0)
    labels, stride = names(problem), max(1, len(q) // PATH_POINTS)
    for k, color in zip(by_mass[:MAX_NAMED], COLOURS, strict=False):
        axes.plot(*q[::stride, k, :2].T, color=color, linewidth=0.5, alpha=0.7)
        axes.plot(*q[-1, k, :2], "o", color=color, markersize=4, label=labels[k])
    length = unit(judgement, "length")
    axes.set(xlabel=f"x{length}", ylabel=f"y{length}")
    axes.set_aspect("equal", adjustable="datalim")


def errors(axes: Axes, judgement: Judgement) -> None:
    """Draw the errors of the user's run, and the distances between the sources of the truth."""
    shown = judgement.own_errors[judgement.own_errors["error"] > 0.0]
    axes.semilogy(shown["t"], shown["error"], color=COLOURS[1], label="your run")
    remaining_colors = (COLOURS[0], *COLOURS[2:5])
    for agreement, color in zip(judgement.agreements, cycle(remaining_colors), strict=False):
        distance = np.where(agreement.distances > 0.0, agreement.distances, np.nan)
        label = f"truth against {agreement.source.label}"
        axes.semilogy(agreement.t, distance, color=color, linewidth=0.9, label=label)
    axes.axhline(judgement.error, color=GUIDE, linestyle=LONG_DASH, label="error asked for")
    part = f"largest error of a {judgement.kind.PART}"
    axes.set(xlabel=f"t{unit(judgement, 'time')}", ylabel=f"{part}{unit(judgement, 'length')}")
    set_decade_ticks(axes.yaxis)


def unit(judgement: Judgement, dimension: str) -> str:
    """The unit of a length or a time, in brackets."""
    return f" ({judgement.kind.unit(judgement.problem, dimension).strip()})"
