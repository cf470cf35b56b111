"""A claim's section of the page: pictures beside rows; text shared by all rows appears once."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from benchmarks.checks.claim import Claim, Row
from reports.figures.catalogue.all import FIGURES
from reports.figures.drawing import Gallery
from reports.figures.picture import Picture
from reports.results.claim_results import ClaimResult

HEADINGS = {
    "claimed": "claimed",
    "bound": "bound",
    "setup": "set-up",
    "reference": "reference",
    "source": "source",
}
MANY = 6  # rows from which they are a table below the pictures


@dataclass(frozen=True)
class ClaimSection:
    """The data of a claim for the template.

    headings  of the texts that differ between rows
    checks    each row with its texts under these headings
    shared    (heading, text) common to all rows
    undrawn   a sentence for each missing picture
    many      whether the rows are a table below the pictures
    """

    claim: Claim
    headings: tuple[str, ...]
    checks: tuple[tuple[Row, tuple[str, ...]], ...]
    shared: tuple[tuple[str, str], ...]
    seconds: float
    pictures: tuple[Picture, ...]
    undrawn: tuple[str, ...]
    many: bool


def claim_section(one: ClaimResult, gallery: Gallery) -> ClaimSection:
    """The section of a claim, with the pictures drawn from it or named by it."""
    names = [
        figure.name
        for figure in FIGURES
        if one.claim.id in figure.claims or figure.source in one.claim.figures
    ]
    shared, own = {}, {}
    for name, heading in HEADINGS.items():
        same, texts = shared_parts([getattr(row, name) for row in one.rows])
        shared |= {heading: same} if same else {}
        own |= {heading: texts} if any(texts) else {}
    return ClaimSection(
        claim=one.claim,
        headings=tuple(own),
        checks=tuple(
            (row, tuple(texts[k] for texts in own.values())) for k, row in enumerate(one.rows)
        ),
        shared=tuple(shared.items()),
        seconds=one.seconds,
        pictures=tuple(gallery.pictures[name] for name in names if name in gallery.pictures),
        undrawn=tuple(gallery.missing[name] for name in names if name in gallery.missing),
        many=len(one.rows) >= MANY,
    )


def reasons(rows: Sequence[Row]) -> list[tuple[Row, int]]:
    """Each row with the number of lines its reason spans; 0 where a row above states it."""
    spans: list[int] = []
    start = 0
    for k, row in enumerate(rows):
        if k and (row.id, row.reason) == (rows[start].id, rows[start].reason):
            spans.append(0)
            spans[start] += 1
        else:
            spans.append(1)
            start = k
    return list(zip(rows, spans, strict=True))


def shared_parts(texts: Sequence[str]) -> tuple[str, list[str]]:
    """The semicolon-separated parts that all texts share, and the remainder of each text."""
    parts = [text.split("; ") for text in texts]
    same = [part for part in parts[0] if all(part in other for other in parts)] if parts else []
    rest = ["; ".join(part for part in one if part not in same) for one in parts]
    return "; ".join(same), rest
