"""What was found by tracing the functions of a system, kept as long as the system exists."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any, Protocol

from galvi.symbolic.graph import Untraceable


class Trace(Protocol):
    """What was found by tracing one function or a few that belong together."""

    @property
    def holds(self) -> bool:
        """Whether the functions return at some states what they did when they were traced."""


@dataclass(frozen=True, eq=False)
class Traces:
    """The traces of a system by what they are of: "L", "force" or "dV/dq".

    found    name -> what was found
    refused  name -> why nothing was
    """

    found: Mapping[str, Any]
    refused: Mapping[str, str]

    @property
    def hold(self) -> bool:
        """Whether each trace still is that of its functions."""
        return all(trace.holds for trace in self.found.values())


NONE = Traces({}, {})
KEPT = "_traces"  # attribute of a system, so that both end together


def traces(system: Any) -> Traces:
    """The traces of a system; none where they were not sought."""
    found: Traces = vars(system).get(KEPT, NONE)
    return found


def reasons(system: Any) -> str:
    """Why functions of a system could not be traced; "" for none."""
    return "; ".join(f"{name}: {reason}" for name, reason in traces(system).refused.items())


def trace(
    system: Any, finders: Callable[[], Mapping[str, Callable[[], Trace]]], anew: bool = False
) -> None:
    """Trace the functions of a system.

    finders  returns what finds each trace, and may raise `Untraceable`
    anew     do it again if what was found does not hold any more
    """
    known = traces(system)
    if known is not NONE and not (anew and not known.hold):
        return
    found: dict[str, Trace] = {}
    refused: dict[str, str] = {}
    for name, find in finders().items():
        try:
            found[name] = find()
        except Untraceable as reason:
            refused[name] = str(reason)
    vars(system)[KEPT] = Traces(found, refused)


def share(system: Any, other: Any) -> None:
    """Let a system whose functions another one calls have the traces of that one."""
    vars(system)[KEPT] = traces(other)


def refuse(system: Any, name: str, reason: str) -> None:
    """Forget one of the traces of a system."""
    known = traces(system)
    found = {key: value for key, value in known.found.items() if key != name}
    vars(system)[KEPT] = Traces(found, {**known.refused, name: reason})
