"""Which build an order asks for, and what is there of it when it did not come to its end."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Iterator
from importlib.machinery import PathFinder
from pathlib import Path

from benchmarks.timings.unfinished import Unfinished, state_of_sources
from reports.compare import titles
from reports.order import Order
from reports.parts import Parts
from reports.suite import Suite

CHANGING = ("date", "command")  # of a provenance: from one run of the same build to the next
CODE = ("reports",)  # besides that of the sources


def parts_of(suite: Suite, order: Order) -> Parts:
    """The parts of the build that is ordered, with those that an earlier run of it left.

    It is the same build when the commit, the sources as they lie there, the data they read, the
    versions, the machine, the setting, the claims, and the contenders with their files are the
    same. What a contender's own file or package imports from elsewhere is not looked at.
    """
    planned = (*order.claims, *titles(suite, order.quick), *(one.title for one in suite.studies))
    begun = suite.provenance(order.command).get("date", "")
    store = Unfinished(order.out, _key(suite, order))
    parts = Parts(store, begun, suite.faults, planned, suite.ahead)
    if order.anew:
        parts.forget()
    parts.take_up()
    return parts


def _key(suite: Suite, order: Order) -> str:
    told = suite.provenance(order.command)
    same = {name: text for name, text in told.items() if name not in CHANGING}
    asked = [order.quick, order.claims, [(path, _digest(path)) for path in order.contenders]]
    words = json.dumps([state_of_sources(CODE), same, asked], sort_keys=True)
    return hashlib.sha256(words.encode()).hexdigest()[:16]


def _digest(contender: str) -> str:
    """Of the file, or the package, that "package.module:Class" begins with, not imported."""
    digest = hashlib.sha256()
    for path in sorted(_files(contender.partition(":")[0].partition(".")[0])):
        digest.update(str(path).encode() + b"\0" + path.read_bytes())
    return digest.hexdigest()


def _files(module: str) -> Iterator[Path]:
    spec = PathFinder.find_spec(module)
    if spec is None:
        return
    if spec.submodule_search_locations is not None:
        for folder in spec.submodule_search_locations:
            yield from Path(folder).rglob("*.py")
    elif spec.origin is not None and Path(spec.origin).is_file():
        yield Path(spec.origin)
