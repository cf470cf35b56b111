"""`build`: verify, compare, study, draw, and write the page."""

from __future__ import annotations

from reports.atomic import write
from reports.compare import Compared, compare
from reports.drawing import draw, save
from reports.order import Order
from reports.origins import note_origin
from reports.page.content import content
from reports.page.render import render
from reports.studied import Studied, study_all
from reports.suite import Suite
from reports.verify import Verified, verify


def build(suite: Suite, order: Order) -> tuple[Verified, Compared, list[Studied]]:
    """Everything, anew, beside the stored rows of long studies, which say when they were made."""
    verified = verify(suite, order)
    checked = verified.checked
    compared = compare(suite, order)
    studied = study_all(suite, order)
    gallery = draw(checked, compared, studied)
    save(gallery, order.out / "figures")
    provenance = dict(suite.provenance(order.command))
    page = render(content(checked, compared, studied, gallery, suite.claims, provenance, order))
    write(order.out / "index.html", page)
    note_origin(order.out, "index.html", provenance, order.quick)
    print(f"The page is {order.out / 'index.html'}.")
    return verified, compared, studied
