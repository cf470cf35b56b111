"""The facts on each family of integrators for the page of compared integrators.

They are taken from the comparisons or, with their source, from ``docs/peers.csv``: what an
integrator is, what it conserves, its defects, and its documentation.
"""

from __future__ import annotations

import csv
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import cache
from typing import Any

from benchmarks.claims.agreements import WithGalvi
from benchmarks.claims.documents import all_documents, measuring_object
from benchmarks.store.provenance import ROOT, versions
from benchmarks.work_precision.labels import label_of
from benchmarks.work_precision.problem import Participant, Setting
from benchmarks.work_precision.problems import work_precision_problems
from reports.figures.style.identities import identity

FACTS_FILE = ROOT / "docs" / "peers.csv"
PACKAGES = {"REBOUND": "rebound", "MuJoCo": "mujoco-core", "heyoka": "heyoka", "SciPy": "scipy"}
HIDDEN_KEYS = ("save_every", "samples")


@dataclass(frozen=True, eq=False)
class Peer:
    """A family of contenders.

    Attributes
    ----------
    facts
        its line of ``docs/peers.csv``
    orders
        orders of convergence of the contenders that state them
    runs
        problem -> its participants on this problem
    """

    facts: Mapping[str, str]
    orders: set[int] = field(default_factory=set)
    runs: dict[str, list[Participant]] = field(default_factory=dict)

    @property
    def family(self) -> str:
        """The name in figures and tables."""
        return self.facts["family"]

    @property
    def anchor(self) -> str:
        """The id of its heading on the page."""
        return "peer-" + re.sub(r"[^a-z0-9]+", "-", self.family.lower()).strip("-")

    @property
    def order(self) -> str:
        """The orders of convergence as in ``docs/peers.csv``, or from `orders`, e.g. "4 to 32"."""
        extremes = dict.fromkeys((min(self.orders), max(self.orders))) if self.orders else ()
        return self.facts["order"] or " to ".join(map(str, extremes))

    @property
    def package(self) -> str:
        """The package with its installed version; "this repository" without a package."""
        name = PACKAGES.get(self.family.split()[0])
        return f"{name} {versions()[name]}" if name else "this repository"

    @property
    def steps(self) -> str:
        """Kinds of steps: "equal", "adaptive" or both."""
        settings = (
            setting
            for participants in self.runs.values()
            for participant in participants
            for setting in participant.settings
        )
        return " and ".join(
            sorted({"equal" if "step" in setting else "adaptive" for setting in settings})
        )

    @property
    def agreements(self) -> list[str]:
        """Ids of the agreements with galvi that its contenders take part in."""
        names = {
            participant.contender.name
            for participants in self.runs.values()
            for participant in participants
        }
        return [
            section.id
            for part in all_documents()[-1].parts
            for section in part.sections
            for pair in measuring_object(section).pairs
            if isinstance(pair, WithGalvi) and pair.contender.name in names
        ]

    def settings(self, problem: str) -> list[str]:
        """Each participant's settings on a problem, e.g. "best: 5 settings: step 361 to 1083 d"."""
        unit = label_of(problem).time
        return [
            f"{self._short(participant)}{_settings(participant.settings, unit)}"
            for participant in self.runs[problem]
        ]

    def _short(self, participant: Participant) -> str:
        """The participant's label without the family, and a colon; "" where that is empty."""
        label = participant.label.removeprefix(self.family).lstrip(" ,")
        return f"{label}: " if label else ""


@cache
def peers() -> tuple[Peer, ...]:
    """The families in ``docs/peers.csv``, with their participants.

    Raises KeyError for a participant whose family has no line there.
    """
    with FACTS_FILE.open(encoding="utf-8", newline="") as file:
        by_family = {line["family"]: Peer(line) for line in csv.DictReader(file)}
    for case in work_precision_problems(quick=False):
        for participant in case.participants:
            peer = by_family[identity(participant.label).family]
            peer.runs.setdefault(case.problem.name, []).append(participant)
            order = getattr(
                getattr(participant.contender, "method", participant.contender), "order", None
            )
            peer.orders.update(() if order is None else (order,))
    return tuple(by_family.values())


def _settings(settings: Sequence[Setting], unit: str) -> str:
    """E.g. "5 settings: step 361 to 1083 d, corrector 17"."""
    keys = dict.fromkeys(key for setting in settings for key in setting if key not in HIDDEN_KEYS)
    varied = ", ".join(_values(key, settings, unit) for key in keys)
    count = f"{len(settings)} setting{'s' if len(settings) > 1 else ''}"
    return f"{count}: {varied}" if varied else count


def _number(value: float) -> str:
    return f"{value:.0f}" if 1000.0 <= value < 1e6 else f"{value:.3g}"


def _values(key: str, settings: Sequence[Setting], unit: str) -> str:
    values: list[Any] = list(dict.fromkeys(setting.get(key, "default") for setting in settings))
    numbers = [value for value in values if isinstance(value, float)]
    texts = [str(value) for value in values if not isinstance(value, float)]
    if len(numbers) > 2:
        shown = [f"{_number(min(numbers))} to {_number(max(numbers))}", *texts]
    else:
        shown = [*map(_number, numbers), *texts]
    name = "step" if key == "step" else f"`{key}`"
    return f"{name} {' or '.join(shown)}{f' {unit}' if key == 'step' and unit else ''}"
