"""Draw every figure of the report, with a sentence for each that could not be drawn."""

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
from reports.figures.picture import Picture, picture, slug, write_files
from reports.figures.profiles import PROFILES
from reports.figures.style.chart_lines import LEGEND as CHART_LINES
from reports.figures.style.chart_lines import chart_of
from reports.figures.style.decades import error_label
from reports.figures.work_precision import FEWER, shown, step_cost, work_precision
from reports.results.claim_results import ClaimResult, first_measured
from reports.results.comparison import Comparison
from reports.results.section import Figure
from reports.results.section_result import SectionResult
from reports.tables.comparison_tables import is_ours
from reports.tables.number_format import capital


@dataclass(frozen=True, eq=False)
class Gallery:
    """Pictures by the name of their figure, and the reasons why others are missing."""

    pictures: dict[str, Picture]
    missing: dict[str, str]


UNITS = {
    POSITION: "Largest distance of a body from its true position",
    ATTITUDE: "Largest entry of R - R_true",
    COORDINATES: "Largest difference of a coordinate",
    MOTION: "Largest difference of an entry of the attitude, of the place or of a hinge's angle",
    ANGLE: "Largest of the links' angles, in radians",
}


NOT_COMPACT = ("heyoka, chains", "heyoka, Lagrangians")


def comparison_figure(problem: str, runs: pd.DataFrame) -> Figure:
    """Errors against times on one problem."""
    quantity = str(runs["quantity"].iloc[0])
    return Figure(
        name=slug(problem),
        title=f"{label_of(problem).title}: error against time",
        draw=work_precision,
        options={"ylabel": error_label(problem, quantity)},
        caption=f"{UNITS[quantity]}. Medians, with the fastest and the slowest round. "
        "Blue: galvi, darker with the degree; hollow: dominated by another run of the same "
        f"contender; broken lines: other codes. {_of_drawn(runs)}".rstrip(),
        size=(6.4, 4.8),
    )


def _of_drawn(runs: pd.DataFrame) -> str:
    """Sentences of the caption on what not every such figure shows."""
    measured = runs[(runs["error"] > 0) & (runs["seconds"] > 0)]
    names = list(dict.fromkeys(measured["contender"]))
    ours = [name for name in names if is_ours(name)]
    said = {
        f"{capital(CHART_LINES)}.": len({chart_of(name) for name in ours}) > 1,
        FEWER: len(shown(measured)) < len(names),
        "Dotted stars and crosses: 2 passes of the iteration.": any("passes" in n for n in ours),
        'The general kernel is galvi\'s with solver="newton".': any(
            name.endswith("general kernel") for name in ours
        ),
        "heyoka without its compact mode.": any(name in NOT_COMPACT for name in names),
        "The dotted vertical line marks the time of the run that is the reference.": bool(
            ((runs["status"] == "truth") & (runs["seconds"] > 0)).any()
        ),
    }
    return " ".join(sentence for sentence, so in said.items() if so)


COST_FIGURE = Figure(
    name="step-cost",
    title="Time for one step",
    draw=step_cost,
    caption="galvi's methods, at the step sizes they are intended for.",
    size=(6.4, 4.6),
)


def draw(
    checked: Sequence[ClaimResult],
    comparison: Comparison,
    sections: Sequence[SectionResult] = (),
    each: Callable[[Callable[[Any], Any], Sequence[Any]], Iterable[Any]] = map,
) -> Gallery:
    """Draw the figures of the claims, of the studies, of each compared problem, and of the cost.

    each  map, or one that does the same in several processes
    """
    wanted = list(drawable(checked, comparison, sections))
    known = [(figure, frame) for figure, frame in wanted if frame is not None]
    found = dict(zip((figure.name for figure, _ in known), each(_drawn, known), strict=True))
    gallery = Gallery({}, {})
    for figure, _ in wanted:
        drawn = found.get(figure.name, "what it shows was not run.")
        if isinstance(drawn, Picture):
            gallery.pictures[figure.name] = drawn
        else:
            gallery.missing[figure.name] = f"{figure.source or figure.title} is not drawn: {drawn}"
    return gallery


def drawable(
    checked: Sequence[ClaimResult],
    comparison: Comparison,
    sections: Sequence[SectionResult] = (),
) -> Iterator[tuple[Figure, pd.DataFrame | None]]:
    """Every figure with the frame it is drawn from; None where that was not measured."""
    for figure in FIGURES:
        source = first_measured(checked, figure.claims)
        yield figure, None if source is None else source.frame
    table = comparison.work_precision
    if table is not None:
        for problem, runs in table.groupby("problem", sort=False):
            yield comparison_figure(str(problem), runs), runs
    for headline in (*HEADLINES, *PROFILES):
        yield headline, table
    yield COST_FIGURE, comparison.cost
    for one in sections:
        for figure in one.section.figures:
            yield figure, one.frame


def save(gallery: Gallery, folder: Path) -> None:
    """Write NAME.svg, NAME.png and NAME-narrow.svg, and remove the earlier files of figures that
    are missing now."""
    for one in gallery.pictures.values():
        write_files(one, folder)
    for name in gallery.missing:
        for end in (".svg", ".png", "-narrow.svg"):
            (folder / f"{name}{end}").unlink(missing_ok=True)


def _drawn(job: tuple[Figure, pd.DataFrame]) -> Picture | str:
    """The picture, or why there is none."""
    try:
        return picture(*job)
    except Exception as error:
        return str(error) or type(error).__name__
