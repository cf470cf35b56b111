"""`build`: verify, compare, study, draw, and write the page."""

from __future__ import annotations

import sys
from dataclasses import replace

from reports.alone import alone
from reports.atomic import write
from reports.compare import Compared, compare
from reports.drawing import draw, save
from reports.order import Order
from reports.origins import note_origin
from reports.page.content import content
from reports.page.render import render
from reports.parts import Parts
from reports.studied import Studied, study_all
from reports.suite import Suite
from reports.unfinished_build import parts_of
from reports.verify import Verified, verify


def build(suite: Suite, order: Order) -> tuple[Verified, Compared, list[Studied]]:
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
            print(
                "What was measured is kept: the same command goes on from there.", file=sys.stderr
            )
            raise
        parts.forget()
    return found


def _build(suite: Suite, order: Order, parts: Parts) -> tuple[Verified, Compared, list[Studied]]:
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
