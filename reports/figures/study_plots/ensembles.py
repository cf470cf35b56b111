"""What lanes, threads and workers gain over runs one by one."""

from __future__ import annotations

import pandas as pd
from matplotlib.axes import Axes

from reports.figures.style.identities import GUIDE
from reports.figures.style.no_data import NoData


def speed_ups(axes: Axes, frame: pd.DataFrame) -> None:
    """Members per second relative to the first row of the part on scaling."""
    rows = frame[frame["part"] == "scaling"] if len(frame) else frame
    if rows.empty:
        raise NoData("nothing was measured.")
    places = range(len(rows))[::-1]
    axes.barh(list(places), rows["relative"], height=0.6)
    axes.axvline(1.0, color=GUIDE, linestyle=(0, (5, 3)), linewidth=1.0)
    axes.set_yticks(list(places), list(rows["contender"]))
    axes.set(xlabel="members per second, relative to one by one")
