"""Render pages from their content: one file for each part, or all in one self-contained file."""

from __future__ import annotations

import base64
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any

from jinja2 import Environment, FileSystemLoader, StrictUndefined
from markupsafe import Markup

from benchmarks.checks.claim import Row
from reports.figures.picture import Picture
from reports.page.typeset import typeset
from reports.tables.number_format import known, readable, seconds, with_uncertainty

TEMPLATES = Path(__file__).parent / "templates"
ASSETS = "assets"  # subfolder of a report with style sheet and script
FIGURES = "figures"
SMALL = 1e-4  # relative uncertainty below which a number is not shown to its digits
MANY = 1e5  # counts below this are shown in full


@dataclass(frozen=True)
class Part:
    """One page of a report: the name of its file and template, and its title."""

    name: str
    title: str

    @property
    def template(self) -> str:
        """The file of its template."""
        return f"{self.name}.html.j2"


PARTS = (
    Part("index", "Start"),
    Part("comparisons", "Comparisons"),
    Part("statements", "Statements"),
    Part("claims", "Claims"),
    Part("studies", "Studies"),
    Part("history", "Performance history"),
    Part("reproduce", "Reproduce this"),
    Part("provenance", "Provenance"),
)


def render(
    content: dict[str, Any],
    parts: Sequence[Part],
    pages: Sequence[Part] = PARTS,
    contents: Sequence[tuple[str, str, int]] = (),
    single: bool = False,
    documentation: str = "",
) -> str:
    """A page of these parts; raises jinja2.UndefinedError for a missing variable.

    pages     all parts to which the page links
    contents  (anchor, title, level) of the page's contents
    single    self-contained: figures, style and script are embedded
    documentation  where that is; "" for none
    """
    heading = "galvi: high-order variational integrators, checked and timed"
    if not single and parts[0].name != PARTS[0].name:
        heading = f"{parts[0].title}, galvi"
    environment = page_environment(single=single)
    return environment.get_template("frame.html.j2").render(
        parts=parts, pages=pages, contents=contents, heading=heading, single=single,
        css=style() if single else "", script=script() if single else "", assets=ASSETS,
        documentation=documentation, **content,
    )  # fmt: skip


@cache
def page_environment(folder: Path | None = None, single: bool = True) -> Environment:
    """The Jinja environment for these templates, and first for those of another folder.

    Kept, with the templates it has compiled.
    """
    environment = Environment(
        loader=FileSystemLoader([*([folder] if folder else []), TEMPLATES]),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        keep_trailing_newline=True,
    )
    environment.filters.update(
        measured=_measured,
        readable=readable,
        seconds=seconds,
        spent=spent,
        typeset=typeset,
    )
    environment.globals.update(
        single=single,
        source=data_uri if single else lambda item: f"{FIGURES}/{item.name}.svg",
        link=_within if single else _between,
    )
    return environment


def style() -> Markup:
    """The style sheet of every page."""
    return Markup((TEMPLATES / "page.css").read_text(encoding="utf-8"))


def script() -> Markup:
    """The script of every page."""
    return Markup((TEMPLATES / "page.js").read_text(encoding="utf-8"))


def data_uri(picture: Picture) -> str:
    """A picture inside the page: as SVG, or as PNG where that is much shorter."""
    kind, data = ("svg+xml", picture.svg)
    if 2 * len(picture.png) < len(picture.svg):
        kind, data = "png", picture.png
    return f"data:image/{kind};base64,{base64.b64encode(data).decode()}"


def spent(number: Any) -> str:
    """A time in seconds with two digits, as minutes from two on; "" when unknown."""
    if known(number) and number >= 120.0:
        return f"{readable(number / 60.0, 2)} min"
    return f"{readable(number, 2)} s" if known(number) else ""


def _between(part: str, anchor: str = "") -> str:
    return f"{part}.html{f'#{anchor}' if anchor else ''}"


def _within(part: str, anchor: str = "") -> str:
    return f"#{anchor or part}"


def _measured(row: Row) -> str:
    """The number with its uncertainty, counts in full; "not run" where there is none."""
    number, error = row.measured, row.uncertainty
    if known(number) and known(error) and 0.0 < error < SMALL * abs(number):
        return f"{readable(number, 4)} ± {readable(error, 1)}"
    if known(number) and not known(error) and float(number).is_integer() and abs(number) < MANY:
        return readable(number, len(f"{abs(number):.0f}"))
    return with_uncertainty(number, error) or "not run"
