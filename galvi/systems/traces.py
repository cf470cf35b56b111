"""The traces of a system's functions, stored with the system.

With GALVI_FAST=0 nothing is traced.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Protocol

from galvi.arrays import Array
from galvi.environment import FAST


class Untraceable(Exception):
    """A function that cannot be written as an expression; the message says why."""


class Trace(Protocol):
    """The expressions of one function, or of a few that belong together."""

    @property
    def holds(self) -> bool:
        """Whether the functions still return, at recorded states, the values they had when they
        were traced."""


@dataclass(frozen=True, eq=False)
class Traces:
    """The traces of a system, by the name of the traced function: "L", "force" or "dV/dq".

    Attributes
    ----------
    traced
        name -> trace
    refused
        name -> why the function was not traced
    """

    traced: Mapping[str, Any]
    refused: Mapping[str, str]

    @property
    def hold(self) -> bool:
        """Whether every trace holds."""
        return all(trace.holds for trace in self.traced.values())


NO_TRACES = Traces({}, {})
TRACES_ATTRIBUTE = "_traces"  # attribute of a system, so that its traces are freed with it


def traces(system: Any) -> Traces:
    """The traces of a system; empty before the first call of `trace`."""
    return vars(system).get(TRACES_ATTRIBUTE, NO_TRACES)


def reasons(system: Any) -> str:
    """Why functions of a system could not be traced; "" for none."""
    return "; ".join(f"{name}: {reason}" for name, reason in traces(system).refused.items())


def trace(system: Any, q: Array, v: Array, t: float, anew: bool = False) -> None:
    """Trace the functions of a system near a state.

    Parameters
    ----------
    anew
        trace again if a trace no longer holds; else a system is traced once
    """
    existing = traces(system)
    if not FAST or (existing is not NO_TRACES and not (anew and not existing.hold)):
        return
    from galvi.tracing.laws_of_systems import finders_of  # tracing stands on systems

    traced: dict[str, Trace] = {}
    refused: dict[str, str] = {}
    for name, find in finders_of(system, q, v, t).items():
        try:
            traced[name] = find()
        except Untraceable as reason:
            refused[name] = str(reason)
    vars(system)[TRACES_ATTRIBUTE] = Traces(traced, refused)


def share(system: Any, source: Any) -> None:
    """Give a system the traces of ``source``, which calls its functions."""
    vars(system)[TRACES_ATTRIBUTE] = traces(source)


def refuse(system: Any, name: str, reason: str) -> None:
    """Replace a trace of a system by the reason why it cannot be used."""
    existing = traces(system)
    traced = {key: value for key, value in existing.traced.items() if key != name}
    vars(system)[TRACES_ATTRIBUTE] = Traces(traced, {**existing.refused, name: reason})
