"""Grains in the air below a rotor: a picture for each size and time, and one that moves."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import pandas as pd
from matplotlib.axes import Axes

from benchmarks.applications.brownout.cloud import PILOT, SEEN
from benchmarks.store.frames import pick
from galvi.arrays import Array
from galvi.kernels.forces.rotor_wind import R, rotor_height
from reports.figures.moving import in_frame
from reports.figures.style.identities import COLOURS, GUIDE
from reports.figures.style.layout import WIDE, NoData, legend, panels

WIDTH, HEIGHT = 20.0, 12.0  # m, half of the width
BESIDE = 0.7  # inches of labels, beside and below a picture
FLAT, TITLE = 0.28, 0.24  # height over width of a panel; inches of its title


def clouds(
    axes: Axes, frame: pd.DataFrame, *, study: str, labels: Sequence[str], times: Sequence[float]
) -> None:
    """x and z of the grains in the air, seen from the side: panels for each label, one for each
    time. The rotor is a line, the ray along which the optical depth is taken is dashed."""
    _known(frame, study)
    canvas = axes.figure
    columns = len(times) if canvas.get_figwidth() > WIDE else len(times) // 2
    titled = columns < len(times)
    high = TITLE * titled + FLAT * canvas.get_figwidth() / columns
    canvas.set_figheight(high * len(labels) * len(times) / columns + 3.0 * TITLE)
    places = iter(panels(axes, len(labels) * len(times), columns=columns))
    for i, label in enumerate(labels):
        for k, t in enumerate(times):
            one = next(places)
            x, z = _places(frame, study, label, t)
            one.plot(x, z, ".", color=COLOURS[i], markersize=1.6, markeredgewidth=0.0,
                     rasterized=True)  # fmt: skip
            _scene(one, t)
            first, last = k % columns == 0, i == len(labels) - 1 and k >= len(times) - columns
            if i == 0 or titled:
                one.set_title(f"{t:g} s", pad=3, fontweight="normal")
            if k == 0:
                one.plot([], [], "o", color=COLOURS[i], label=label.replace("micrometres", "µm"))
                legend(one)
            one.set(xlabel="$x$ [m]" if last else "", ylabel="$z$ [m]" if first else "")
            one.tick_params(labelbottom=last, labelleft=first)


def moving_cloud(axes: Axes, frame: pd.DataFrame, *, study: str, labels: Sequence[str]) -> None:
    """The same, of all sizes at once, as a picture that moves; it ends with the last time."""
    times = np.unique(_known(frame, study)["t"])
    for k, t in enumerate(times):
        for i, label in enumerate(labels):
            x, z = _places(frame, study, label, t)
            (dots,) = axes.plot(x, z, ".", color=COLOURS[i], markersize=2.5, markeredgewidth=0.0)
            in_frame(dots, k, len(times))
        (rotor,) = axes.plot([-R, R], [rotor_height(t)] * 2, color="#222222", linewidth=1.5)
        in_frame(rotor, k, len(times))
        in_frame(axes.text(-19.0, 10.8, f"{t:.2f} s"), k, len(times))
    for i, label in enumerate(labels):
        axes.plot([], [], "o", color=COLOURS[i], label=label.replace("micrometres", "µm"))
    legend(axes)
    canvas = axes.figure
    canvas.set_figheight(BESIDE + (canvas.get_figwidth() - BESIDE) * HEIGHT / (2.0 * WIDTH))
    axes.set(xlim=(-WIDTH, WIDTH), ylim=(0.0, HEIGHT), aspect="equal", yticks=[0, 5, 10],
             xlabel="$x$ [m]", ylabel="$z$ [m]")  # fmt: skip


def _known(frame: pd.DataFrame, study: str) -> pd.DataFrame:
    found = pick(frame, study=study)
    if not len(found) or not np.any(np.isfinite(found["x"])):
        raise NoData("no grain's place is known.")
    return found


def _places(frame: pd.DataFrame, study: str, label: str, t: float) -> tuple[Array, Array]:
    rows = pick(frame, study=study, label=label, t=t)
    return rows["x"].to_numpy(float), rows["z"].to_numpy(float)


def _scene(axes: Axes, t: float) -> None:
    axes.plot([-R, R], [rotor_height(t)] * 2, color="#222222", linewidth=1.2)
    axes.plot(*zip(PILOT, SEEN, strict=True), color=GUIDE, linewidth=0.7, linestyle=(0, (4, 3)))
    axes.set(xlim=(-WIDTH, WIDTH), ylim=(0.0, HEIGHT), aspect="equal")
    axes.locator_params(nbins=3)
