"""`build`: verify, compare, study, draw, and write the page."""

from __future__ import annotations

import sys
from dataclasses import replace

from reports.build.lock import alone
from reports.build.verify import Verified, verify
from reports.cli.options import Order
from reports.figures.drawing import draw, save
from reports.page.content import content
from reports.page.render import render
from reports.results.atomic import write
from reports.results.cache import Parts
from reports.results.comparison import Compared, compare
from reports.results.origins import note_origin
from reports.results.study_result import StudyResult, study_all
from reports.results.suite import Suite
from reports.results.unfinished_build import parts_of


def build(suite: Suite, order: Order) -> tuple[Verified, Compared, list[StudyResult]]:
    """Everything, anew, beside the stored rows of long studies, which say when they were made.

    A build of the same sources and settings that did not come to its end is gone on with: its
    finished parts are taken up, and the provenance says so, as it does when sources change while
    they are measured.
    """
    with alone(order.out):
        parts = parts_of(suite, order)
        if parts.taken:
            print(parts.greeting(), flush=True)
        origin = parts.origin()

        def provenance(command: str) -> dict[str, str]:
            return {**suite.provenance(command), **origin, **parts.changes()}

        try:
            found = _build(replace(suite, provenance=provenance), order, parts)
        except KeyboardInterrupt:
            if parts.store is not None:
                print(
                    "What was measured is kept: the same command goes on from there.",
                    file=sys.stderr,
                )
            raise
        parts.forget()
    return found


def _build(
    suite: Suite, order: Order, parts: Parts
) -> tuple[Verified, Compared, list[StudyResult]]:
    verified = verify(suite, order, parts)
    checked = verified.checked
    compared = compare(suite, order, parts)
    studied = study_all(suite, order, parts)
    parts.look()
    gallery = draw(checked, compared, studied)
    save(gallery, order.out / "figures")
    provenance = dict(suite.provenance(order.command))
    page = render(content(checked, compared, studied, gallery, suite.claims, provenance, order))
    write(order.out / "index.html", page)
    note_origin(order.out, "index.html", provenance, order.quick)
    for text in parts.changes().values():
        print(f"Changed: {text}.", file=sys.stderr)
    print(f"The page is {order.out / 'index.html'}.")
    return verified, compared, studied
