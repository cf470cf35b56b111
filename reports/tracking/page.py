"""track.html: the history of benches on one page that needs nothing else."""

from __future__ import annotations

import base64
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from jinja2 import Environment, FileSystemLoader, StrictUndefined
from markupsafe import Markup

from reports import page as main_page
from reports.figures.picture import Picture

TEXT = (
    "Times are medians in processor time, divided by those of a fixed piece of work that was timed "
    "just before and after, so that a bench on a busy day does not look slower. Only benches of "
    "one machine and the same versions are compared; counts and errors are those of the same runs. "
)


def render(
    places: Sequence[Any], said: Sequence[str], provenance: Mapping[str, str], rule: str
) -> str:
    """The page of the places, with what there was to say about the files."""
    environment = Environment(
        loader=FileSystemLoader(Path(__file__).parent),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        keep_trailing_newline=True,
    )
    environment.filters["data_uri"] = _data_uri
    css = (Path(str(main_page.__file__)).parent / "page.css").read_text(encoding="utf-8")
    return environment.get_template("track.html.j2").render(
        css=Markup(css),
        text=TEXT + rule,
        places=places,
        said=said,
        provenance=list(provenance.items()),
    )


def _data_uri(picture: Picture) -> str:
    return "data:image/svg+xml;base64," + base64.b64encode(picture.svg).decode()
