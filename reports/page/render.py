"""Render index.html from its content, with embedded figures and style, without scripts."""

from __future__ import annotations

import base64
from pathlib import Path
from typing import Any

from jinja2 import Environment, FileSystemLoader, StrictUndefined
from markupsafe import Markup

from benchmarks.checks.claim import Row
from reports.figures.picture import Picture
from reports.page.typeset import typeset
from reports.tables.number_format import readable, seconds, with_uncertainty

HERE = Path(__file__).parent


def render(content: dict[str, Any]) -> str:
    """Fill the template; raises jinja2.UndefinedError for a missing variable."""
    return page_environment(HERE).get_template("page.html.j2").render(css=style(), **content)


def page_environment(folder: Path) -> Environment:
    """The Jinja environment for the templates of a folder."""
    environment = Environment(
        loader=FileSystemLoader(folder),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        keep_trailing_newline=True,
    )
    environment.filters.update(
        data_uri=_data_uri,
        measured=_measured,
        readable=readable,
        seconds=seconds,
        typeset=typeset,
    )
    environment.globals["zip"] = zip
    return environment


def style() -> Markup:
    """The style sheet of every page."""
    return Markup((HERE / "page.css").read_text(encoding="utf-8"))


def _data_uri(picture: Picture) -> str:
    return "data:image/svg+xml;base64," + base64.b64encode(picture.svg).decode()


def _measured(row: Row) -> str:
    """The number with its uncertainty; "not run" where there is none."""
    return with_uncertainty(row.measured, row.uncertainty) or "not run"
