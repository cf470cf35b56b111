"""A figure as data: which claim's frame it reads, what draws it, what it says."""

from __future__ import annotations

import io
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import matplotlib
import matplotlib.style
import pandas as pd
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure as Canvas

from reports.results.claim_results import ClaimResult

matplotlib.use("Agg")
STYLE = Path(__file__).with_name("galvi.mplstyle")


@dataclass(frozen=True)
class Figure:
    """One picture.

    name     of its files, e.g. "fig-2-03"
    title    what is shown, in one line
    draw     (axes, frame, **options)
    source   the paper's figure, as the claims name it, e.g. "H fig. 2.3"
    claims   whose frame it draws: the first of these that was measured
    options  what `draw` takes besides: quantities, labels, claimed rates
    caption  what the reader should see
    size     width and height in inches
    """

    name: str
    title: str
    draw: Callable[..., None]
    source: str = ""
    claims: tuple[str, ...] = ()
    options: Mapping[str, Any] = field(default_factory=dict)
    caption: str = ""
    size: tuple[float, float] = (6.4, 4.0)

    def read(self, checked: Sequence[ClaimResult]) -> ClaimResult | None:
        """The claim it draws from: the first of its claims whose study gave a frame."""
        measured = {one.claim.id: one for one in checked if one.frame is not None}
        return next((measured[claim] for claim in self.claims if claim in measured), None)


@dataclass(frozen=True)
class Picture:
    """A drawn figure: its name, title and caption, and its two files' bytes."""

    name: str
    title: str
    caption: str
    svg: bytes
    png: bytes


def picture(figure: Figure, frame: pd.DataFrame) -> Picture:
    """Draw a figure from its claim's frame; the same frame gives the same bytes."""
    with matplotlib.style.context(STYLE):
        canvas = Canvas(figsize=figure.size)
        FigureCanvasAgg(canvas)
        figure.draw(canvas.add_subplot(), frame, **figure.options)
        svg, png = io.BytesIO(), io.BytesIO()
        nothing = dict.fromkeys(("Creator", "Date", "Format", "Type"))
        canvas.savefig(svg, format="svg", metadata=nothing)
        canvas.savefig(png, format="png", metadata={"Software": None})
    title = f"{figure.source}: {figure.title}" if figure.source else figure.title
    return Picture(figure.name, title, figure.caption, svg.getvalue(), png.getvalue())
