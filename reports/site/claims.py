"""The claims for their page: under the headings of their documents, with figures and checks.

Text that all rows of a claim share is shown once.
"""

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
ABBREVIATED_FIELDS = (
    "setup",
    "reason",
    "reference",
)  # fields that refer to the previous row's by AS_ABOVE
AS_ABOVE = "as above"
# Characters from which a common beginning of two texts is replaced by AS_ABOVE:
MIN_REPEATED_LENGTH = 40


@dataclass(frozen=True)
class ClaimSection:
    """The data of a claim for the template.

    Attributes
    ----------
    headings
        headings of the texts that differ between rows
    checks
        each row, with its texts under these headings
    shared
        (heading, text) of the texts that are common to all rows
    undrawn
        a sentence for each missing picture
    seconds
        run time of its study when it was last measured
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
        """The distinct verdicts of its rows, in the order of VERDICTS."""
        return tuple(word for word, _ in self.counts)

    @property
    def counts(self) -> tuple[tuple[str, int], ...]:
        """(verdict, number of rows), in the order of VERDICTS."""
        by_verdict = Counter(row.verdict for row, _ in self.checks)
        return tuple((word, by_verdict[word]) for word in VERDICTS if by_verdict[word])

    @property
    def tolerances(self) -> tuple[str, ...]:
        """The distinct bounds of its rows."""
        return tuple(dict.fromkeys(row.bound for row, _ in self.checks if row.bound))

    @property
    def command(self) -> str:
        """The command that checks this claim again."""
        is_external = self.claim.id.startswith(CONTENDER_PREFIX)
        option = " --contender package.module:Class" if is_external else ""
        return f"galvi verify --claims {self.claim.id}{option}"


def claim_section(claim_result: ClaimResult, gallery: Gallery) -> ClaimSection:
    """The section of a claim, with the pictures that are drawn from its table or that it names."""
    names = [
        figure.name
        for figure in FIGURES
        if claim_result.claim.id in figure.claims or figure.source in claim_result.claim.figures
    ]
    shared, columns = {}, {}
    for name, heading in HEADINGS.items():
        same, texts = shared_parts([getattr(row, name) for row in claim_result.rows])
        if name in ABBREVIATED_FIELDS:
            texts = [without_repetition(*pair) for pair in zip(texts, ["", *texts], strict=False)]
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


def without_repetition(text: str, last: str) -> str:
    """The text for the row after `last`, with AS_ABOVE in place of their common beginning.

    Only whole parts between semicolons are replaced. A common beginning of fewer than
    MIN_REPEATED_LENGTH characters is kept, unless the texts are equal.
    """
    parts, last_parts = text.split("; "), last.split("; ")
    equal_count = len(
        list(takewhile(lambda pair: pair[0] == pair[1], zip(parts, last_parts, strict=False)))
    )
    if text != last and len("; ".join(parts[:equal_count])) < MIN_REPEATED_LENGTH:
        return text
    return "; ".join([AS_ABOVE, *parts[equal_count:]]) if text else ""


def shared_parts(texts: Sequence[str]) -> tuple[str, list[str]]:
    """The semicolon-separated parts that all texts share, and the remainder of each text."""
    parts = [text.split("; ") for text in texts]
    common_parts = (
        [part for part in parts[0] if all(part in text_parts for text_parts in parts)]
        if parts
        else []
    )
    remainders = [
        "; ".join(part for part in text_parts if part not in common_parts) for text_parts in parts
    ]
    return "; ".join(common_parts), remainders


EXTERNAL_HEADINGS = "Claims of external integrators", "Their agreement with the truth"


@dataclass(frozen=True)
class ClaimGroup:
    """The claims under a heading of a document.

    Attributes
    ----------
    document
        the document's title if this is its first heading that is shown, else ""
    statements
        the statements that the paper prints there
    """

    document: str
    title: str
    text: str
    statements: tuple[Statement, ...]
    claims: tuple[ClaimSection, ...]


def paper_of(title: str) -> str:
    """The letter of a document's paper and a space: "H " for "H, chapter 1"; "" for others."""
    return f"{title[0]} " if title[1:2] in (",", ":") else ""


def claim_groups(sections: Sequence[ClaimSection]) -> list[ClaimGroup]:
    """The claims, each under the heading of its document; claims of no document come last.

    Headings without a claim are left out; if all claims are there, those with statements are kept.
    """
    by_id = {section.claim.id: section for section in sections}
    documented_ids = [
        entry.id
        for document in all_documents()
        for part in document.parts
        for entry in part.sections
    ]
    complete = by_id.keys() >= set(documented_ids)
    groups = []
    for document in all_documents():
        title = document.title
        for part in document.parts:
            claims = [by_id[entry.id] for entry in part.sections if entry.id in by_id]
            if claims or (complete and part.statements):
                heading = f"{paper_of(document.title)}{part.title}"
                part_statements = tuple(statements_of(part))
                groups.append(ClaimGroup(title, heading, part.text, part_statements, tuple(claims)))
                title = ""
    external = tuple(section for id, section in by_id.items() if id not in documented_ids)
    if external:
        groups.append(ClaimGroup(*EXTERNAL_HEADINGS, "", (), external))
    return groups
