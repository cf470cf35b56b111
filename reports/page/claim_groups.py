"""The claims under the headings of their documents, in the order of the page."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from benchmarks.claims.documents import all_documents
from benchmarks.claims.statements import Statement, statements_of
from reports.page.claim_section import ClaimSection

REST = "Claims of external integrators"


@dataclass(frozen=True)
class ClaimGroup:
    """What stands under a heading of a document.

    document    its title where this is its first heading, else ""
    statements  what the paper prints there
    """

    anchor: str
    document: str
    title: str
    text: str
    statements: tuple[Statement, ...]
    claims: tuple[ClaimSection, ...]


def paper_of(title: str) -> str:
    """Of a document on a paper its letter and a space: "H, chapter 1" is on H."""
    return f"{title[0]} " if title[1:2] in (",", ":") else ""


def claim_groups(claims: Sequence[ClaimSection]) -> list[ClaimGroup]:
    """Every claim once, under the heading of its document; those of no document last.

    Headings without a claim among these are left out, unless these are all claims.
    """
    known = {section.claim.id: section for section in claims}
    every = {
        section.id
        for document in all_documents()
        for part in document.parts
        for section in part.sections
    }
    complete = every <= known.keys()
    groups = []
    for number, document in enumerate(all_documents()):
        title = document.title
        for place, part in enumerate(document.parts):
            own = [known.pop(each.id) for each in part.sections if each.id in known]
            if own or (complete and part.statements):
                anchor = f"part-{number + 1}-{place + 1}"
                name = f"{paper_of(document.title)}{part.title}"
                printed = tuple(statements_of(part))
                groups.append(ClaimGroup(anchor, title, name, part.text, printed, tuple(own)))
                title = ""
    if known:
        groups.append(ClaimGroup("part-rest", "", REST, "", (), tuple(known.values())))
    return groups
