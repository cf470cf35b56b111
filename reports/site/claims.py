"""The claims as the page shows them: under the headings of their documents, each with its figures,
set-up and checks; text that all rows of a claim share appears once."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import takewhile

from benchmarks.checks.bounds import VERDICTS
from benchmarks.checks.claim import Claim, Row
from benchmarks.claims.documents import all_documents
from benchmarks.claims.statements import Statement, statements_of
from reports.figures.catalogue.all import FIGURES
from reports.figures.drawing import Gallery
from reports.figures.picture import Picture
from reports.results.claim_results import ClaimResult
from reports.results.options import CONTENDER_PREFIX

HEADINGS = {
    "claimed": "claimed",
    "bound": "bound",
    "setup": "set-up",
    "reason": "reason",
    "reference": "reference",
    "source": "source",
}
AGAIN = ("setup", "reason", "reference")  # "as above" where a row repeats the last one's
AS_ABOVE, LONG = "as above", 40  # shorter beginnings are repeated


@dataclass(frozen=True)
class ClaimSection:
    """The data of a claim for the template.

    Attributes
    ----------
    headings
        of the texts that differ between rows
    checks
        each row with its texts under these headings
    shared
        (heading, text) common to all rows
    undrawn
        a sentence for each missing picture
    seconds
        of its study, when it was last measured
    """

    claim: Claim
    headings: tuple[str, ...]
    checks: tuple[tuple[Row, tuple[str, ...]], ...]
    shared: tuple[tuple[str, str], ...]
    seconds: float
    pictures: tuple[Picture, ...]
    undrawn: tuple[str, ...]

    @property
    def verdicts(self) -> tuple[str, ...]:
        """Each verdict of its rows, once."""
        return tuple(word for word, _ in self.counts)

    @property
    def counts(self) -> tuple[tuple[str, int], ...]:
        """(verdict, number of rows), in the order of VERDICTS."""
        by_verdict = Counter(row.verdict for row, _ in self.checks)
        return tuple((word, by_verdict[word]) for word in VERDICTS if by_verdict[word])

    @property
    def tolerances(self) -> tuple[str, ...]:
        """The bounds of its rows, each once."""
        return tuple(dict.fromkeys(row.bound for row, _ in self.checks if row.bound))

    @property
    def command(self) -> str:
        """The command that repeats it."""
        of_contender = self.claim.id.startswith(CONTENDER_PREFIX)
        option = " --contender package.module:Class" if of_contender else ""
        return f"galvi verify --claims {self.claim.id}{option}"


def claim_section(claim_result: ClaimResult, gallery: Gallery) -> ClaimSection:
    """The section of a claim, with the pictures drawn from it or named by it."""
    names = [
        figure.name
        for figure in FIGURES
        if claim_result.claim.id in figure.claims or figure.source in claim_result.claim.figures
    ]
    shared, columns = {}, {}
    for name, heading in HEADINGS.items():
        same, texts = shared_parts([getattr(row, name) for row in claim_result.rows])
        if name in AGAIN:
            texts = [after(*pair) for pair in zip(texts, ["", *texts], strict=False)]
        shared |= {heading: same} if same else {}
        columns |= {heading: texts} if any(texts) else {}
    return ClaimSection(
        claim=claim_result.claim,
        headings=tuple(columns),
        checks=tuple(
            (row, tuple(texts[k] for texts in columns.values()))
            for k, row in enumerate(claim_result.rows)
        ),
        shared=tuple(shared.items()),
        seconds=claim_result.seconds,
        pictures=tuple(gallery.pictures[name] for name in names if name in gallery.pictures),
        undrawn=tuple(gallery.missing[name] for name in names if name in gallery.missing),
    )


def after(text: str, last: str) -> str:
    """The text below the last one, whose semicolon-separated beginning it does not repeat."""
    parts, before = text.split("; "), last.split("; ")
    same = len(list(takewhile(lambda pair: pair[0] == pair[1], zip(parts, before, strict=False))))
    if text != last and len("; ".join(parts[:same])) < LONG:
        return text
    return "; ".join([AS_ABOVE, *parts[same:]]) if text else ""


def shared_parts(texts: Sequence[str]) -> tuple[str, list[str]]:
    """The semicolon-separated parts that all texts share, and the remainder of each text."""
    parts = [text.split("; ") for text in texts]
    same = (
        [part for part in parts[0] if all(part in text_parts for text_parts in parts)]
        if parts
        else []
    )
    remainders = [
        "; ".join(part for part in text_parts if part not in same) for text_parts in parts
    ]
    return "; ".join(same), remainders


EXTERNAL = "Claims of external integrators", "Their agreement with the truth"


@dataclass(frozen=True)
class ClaimGroup:
    """What stands under a heading of a document.

    Attributes
    ----------
    document
        its title where this is its first heading, else ""
    statements
        what the paper prints there
    """

    document: str
    title: str
    text: str
    statements: tuple[Statement, ...]
    claims: tuple[ClaimSection, ...]


def paper_of(title: str) -> str:
    """The paper's letter and a space, of a document on a paper: "H, chapter 1" is on H."""
    return f"{title[0]} " if title[1:2] in (",", ":") else ""


def claim_groups(sections: Sequence[ClaimSection]) -> list[ClaimGroup]:
    """Every claim once, under the heading of its document; those of no document last.

    Headings without a claim among these are left out, unless these are all claims.
    """
    by_id = {section.claim.id: section for section in sections}
    documented = [
        entry.id
        for document in all_documents()
        for part in document.parts
        for entry in part.sections
    ]
    complete = by_id.keys() >= set(documented)
    groups = []
    for document in all_documents():
        title = document.title
        for part in document.parts:
            claims = [by_id[entry.id] for entry in part.sections if entry.id in by_id]
            if claims or (complete and part.statements):
                heading = f"{paper_of(document.title)}{part.title}"
                printed = tuple(statements_of(part))
                groups.append(ClaimGroup(title, heading, part.text, printed, tuple(claims)))
                title = ""
    external = tuple(section for id, section in by_id.items() if id not in documented)
    if external:
        groups.append(ClaimGroup(*EXTERNAL, "", (), external))
    return groups
