"""Draw a figure; the same frame gives the same bytes."""

from __future__ import annotations

import io
from dataclasses import dataclass
from pathlib import Path

import matplotlib
import matplotlib.style
import pandas as pd
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure as Canvas

from reports.figures.moving import animated, hide_all_but_last
from reports.results.figure import Figure

matplotlib.use("Agg")
STYLE = Path(__file__).with_name("galvi.mplstyle")


@dataclass(frozen=True)
class Picture:
    """A drawn figure: its name, title and caption, and its two files' bytes."""

    name: str
    title: str
    caption: str
    svg: bytes
    png: bytes


def picture(figure: Figure, frame: pd.DataFrame) -> Picture:
    """Draw a figure from its claim's or its study's frame."""
    with matplotlib.style.context(STYLE):
        canvas = Canvas(figsize=figure.size)
        FigureCanvasAgg(canvas)
        figure.draw(canvas.add_subplot(), frame, **figure.options)
        svg, png = io.BytesIO(), io.BytesIO()
        nothing = dict.fromkeys(("Creator", "Date", "Format", "Type"))
        canvas.savefig(svg, format="svg", metadata=nothing)
        hide_all_but_last(canvas)
        canvas.savefig(png, format="png", metadata={"Software": None})
    title = f"{figure.source}: {figure.title}" if figure.source else figure.title
    return Picture(figure.name, title, figure.caption, animated(svg.getvalue()), png.getvalue())
