"""Draw figures as SVG, PNG and PDF, in several widths."""

from __future__ import annotations

import io
import re
from dataclasses import dataclass
from pathlib import Path

import matplotlib.style
import pandas as pd

from benchmarks.store.atomic import write
from reports.figures.describe import describe
from reports.figures.moving import animated, show_all_frames
from reports.figures.style.layout import Canvas, NoData, finish
from reports.results.section import Figure

STYLE = Path(__file__).with_name("galvi.mplstyle")
METADATA = {
    "svg": dict.fromkeys(("Creator", "Date", "Format", "Type")),
    "png": {"Software": None},
    "pdf": dict.fromkeys(("Creator", "Producer", "CreationDate")),
}
SUFFIXES = (".svg", ".png", "-narrow.svg")  # of the names of a picture's files
PIXELS_PER_INCH = 96.0  # CSS pixels per inch
NARROW_WIDTH = 3.75  # inches, on a telephone of 400 pixels with its margins
WIDTHS = {"column": 3.3, "page": 6.9}  # inches
PRINT_STYLE = {"pdf.fonttype": 42, "savefig.dpi": 300}
SMALL_STYLE = {
    "font.size": 7.0,
    "axes.titlesize": 7.5,
    "axes.labelsize": 7.0,
    "xtick.labelsize": 6.5,
    "ytick.labelsize": 6.5,
    "legend.fontsize": 6.5,
    "lines.markersize": 3.0,
    "lines.linewidth": 1.1,
}


@dataclass(frozen=True)
class Picture:
    """A drawn figure: its name, title, caption and alternative text, and the bytes of its files.

    Attributes
    ----------
    size
        width and height of the SVG in CSS pixels
    narrow
        the SVG for a telephone, NARROW_WIDTH inches wide; empty where the figure needs more
    narrow_size
        width and height of `narrow` in CSS pixels
    """

    name: str
    title: str
    caption: str
    alternative: str
    png: bytes
    svg: bytes
    size: tuple[int, int]
    narrow: bytes = b""
    narrow_size: tuple[int, int] = (0, 0)


def picture(figure: Figure, table: pd.DataFrame) -> Picture:
    """Draw a figure from its table. Raises NoData where the table has no number to show."""
    with matplotlib.style.context(STYLE):
        canvas = draw_canvas(figure, table)
        png, description = picture_bytes(canvas, "png"), describe(canvas)
        files = svg_and_size(canvas)
        if figure.min_width < NARROW_WIDTH:
            files += svg_and_size(draw_canvas(figure, table, NARROW_WIDTH))
    title = f"{figure.source}: {figure.title}" if figure.source else figure.title
    alternative = f"{figure.title}. {description}".strip()
    return Picture(figure.name, title, figure.caption, alternative, png, *files)


def svg_and_size(canvas: Canvas) -> tuple[bytes, tuple[int, int]]:
    """The SVG of a canvas, animated if it has frames, and its width and height in CSS pixels."""
    show_all_frames(canvas)
    width, height = PIXELS_PER_INCH * canvas.get_size_inches()
    return animated(picture_bytes(canvas, "svg")), (round(width), round(height))


def printed_figure(figure: Figure, table: pd.DataFrame, form: str, width: float) -> bytes:
    """The bytes of a figure's file, for print, `width` inches wide.

    Parameters
    ----------
    form
        "pdf", "svg" or "png"
    """
    with matplotlib.style.context([STYLE, PRINT_STYLE, SMALL_STYLE if width < 3.6 else {}]):
        return picture_bytes(draw_canvas(figure, table, width), form)


def draw_canvas(figure: Figure, table: pd.DataFrame, width: float = 0.0) -> Canvas:
    """Draw a figure in the current style, `width` inches wide or, for 0, in its own size.

    Raises NoData if `width` is below the figure's `min_width`, or the table has nothing to show.
    """
    if 0.0 < width < figure.min_width:
        raise NoData(f"it needs {figure.min_width:g} inches; {width:g} were asked for.")
    canvas = Canvas(figure.size, width or figure.size[0])
    figure.draw(canvas.add_subplot(), table, **figure.options)
    finish(canvas)
    return canvas


def picture_bytes(canvas: Canvas, form: str) -> bytes:
    """The bytes of a canvas as svg, png or pdf, without dates, so that equal pictures are equal."""
    buffer = io.BytesIO()
    canvas.savefig(buffer, format=form, metadata=METADATA[form])
    return buffer.getvalue()


def slug(problem: str) -> str:
    """The file name, without its extension, of the comparison on a problem."""
    return "work-precision-" + re.sub(r"[^a-z0-9]+", "-", problem.lower()).strip("-")


def write_files(picture: Picture, folder: Path) -> None:
    """Write the files of a picture, and remove an earlier narrow one where it has none."""
    for suffix, content in zip(SUFFIXES, (picture.svg, picture.png, picture.narrow), strict=True):
        if content:
            write(folder / f"{picture.name}{suffix}", content)
        else:
            (folder / f"{picture.name}{suffix}").unlink(missing_ok=True)
