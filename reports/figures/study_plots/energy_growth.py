"""How energy errors grow over ensembles of runs: RMS against time, both logarithmic."""

from __future__ import annotations

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.lines import Line2D

from benchmarks.statistics.growth import rms
from benchmarks.studies.round_off import ensembles, reading_floor
from reports.figures.style.decades import decades
from reports.figures.style.identities import GUIDE, identity, in_order
from reports.figures.style.layout import legend
from reports.figures.style.no_data import NoData


def energy_growth(axes: Axes, frame: pd.DataFrame) -> None:
    """The RMS of each ensemble with its single runs, a guide that grows as t^1/2, and the error
    made by rounding one state to float64.

    Where several versions of the code were run, the newest is drawn.
    """
    newest = {}
    for ensemble, t, errors in ensembles(frame) if len(frame) else ():
        key = (ensemble["contender"], ensemble["years"])
        if key not in newest or ensemble["date"] >= newest[key][0]["date"]:
            newest[key] = (ensemble, t, errors)
    seen = [one for one in newest.values() if np.any(rms(one[2]) > 0.0)]
    if not seen:
        raise NoData("no ensemble of runs is complete.")
    names = in_order(ensemble["contender"] for ensemble, _, _ in seen)
    styles = {name: identity(name).style for name in names}
    settings: dict[str, dict[str, None]] = {}
    for ensemble, t, errors in seen:
        color = styles[ensemble["contender"]]["color"]
        axes.plot(t, np.abs(errors).T, color=color, linewidth=0.4, alpha=0.13)
        settings.setdefault(ensemble["contender"], {})[ensemble["settings"]] = None
    handles = [
        Line2D([], [], label="\n".join([name, *settings[name]]), **style)
        for name, style in styles.items()
    ]
    for ensemble, t, errors in seen:
        axes.plot(t, rms(errors), markersize=3.5, **styles[ensemble["contender"]])
    handles += _guides(axes, seen, reading_floor(frame))
    axes.set(
        xscale="log", yscale="log", xlabel="time [years]", ylabel="relative energy error, RMS [1]"
    )
    top = max(float(np.nanmax(np.abs(errors))) for _, _, errors in seen)
    bottom = min(float(np.nanmin(rms(errors))) for _, _, errors in seen)
    axes.set_ylim(0.2 * bottom, 2.0 * top)
    decades(axes.xaxis)
    decades(axes.yaxis)
    legend(axes, handles, [str(one.get_label()) for one in handles])


def _guides(axes: Axes, seen: list, floor: float) -> list[Line2D]:
    """Below the data: t^1/2 from the lowest first point, and the rounding error of one state."""
    first = min(t[0] for _, t, _ in seen)
    last = max(t[-1] for _, t, _ in seen)
    low = 0.5 * min(float(np.nanmin(rms(errors) / np.sqrt(t))) for _, t, errors in seen)
    ends = np.array([first, last])
    lines = axes.plot(ends, low * np.sqrt(ends), color=GUIDE, linestyle=(0, (5, 3)), linewidth=1.0,
                      label="$t^{1/2}$")  # fmt: skip
    if floor > 0.0:
        rounding = axes.axhline(floor, color=GUIDE, linestyle=(0, (1, 2)), linewidth=0.9, zorder=1)
        rounding.set_label("rounding of one state")
        lines.append(rounding)
    return lines
