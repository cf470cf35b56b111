"""Errors of rotations, momenta and energies in long runs: RMS against steps, both logarithmic."""

from __future__ import annotations

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.lines import Line2D

from benchmarks.statistics.growth import rms
from benchmarks.studies.so3_drift import QUANTITIES, ensembles
from reports.figures.style.decades import decades, whole_decades
from reports.figures.style.identities import GUIDE, identity, in_order
from reports.figures.style.layout import legend, panels, share_y_label
from reports.figures.style.legends import contender_legend
from reports.figures.style.no_data import NoData

DASHES = (0, (5, 3))
TITLES = {
    "orthogonality": "off SO(3): $|R^T R - I|$",
    "momentum": r"momentum: $|R\mu - R_0\mu_0| / |\mu_0|$",
    "energy": "energy, relative",
}


def so3_drift_growth(axes: Axes, frame: pd.DataFrame) -> None:
    """A panel for each quantity, with a guide that grows as the square root of the steps."""
    found = [one for one in ensembles(frame) if np.all(np.isfinite(one[3]))]
    if not found:
        raise NoData("no ensemble of runs is complete.")
    names = in_order(ensemble["contender"] for ensemble, _, _, _ in found)
    places = panels(axes, len(QUANTITIES))
    share_y_label(places, "RMS over the runs [1]")
    for one, (name, text) in zip(places, QUANTITIES.items(), strict=True):
        one.set(xscale="log", yscale="log", xlabel="steps", title=TITLES.get(name, text))
        least, first, last = np.inf, np.inf, 0.0
        for ensemble, quantity, done, errors in found:
            if quantity != name:
                continue
            one.plot(done, rms(errors), markersize=3.0, **identity(ensemble["contender"]).style)
            first, last = min(first, done[0]), max(last, done[-1])
            least = min(least, float(rms(errors)[0]))
        one.autoscale_view()
        whole_decades(one.yaxis)
        one.autoscale(False)  # the guide, which begins at the data, widens no axis
        ends = np.array([first, last])
        one.plot(ends, least * np.sqrt(ends / first), color=GUIDE, linestyle=DASHES, linewidth=1.0)
        decades(one.xaxis)
        decades(one.yaxis)
    contender_legend(one, names)
    legend(one, [Line2D([], [], color=GUIDE, linestyle=DASHES)], ["square root of the steps"])
