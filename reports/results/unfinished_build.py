"""Which build an order asks for, and what is there of it when it did not come to its end."""

from __future__ import annotations

import hashlib
import json
import sys
from collections.abc import Mapping

from benchmarks.external.code_digest import digest, installed
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
    versions, the machine, the setting, the claims, and the contenders with what they are made of
    (`benchmarks.external.code_digest`) are the same. Where that cannot be told of a contender,
    nothing is kept or taken up.
    """
    planned = (*order.claims, *titles(suite, order.quick), *(one.title for one in suite.studies))
    begun = suite.provenance(order.command).get("date", "")
    before = _states(suite)
    unknown = [path for path in order.contenders if path not in before]
    if unknown:
        print(
            f"Nothing is kept for a build that goes on: it cannot be told from which files "
            f"{' and '.join(unknown)} came.",
            file=sys.stderr,
        )
    store = None if unknown else Unfinished(order.out, _key(suite, order, before))

    def changed() -> list[str]:
        now = _states(suite)
        return [name for name, state in before.items() if now.get(name) != state]

    parts = Parts(store, begun, suite.faults, planned, suite.ahead, changed)
    if order.anew:
        parts.forget()
    parts.take_up()
    return parts


def _states(suite: Suite) -> dict[str, str]:
    """Digests, as of now, of our sources, and of what each contender is made of."""
    made = {path: digest(places) for path, places in suite.made_of().items() if places}
    return {OURS: digest_of_sources(CODE), **made}


def _key(suite: Suite, order: Order, states: Mapping[str, str]) -> str:
    told = suite.provenance(order.command)
    same = {name: text for name, text in told.items() if name not in CHANGING}
    more = installed() if order.contenders else []
    words = json.dumps([dict(states), same, order.quick, order.claims, more], sort_keys=True)
    return hashlib.sha256(words.encode()).hexdigest()[:16]
