"""Grains in the air below a rotor: a picture for each time, and one that moves."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import pandas as pd
from matplotlib.axes import Axes

from benchmarks.applications.brownout.cloud import PILOT, SEEN
from benchmarks.store.frames import pick
from galvi.arrays import Array
from galvi.kernels.forces.rotor_wind import R, decay, rotor_height
from reports.figures.moving import in_frame
from reports.figures.style.identities import COLOURS, GUIDE
from reports.figures.style.layout import WIDE, NoData, legend, panels

WIDTH, HEIGHT = 20.0, 12.0  # m, half of the width
BESIDE = 0.7  # inches of labels, beside and below a picture


def clouds(
    axes: Axes, frame: pd.DataFrame, *, study: str, labels: Sequence[str], times: Sequence[float]
) -> None:
    """x and z of the grains in the air, seen from the side: a panel for each time, a colour for
    each label, the last in front. The rotor is a line, the ray along which the optical depth is
    taken is dashed."""
    _known(frame, study)
    canvas = axes.figure
    columns = 2 if canvas.get_figwidth() > WIDE else 1
    across = canvas.get_figwidth() / columns - BESIDE
    rows = -(-len(times) // columns)
    canvas.set_figheight(rows * (across * HEIGHT / (2.0 * WIDTH) + BESIDE))
    places = panels(axes, len(times), columns=columns)
    for one, t in zip(places, times, strict=True):
        for i, label in enumerate(labels):
            x, z = _places(frame, study, label, t)
            one.plot(x, z, ".", color=COLOURS[i], markersize=2.2, markeredgewidth=0.0,
                     rasterized=True)  # fmt: skip
        _scene(one, t)
        one.set(title=f"{t:g} s", xlabel="$x$ [m]", ylabel="$z$ [m]")
    _sizes(one, labels)


def moving_cloud(axes: Axes, frame: pd.DataFrame, *, study: str, labels: Sequence[str]) -> None:
    """The same, of all sizes at once, as a picture that moves; it ends with the last time."""
    times = np.unique(_known(frame, study)["t"])
    for k, t in enumerate(times):
        for i, label in enumerate(labels):
            x, z = _places(frame, study, label, t)
            (dots,) = axes.plot(x, z, ".", color=COLOURS[i], markersize=2.5, markeredgewidth=0.0)
            in_frame(dots, k, len(times))
        (rotor,) = axes.plot([-R, R], [rotor_height(decay(t))] * 2, color="#222222", linewidth=1.5)
        in_frame(rotor, k, len(times))
        in_frame(axes.text(-19.0, 10.8, f"{t:.2f} s"), k, len(times))
    _sizes(axes, labels)
    canvas = axes.figure
    canvas.set_figheight(BESIDE + (canvas.get_figwidth() - BESIDE) * HEIGHT / (2.0 * WIDTH))
    axes.set(xlim=(-WIDTH, WIDTH), ylim=(0.0, HEIGHT), aspect="equal", yticks=[0, 5, 10],
             xlabel="$x$ [m]", ylabel="$z$ [m]")  # fmt: skip


def _sizes(axes: Axes, labels: Sequence[str]) -> None:
    """The legend."""
    for i, label in enumerate(labels):
        axes.plot([], [], "o", color=COLOURS[i], label=label.replace("micrometres", "µm"))
    legend(axes)


def _known(frame: pd.DataFrame, study: str) -> pd.DataFrame:
    found = pick(frame, study=study)
    if not len(found) or not np.any(np.isfinite(found["x"])):
        raise NoData("no grain's place is known.")
    return found


def _places(frame: pd.DataFrame, study: str, label: str, t: float) -> tuple[Array, Array]:
    rows = pick(frame, study=study, label=label, t=t)
    return rows["x"].to_numpy(float), rows["z"].to_numpy(float)


def _scene(axes: Axes, t: float) -> None:
    axes.plot([-R, R], [rotor_height(decay(t))] * 2, color="#222222", linewidth=1.2)
    axes.plot(*zip(PILOT, SEEN, strict=True), color=GUIDE, linewidth=0.7, linestyle=(0, (4, 3)))
    axes.set(xlim=(-WIDTH, WIDTH), ylim=(0.0, HEIGHT), aspect="equal")
    axes.locator_params(nbins=3)
