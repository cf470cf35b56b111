"""Draw a figure; the same frame gives the same bytes."""

from __future__ import annotations

import io
import re
from dataclasses import dataclass
from pathlib import Path

import matplotlib
import matplotlib.style
import pandas as pd
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure as Canvas

from reports.figures.describe import describe
from reports.figures.moving import animated, hide_all_but_last
from reports.results.figure import Figure

matplotlib.use("Agg")
STYLE = Path(__file__).with_name("galvi.mplstyle")
METADATA = {
    "svg": dict.fromkeys(("Creator", "Date", "Format", "Type")),
    "png": {"Software": None},
    "pdf": dict.fromkeys(("Creator", "Producer", "CreationDate")),
}
PIXELS = 96 / 72  # of CSS, per point


@dataclass(frozen=True)
class Picture:
    """A drawn figure: its name, title, caption, alternative text, and its two files' bytes."""

    name: str
    title: str
    caption: str
    svg: bytes
    png: bytes
    alternative: str = ""

    @property
    def size(self) -> tuple[int, int]:
        """Width and height in pixels of CSS, from the SVG; (0, 0) where it has none."""
        found = re.search(rb'<svg[^>]*?width="([\d.]+)pt" height="([\d.]+)pt"', self.svg)
        width, height = (float(part) for part in found.groups()) if found else (0.0, 0.0)
        return round(PIXELS * width), round(PIXELS * height)


def picture(figure: Figure, frame: pd.DataFrame) -> Picture:
    """Draw a figure from its claim's or its study's frame."""
    with matplotlib.style.context(STYLE):
        canvas = drawn(figure, frame, figure.size)
        svg = animated(saved(canvas, "svg"))
        hide_all_but_last(canvas)
        png = saved(canvas, "png")
        words = describe(canvas)
    title = f"{figure.source}: {figure.title}" if figure.source else figure.title
    return Picture(figure.name, title, figure.caption, svg, png, f"{figure.title}. {words}".strip())


def drawn(figure: Figure, frame: pd.DataFrame, size: tuple[float, float]) -> Canvas:
    """The canvas of a figure, of this size in inches; call it in the style's context."""
    canvas = Canvas(figsize=size)
    FigureCanvasAgg(canvas)
    figure.draw(canvas.add_subplot(), frame, **figure.options)
    return canvas


def saved(canvas: Canvas, form: str) -> bytes:
    """The bytes of a canvas as svg, png or pdf, without dates."""
    into = io.BytesIO()
    canvas.savefig(into, format=form, metadata=METADATA[form])
    return into.getvalue()
