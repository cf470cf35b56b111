"""Draw all figures of the report, with a sentence for each that could not be drawn."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import pandas as pd

from benchmarks.work_precision.labels import label_of
from benchmarks.work_precision.problem import ANGLE, ATTITUDE, COORDINATES, MOTION, POSITION
from reports.figures.catalogue.all import FIGURES
from reports.figures.headlines import HEADLINES
from reports.figures.picture import SUFFIXES, Picture, picture, slug, write_files
from reports.figures.profiles import PROFILES
from reports.figures.style.decades import error_label
from reports.figures.work_precision import work_precision
from reports.results.claim_results import ClaimResult, first_measured
from reports.results.comparison import Comparison
from reports.results.section import Figure
from reports.results.section_result import SectionResult
from reports.tables.comparison_tables import is_galvi, matched
from reports.tables.summary_sentences import summary_sentences


@dataclass(frozen=True, eq=False)
class Gallery:
    """Pictures by the name of their figure, and the reasons why others are missing."""

    pictures: dict[str, Picture]
    missing: dict[str, str]


ERROR_MEASURES = {
    POSITION: "Largest distance of a body from its true position",
    ATTITUDE: "Largest entry of R - R_true",
    COORDINATES: "Largest difference of a coordinate",
    MOTION: "Largest difference of an entry of the attitude, of the place or of a hinge's angle",
    ANGLE: "Largest of the links' angles, in radians",
}


FAST_HEYOKA = ("heyoka, chains", "heyoka, Lagrangians")
MISSING_FEATURES = {  # quantity -> a sentence on features of the other codes that galvi lacks
    POSITION: "galvi merges and bounces nothing, and sums all pairs of bodies directly.",
    COORDINATES: "galvi has no constraints between coordinates.",
}
MISSING_BODY_FEATURES = "galvi has no contacts, joint limits or closed loops, which MuJoCo has."


def comparison_figure(problem: str, runs: pd.DataFrame) -> Figure:
    """The figure of errors against times on one problem; its title says who is fastest where."""
    quantity = str(runs["quantity"].iloc[0])
    rankings = summary_sentences(matched(runs))
    return Figure(
        name=slug(problem),
        title=rankings[0].rstrip(".")
        if rankings
        else f"{label_of(problem).title}: error against time",
        draw=work_precision,
        options={"ylabel": error_label(problem, quantity)},
        caption=f"{ERROR_MEASURES[quantity]}, or that of the next finer setting where it is "
        "larger. The "
        "fronts: settings that no other of the code beats in both; of galvi one line for each "
        "degree, whatever points and chart, darker with the degree. All points are of the same "
        "rounds, in which all settings took turns; bars: the fastest and the slowest round. "
        f"{_caption_of_runs(runs)} {MISSING_FEATURES.get(quantity, MISSING_BODY_FEATURES)}".replace(
            "  ", " "
        ),
        size=(6.4, 4.8),
    )


def _caption_of_runs(runs: pd.DataFrame) -> str:
    """Caption sentences on features that only some of these figures show."""
    measured = runs[(runs["error"] > 0) & (runs["seconds"] > 0)]
    names = list(measured["contender"].unique())
    sentences = {
        "An open mark with an arrow: a bound, ten times the truth's own error.": bool(
            measured["error_is_bound"].any()
        ),
        "Dotted stars and crosses: 2 passes of the iteration.": any(
            is_galvi(name) and "passes" in name for name in names
        ),
        'The general kernel is galvi\'s with solver="newton".': any(
            name.endswith("general kernel") for name in names
        ),
        "heyoka without its compact mode.": not set(FAST_HEYOKA).isdisjoint(names),
        "The dotted vertical line marks the time of the run that is the reference.": bool(
            (runs["is_truth"] & (runs["seconds"] > 0)).any()
        ),
    }
    return " ".join(sentence for sentence, holds in sentences.items() if holds)


def draw(
    checked: Sequence[ClaimResult],
    comparison: Comparison,
    sections: Sequence[SectionResult] = (),
    map_figures: Callable[[Callable[[Any], Any], Sequence[Any]], Iterable[Any]] = map,
) -> Gallery:
    """Draw the figures of the claims, of the studies, and of each compared problem.

    Parameters
    ----------
    map_figures
        map, or its equivalent in several processes
    """
    figures_and_tables = list(drawable(checked, comparison, sections))
    measured = [(figure, table) for figure, table in figures_and_tables if table is not None]
    pictures = {figure.name: "what it shows was not run." for figure, _ in figures_and_tables}
    pictures |= zip(
        (figure.name for figure, _ in measured),
        map_figures(_draw_or_explain, measured),
        strict=True,
    )
    return Gallery(
        {name: drawn for name, drawn in pictures.items() if isinstance(drawn, Picture)},
        {
            figure.name: f"{figure.source or figure.title} is not drawn: {pictures[figure.name]}"
            for figure, _ in figures_and_tables
            if isinstance(pictures[figure.name], str)
        },
    )


def drawable(
    checked: Sequence[ClaimResult],
    comparison: Comparison,
    sections: Sequence[SectionResult] = (),
) -> Iterator[tuple[Figure, pd.DataFrame | None]]:
    """Every figure with the table that it is drawn from, None if that was not measured."""
    for figure in FIGURES:
        source = first_measured(checked, figure.claims)
        yield figure, None if source is None else source.table
    table = comparison.work_precision
    if table is not None:
        for problem, runs in table.groupby("problem", sort=False):
            yield comparison_figure(str(problem), runs), runs
    for headline in (*HEADLINES, *PROFILES):
        yield headline, table
    for section_result in sections:
        for figure in section_result.section.figures:
            yield figure, section_result.table


def save(gallery: Gallery, folder: Path) -> None:
    """Write the files of all pictures, and remove the earlier files of figures that are missing."""
    for drawn in gallery.pictures.values():
        write_files(drawn, folder)
    for name in gallery.missing:
        for suffix in SUFFIXES:
            (folder / f"{name}{suffix}").unlink(missing_ok=True)


def _draw_or_explain(job: tuple[Figure, pd.DataFrame]) -> Picture | str:
    """The picture of a (figure, table), or the message of the exception that drawing it raised."""
    try:
        return picture(*job)
    except Exception as error:
        return str(error) or type(error).__name__
