"""Deliberate mistakes that a claim must detect, declared in its file; one test plants them all."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Set
from copy import copy
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
import pandas as pd

import galvi
from galvi import Problem

ORACLES = "distance between the two references"


@dataclass(frozen=True)
class Fault:
    """A mistake in the methods, in a function or in the measured table.

    Attributes
    ----------
    make
        function that takes the place of `galvi.Galerkin`
    wrong
        dotted name -> function that takes the object of that name and returns its replacement
    table
        function that changes a copy of the study's table in place
    name
        name of the fault in the claim's document
    contradicted
        quantities of the rows that the fault must contradict
    """

    make: Callable[..., Any] = galvi.Galerkin
    wrong: Mapping[str, Callable[[Any], Any]] = field(default_factory=dict)
    table: Callable[[pd.DataFrame], Any] | None = None
    name: str = ""
    contradicted: Set[str] = frozenset()


def faulty(**scale: float) -> Callable[..., Any]:
    """A function that makes methods with these arrays of their table multiplied.

    Methods with a degree for each component stay unchanged: they do not step by their table.
    """

    def make(space: Any, rule: Any, *chart: Any) -> galvi.Galerkin:
        original = galvi.Galerkin(space, rule, *chart)
        if hasattr(space, "degrees"):
            return original
        wrong = {name: getattr(original.table, name) * by for name, by in scale.items()}
        return with_table(original, f"wrong {scale}", replace(original.table, **wrong))

    return make


def with_table(original: galvi.Galerkin, why: str, table: Any) -> galvi.Galerkin:
    """A copy of the method with another table and another name of its rule.

    The constructor is not called, since it would tabulate the renamed rule again.
    """
    method = copy(original)
    vars(method).update(
        rule=replace(original.rule, name=f"{original.rule.name}, {why}"), table=table
    )
    return method


def of_table(wrong: Mapping[str, Any], **scale: float) -> Fault:
    """A fault that multiplies arrays of the method's table and has the functions in `wrong`."""
    return Fault(faulty(**scale), wrong)


def of_motion(
    change: Callable[[Problem], Problem], wrong: Mapping[str, Any] | None = None
) -> Fault:
    """A fault where galvi solves a changed problem and has the functions in `wrong`."""

    def changed(integrate: Callable[..., Any]) -> Callable[..., Any]:
        return lambda problem, *arguments, **how: integrate(change(problem), *arguments, **how)

    return Fault(wrong={"galvi.integrate": changed, **(wrong or {})})


def always(value: Any) -> Callable[[Any], Any]:
    """A function that replaces an object by this value."""
    return lambda original: value


def fewer(module: str, **values: Any) -> dict[str, Callable[[Any], Any]]:
    """Replacements that shorten a study: constants of its module have these values."""
    return {f"{module}.{name}": always(value) for name, value in values.items()}


def scaled(by: float) -> Callable[[Any], Any]:
    """A function that replaces a function by one whose value, or each of whose values, is
    multiplied."""

    def wrong(value: Any) -> Any:
        return tuple(by * part for part in value) if isinstance(value, tuple) else by * value

    return lambda original: lambda *arguments, **how: wrong(original(*arguments, **how))


def with_arguments(change: Callable[..., tuple[Any, ...]]) -> Callable[[Any], Any]:
    """A function that replaces a function by one that calls it with changed arguments."""
    return lambda original: lambda *arguments, **how: original(*change(*arguments), **how)


def heavier(problem: Problem) -> Problem:
    """The problem with the mass of its centre or Sun, or a body's third moment, larger by 1e-6."""
    system: Any = problem.system
    if isinstance(system, galvi.RigidBody):
        moments = system.inertia * np.diag([1.0, 1.0, 1.0 + 1e-6])
        return replace(problem, system=galvi.RigidBody(moments, system.potential))
    if isinstance(system, galvi.NBody):
        by = np.where(np.arange(system.masses.size) == 0, 1.0 + 1e-6, 1.0)
        return replace(problem, system=galvi.NBody(system.masses * by, system.G))
    mu = system.potential.mu * (1.0 + 1e-6)
    return replace(problem, system=replace(system, potential=galvi.CentralForce(mu)))


def reversed_clock(problem: Problem) -> Problem:
    """The problem with its initial velocity reversed."""
    return replace(problem, v0=-problem.v0)


def _set_apart(table: pd.DataFrame) -> None:
    table.loc[table["quantity"].str.startswith(ORACLES), "value"] = 1.0


def times(by: float, power: float = 0.0, **where: str) -> Callable[[pd.DataFrame], None]:
    """A function that multiplies the values of these rows of a table by `by` step^power."""

    def change(table: pd.DataFrame) -> None:
        chosen = pd.Series(True, index=table.index)
        for name, value in where.items():
            chosen &= table[name] == value
        assert chosen.any(), where
        table.loc[chosen, "value"] *= by * table.loc[chosen, "step"] ** power

    return change


OTHER_TRUTH = Fault(table=_set_apart)
