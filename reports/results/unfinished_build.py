"""Which build an order asks for, and what is there of it when it did not come to its end."""

from __future__ import annotations

import hashlib
import json

from benchmarks.timings.unfinished import Unfinished, digest_of_sources
from reports.cli.options import Order
from reports.results.cache import Parts
from reports.results.comparison import titles
from reports.results.suite import Suite

CHANGING = ("date", "command")  # of a provenance: from one run of the same build to the next
CODE = ("reports",)  # besides that of the sources
OURS = "the suite's sources"


def parts_of(suite: Suite, order: Order) -> Parts:
    """The parts of the build that is ordered, with those that an earlier run of it left.

    It is the same build when the commit, the sources as they lie there, the data they read, the
    versions, the machine, the setting and the claims are the same. With external integrators,
    whose code may change unseen, nothing is kept or taken up.
    """
    planned = (*order.claims, *titles(suite, order.quick), *(one.title for one in suite.studies))
    begun = suite.provenance(order.command).get("date", "")
    before = digest_of_sources(CODE)
    store = None if order.contenders else Unfinished(order.out, _key(suite, order, before))

    def changed() -> list[str]:
        return [] if digest_of_sources(CODE) == before else [OURS]

    parts = Parts(store, begun, suite.faults, planned, suite.ahead, changed)
    if order.anew:
        parts.forget()
    parts.take_up()
    return parts


def _key(suite: Suite, order: Order, sources: str) -> str:
    told = suite.provenance(order.command)
    same = {name: text for name, text in told.items() if name not in CHANGING}
    words = json.dumps([sources, same, order.quick, order.claims], sort_keys=True)
    return hashlib.sha256(words.encode()).hexdigest()[:16]
