"""A page for each integrator that the comparisons time, from their own data.

What they do not hold is in ``peers.csv``, with its source: what an integrator is, what it
conserves, its defects, its documentation. Links to results are ``studies.html#...`` there.
"""

from __future__ import annotations

import csv
import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cache
from pathlib import Path
from typing import Any

from benchmarks.claims.agreements import WithGalvi
from benchmarks.claims.documents import all_documents, measuring
from benchmarks.store.provenance import versions
from benchmarks.work_precision.labels import label_of
from benchmarks.work_precision.problem import Participant, Setting
from benchmarks.work_precision.problems import work_precision_problems
from reports.figures.picture import slug
from reports.figures.style.identities import identity

FACTS = Path(__file__).with_name("peers.csv")
PACKAGES = {"REBOUND": "rebound", "MuJoCo": "mujoco-core", "heyoka": "heyoka", "SciPy": "scipy"}
REPORT = re.compile(r"\[([^]]+)\]\((\w+\.html#[^)]+)\)")
FILE = re.compile(r"\b((?:references|reports|docs)/[\w/]+\.\w+)")
NOT_SHOWN = ("save_every", "samples")


@dataclass(frozen=True, eq=False)
class Peer:
    """What the comparisons hold of one family of contenders.

    Attributes
    ----------
    facts
        its line of ``peers.csv``
    orders
        of convergence, of each contender that states it
    runs
        problem -> its participants there
    """

    facts: Mapping[str, str]
    orders: set[int] = field(default_factory=set)
    runs: dict[str, list[Participant]] = field(default_factory=dict)

    @property
    def family(self) -> str:
        """The name in figures and tables."""
        return self.facts["family"]

    @property
    def file(self) -> str:
        """The name of its page."""
        return re.sub(r"[^a-z0-9]+", "-", self.family.lower()).strip("-")

    @property
    def order(self) -> str:
        """E.g. "4 to 32"."""
        found = sorted(self.orders)
        stated = f"{found[0]} to {found[-1]}" if len(found) > 1 else "".join(map(str, found))
        return self.facts["order"] or stated

    @property
    def package(self) -> str:
        """Package and installed version; "" for what the repository holds."""
        name = PACKAGES.get(self.family.split()[0])
        return f"{name}, {versions()[name]}" if name else ""

    @property
    def references(self) -> set[str]:
        """The names of its contenders."""
        return {one.contender.name for ran in self.runs.values() for one in ran}


@cache
def peers() -> tuple[Peer, ...]:
    """Every family of the comparisons; KeyError for one without a line in ``peers.csv``."""
    with FACTS.open(encoding="utf-8", newline="") as file:
        found = {line["family"]: Peer(line) for line in csv.DictReader(file)}
    for case in work_precision_problems(quick=False):
        for one in case.participants:
            peer = found[identity(one.label).family]
            peer.runs.setdefault(case.problem.name, []).append(one)
            order = getattr(getattr(one.contender, "method", one.contender), "order", None)
            peer.orders.update(() if order is None else (order,))
    return tuple(found.values())


def pages() -> Iterator[tuple[str, str]]:
    """(file, text) of the list of integrators, and of the page of each."""
    rows = [
        f"| [{one.family}]({one.file}.md) | {one.order} | {one.package or 'this repository'} "
        f"| {len(one.runs)} |"
        for one in peers()
    ]
    yield "peers/index.md", "\n".join((
        "# Compared integrators", "",
        "The codes that the suite times at equal error, and galvi's own methods: what they "
        "conserve, how they are set, what the suite found. Times and errors are in the "
        "[comparisons](../../results/comparisons.md).", "",
        "| integrator | order | package | problems |", "|---|---|---|---|", *rows, "",
        "```{toctree}", ":hidden:", "", *(one.file for one in peers()), "```", "",
    ))  # fmt: skip
    for one in peers():
        yield f"peers/{one.file}.md", _page(one)


def _page(one: Peer) -> str:
    facts = one.facts
    checked = [f"{{claim}}`{name}`" for name in _agreements(one.references)]
    steps = {"equal" if "step" in setting else "adaptive"
             for ran in one.runs.values() for each in ran for setting in each.settings}  # fmt: skip
    place = facts["documentation"]
    described = f"<{place}>" if place.startswith("http") else f"[on this site]({place})"
    lines = (
        ("Order", one.order),
        ("Steps", " and ".join(sorted(steps))),
        ("Conserves", facts["conserves"]),
        ("Known limits and defects", facts["defects"]),
        ("Package", one.package if one.package else "this repository"),
        ("Documentation", described if place else ""),
        ("Agrees with galvi", f"in {', '.join(checked)}" if checked else ""),
        ("Sources", facts["source"]),
    )
    text = [f"# {one.family}", "", facts["about"], ""]
    for title, words in lines:
        text += [title, f": {words}", ""] if words else []
    text += ["## Comparisons and settings", "", "Each setting is a point of the figure.", ""]
    for problem, ran in one.runs.items():
        label = label_of(problem)
        listed = [f"- {_short(each, one)}{_settings(each, label.time)}" for each in ran]
        shown = "\n  ".join(listed) if len(ran) > 1 else listed[0][2:]
        text += [f"[{label.title}](comparisons.html#{slug(problem)})", f": {shown}"]
        text += [""]
    linked = REPORT.sub(r'<a class="report" href="../../results/\2">\1</a>', "\n".join(text))
    return FILE.sub(r"`\1`", linked)


def _agreements(names: set[str]) -> Iterator[str]:
    """The agreements with galvi that a contender takes part in."""
    for part in all_documents()[-1].parts:
        for section in part.sections:
            pairs = (pair for pair in measuring(section).pairs if isinstance(pair, WithGalvi))
            if names & {pair.contender.name for pair in pairs}:
                yield section.id


def _settings(one: Participant, unit: str) -> str:
    """E.g. "5 settings: step 361 to 1083 d, corrector 17"."""
    number = len(one.settings)
    keys = dict.fromkeys(key for setting in one.settings for key in setting if key not in NOT_SHOWN)
    varied = ", ".join(_values(key, one.settings, unit) for key in keys)
    return f"{number} setting{'s' if number > 1 else ''}" + (f": {varied}" if varied else "")


def _short(one: Participant, peer: Peer) -> str:
    """Its label without what the page's title says, and a colon; "" where nothing is left."""
    rest = one.label.removeprefix(peer.family).lstrip(" ,")
    return f"{rest}: " if rest else ""


def _number(value: float) -> str:
    return f"{value:.0f}" if 1000.0 <= value < 1e6 else f"{value:.3g}"


def _values(key: str, settings: Sequence[Setting], unit: str) -> str:
    values: list[Any] = list(dict.fromkeys(one.get(key, "default") for one in settings))
    numbers = [one for one in values if isinstance(one, float)]
    words = [str(one) for one in values if not isinstance(one, float)]
    if len(numbers) > 2:
        shown = [f"{_number(min(numbers))} to {_number(max(numbers))}", *words]
    else:
        shown = [*map(_number, numbers), *words]
    name = "step" if key == "step" else f"`{key}`"
    return f"{name} {' or '.join(shown)}{f' {unit}' if key == 'step' and unit else ''}"
