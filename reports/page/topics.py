"""The claims by what they say, in the order of the page."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from benchmarks.checks.claim import AGREEMENT
from reports.page.claim_section import ClaimSection


@dataclass(frozen=True)
class Topic:
    """A heading, a sentence below it, and the ids of its claims."""

    name: str
    title: str
    text: str
    claims: tuple[str, ...]


@dataclass(frozen=True)
class ClaimGroup:
    """The sections of the claims of a topic."""

    anchor: str
    title: str
    text: str
    claims: tuple[ClaimSection, ...]


TOPICS = (
    Topic(
        "degree", "Errors fall geometrically with the degree",
        "At a fixed step the error shrinks by a constant factor with each basis function.",
        ("V1", "V2", "V3", "V4", "V5", "V18", "L2", "L6"),
    ),
    Topic(
        "order", "The order in the step size",
        "At a fixed degree the error is a power of the step size.",
        ("V6", "V7", "V17", "V23", "L3", "L7", "L14", "V29", "V31"),
    ),
    Topic(
        "long", "Energy and momentum over long runs",
        "Errors of conserved quantities stay bounded and, above rounding, do not drift.",
        ("V8", "V11", "V15", "L1", "L4", "L5", "L8", "L9", "L13"),
    ),
    Topic(
        "steps", "Steps longer than a period",
        "Orbits stay closed where a step is longer than the fastest planet's year.",
        ("V9", "V10", "V33"),
    ),
    Topic(
        "structure", "Symplectic, well posed, equivariant",
        "When there is a method, when it is symplectic, and when its equations have one solution.",
        ("V12", "V13", "V16", "V19", "V20", "V30", "V32", "V35", "V36", "L10", "L11", "L12", "L16",
         "L18"),
    ),
    Topic(
        "curve", "The curve between the steps, and the discrete action",
        "How well Galerkin curves and discrete Lagrangians approximate the exact ones.",
        ("V14", "V26", "V34", "L15", "L17"),
    ),
    Topic(
        "constants", "Constants, norms and finite smoothness",
        "Inequalities as printed, and what limits the rate where the motion is not smooth.",
        ("V21", "V22", "V27", "V28"),
    ),
    Topic(
        "brownout", "Particles in a rotor's wind",
        "What high order costs and saves for forces that depend on velocity.",
        ("V24", "V25"),
    ),
)  # fmt: skip
AGREEMENTS = "Agreement with other codes"
REST = "Further claims"


def claim_groups(claims: Sequence[ClaimSection]) -> list[ClaimGroup]:
    """Every claim once: by topic, then those of no topic, then agreements with other codes."""
    known = {one.claim.id: one for one in claims}
    found = [
        ClaimGroup(
            f"group-{topic.name}", topic.title, topic.text,
            tuple(known.pop(name) for name in topic.claims if name in known),
        )
        for topic in TOPICS
    ]  # fmt: skip
    agreements = [one for one in known.values() if one.checks[0][0].source == AGREEMENT]
    rest = [one for one in known.values() if one not in agreements]
    found += [
        ClaimGroup("group-rest", REST, "", tuple(rest)),
        ClaimGroup(
            "group-agreements", AGREEMENTS,
            "Not claims of a paper: two codes solve one problem, and differ by rounding or by the "
            "other code's own error.",
            tuple(agreements),
        ),
    ]  # fmt: skip
    return [group for group in found if group.claims]
