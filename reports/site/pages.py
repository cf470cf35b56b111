"""The pages of results: MyST templates in docs/results, which Jinja fills with a report's rows.

A template has the report as `report`, and the names that `_environment` lists. Tables and long
texts are HTML without blank lines, which MyST leaves unchanged.
"""

from __future__ import annotations

import base64
import re
from functools import cache
from typing import Any

import pandas as pd
from jinja2 import Environment, FileSystemLoader, StrictUndefined
from markupsafe import Markup

from benchmarks.checks.bounds import VERDICTS
from benchmarks.checks.claim import Row
from benchmarks.claims.statements import EFFECTS, status_counts
from benchmarks.store.provenance import ROOT
from benchmarks.work_precision.labels import label_of
from benchmarks.work_precision.problem import EARLY_TOLERANCES
from references.stored.provenance import HEADINGS, truths
from reports.figures.headlines import HEADLINES
from reports.figures.picture import Picture, slug
from reports.figures.profiles import PROFILES
from reports.results.origins import describe_origins
from reports.site import comparisons
from reports.site.motion import motions
from reports.site.peers import peers
from reports.site.report import Report
from reports.site.sources import command_lines, file_table, sentences, without_folder
from reports.site.typeset import typeset
from reports.tables.comparison_tables import (
    built,
    elsewhere,
    energies,
    fastest_cells,
    fastest_lines,
    mujoco_overhead,
    of_mujoco,
    readable_ratios,
)
from reports.tables.html import html_table
from reports.tables.number_format import is_finite, readable, with_uncertainty
from reports.tables.study_table import readable_cost, without_common
from reports.tables.summary_sentences import chances
from reports.tables.targets_table import TEXT, readable_targets
from reports.tables.targets_table import summary as targets_summary

DOCS = ROOT / "docs"
RESULTS = "results"  # folder of these pages
PAGES = (
    "index",
    "comparisons",
    "claims",
    "statements",
    "studies",
    "history",
    "reproduce",
    "provenance",
)
SMALL_UNCERTAINTY = 1e-4  # relative uncertainty below which a number is shown with 4 digits only
LARGE_COUNT = 1e5  # counts below this are shown in full
MARKDOWN = re.compile(r"([\\`*_{}\[\]<>$|#~&])")
FIGURES_FOLDER = "figures"
DOCUTILS_SETTINGS = {  # of docutils; lines are as long as the pictures in them
    "doctitle_xform": False,
    "raw_enabled": True,
    "line_length_limit": 10**9,
    "halt_level": 3,
}


def page(name: str, report: Report, single: bool = False) -> str:
    """The MyST text of a page.

    Parameters
    ----------
    name
        its name in Sphinx, as "results/claims"
    single
        whether the page is part of a single file: pictures are embedded, and links are anchors
    """
    text = (DOCS / f"{name}.md").read_text(encoding="utf-8")
    return render(text, name, report, single)


def render(text: str, name: str, report: Report, single: bool = False) -> str:
    """The MyST text of a page from the text of its template; other arguments as for `page`."""
    up = "../" * name.count("/")
    results_path = "" if name.startswith(f"{RESULTS}/") else f"{RESULTS}/"

    def link(part: str, anchor: str = "") -> str:
        if single:
            return f"#{anchor or part}"
        return f"{results_path}{part}.html{f'#{anchor}' if anchor else ''}"

    def source(picture: Picture) -> str:
        return data_uri(picture) if single else f"{up}{FIGURES_FOLDER}/{picture.name}.svg"

    template = _environment().from_string(text)
    return template.render(report=report, link=link, source=source, up=up, single=single)


@cache
def _environment() -> Environment:
    environment = Environment(
        loader=FileSystemLoader([DOCS / RESULTS, DOCS]),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
        keep_trailing_newline=True,
    )
    environment.filters.update(
        measured=measured,
        plain=plain,
        readable=readable,
        time_spent=time_spent,
        typeset=typeset,
        without_folder=without_folder,
    )
    functions: tuple[Any, ...] = (
        built, chances, command_lines, status_counts, describe_origins, elsewhere, energies,
        fastest_cells, fastest_lines, file_table, html_table, in_text, label_of, motions,
        mujoco_overhead, of_mujoco, peers, readable_cost, readable_ratios, readable_targets,
        sentences, slug,
        without_common, comparisons.filters, comparisons.installed_engines,
    )  # fmt: skip
    environment.globals.update({function.__name__: function for function in functions})
    environment.globals.update(
        EFFECTS=EFFECTS,
        HEADLINES=HEADLINES,
        PROFILES=PROFILES,
        STOPS=EARLY_TOLERANCES,
        TARGETS_TEXT=TEXT,
        VERDICTS=VERDICTS,
        list=list,
        targets_summary=targets_summary,
        stored_truths=truths,
        truth_headings=HEADINGS,
        DataFrame=pd.DataFrame,
    )
    environment.tests.update(known=is_finite)
    return environment


def in_text(table: pd.DataFrame) -> pd.DataFrame:
    """The table with its numbers as texts."""
    return table.map(lambda cell: readable(cell) if isinstance(cell, float) else str(cell))


def plain(text: str) -> Markup:
    """The text with Markdown's characters escaped, for headings."""
    return Markup(MARKDOWN.sub(r"\\\1", text))


def data_uri(picture: Picture) -> str:
    """The data URI of a picture: of its SVG, or of its PNG if that is less than half as long."""
    kind, content = ("svg+xml", picture.svg)
    if 2 * len(picture.png) < len(picture.svg):
        kind, content = "png", picture.png
    return f"data:image/{kind};base64,{base64.b64encode(content).decode()}"


def time_spent(number: Any) -> str:
    """A time in seconds as text with two digits, in minutes from 120 s on; "" if unknown."""
    if is_finite(number) and number >= 120.0:
        return f"{readable(number / 60.0, 2)} min"
    return f"{readable(number, 2)} s" if is_finite(number) else ""


def measured(row: Row) -> str:
    """The row's number with its uncertainty, counts in full; "not run" if there is no number."""
    number, error = row.measured, row.uncertainty
    if is_finite(number) and is_finite(error) and 0.0 < error < SMALL_UNCERTAINTY * abs(number):
        return f"{readable(number, 4)} ± {readable(error, 1)}"
    if (
        is_finite(number)
        and not is_finite(error)
        and float(number).is_integer()
        and abs(number) < LARGE_COUNT
    ):
        return readable(number, len(f"{abs(number):.0f}"))
    return with_uncertainty(number, error) or "not run"


def single_file(report: Report) -> str:
    """All pages of results as one self-contained HTML file."""
    from docutils.core import publish_parts
    from myst_parser.docutils_ import Parser

    bodies = []
    for name in PAGES:
        parts = publish_parts(
            page(f"{RESULTS}/{name}", report, single=True),
            parser=Parser(),
            writer="html5",
            settings_overrides=DOCUTILS_SETTINGS,
        )
        bodies.append((name, Markup(parts["body"])))
    folder = DOCS / "_static"
    return (
        _environment()
        .get_template("single.j2")
        .render(
            bodies=bodies,
            report=report,
            css=Markup((folder / "results.css").read_text(encoding="utf-8")),
            script=Markup((folder / "results.js").read_text(encoding="utf-8")),
        )
    )
