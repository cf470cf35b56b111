"""Compiles laws and forces for lanes, from generated source that is cached on disk."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import lru_cache
from typing import Any, cast

import numpy as np

from galvi.arrays import Array
from galvi.lanes.collocation import nonzero_factors
from galvi.tracing import code as symbolic_code
from galvi.tracing.code import POWER

# Functions of galvi.lanes.elementary.
LANE_FUNCTIONS = {"sin", "cos", "tan", "exp", "log", "sqrt", "sinh", "cosh", "tanh", "atan2", POWER}
# Largest number of coordinates of a law in lanes, with a diagonal and with a full inverse mass.
WIDEST_FORCE, WIDEST_COUPLED_FORCE = 64, 12
MAX_OPERATIONS = 4_000  # of a user's law; each takes two milliseconds to compile
MAX_BUILT_IN_OPERATIONS = 9_000  # of a built-in law: EIH of 11 bodies has 8,000
# Source of a module with a function ``compiled``, a step of a law.
STEP = """from galvi.lanes.{module} import generated_step
{law}

step_of_law = generated_step(law, {arguments})


def compiled_DIGEST(address):
    step_of_law(address)
"""


@lru_cache(maxsize=256)
def compiled_law(module: str, law: str, *arguments: Any) -> Callable[..., Any]:
    """The step of a law, compiled at its first call.

    Parameters
    ----------
    module
        module of galvi.lanes whose ``generated_step`` is used
    law
        code that defines ``law``
    arguments
        arguments of ``generated_step`` after the law
    """
    text = STEP.format(module=module, law=law, arguments=", ".join(map(repr, arguments)))
    return cast(
        Callable[..., Any], symbolic_code.functions(symbolic_code.with_digest(text))["compiled"]
    )


def built_in(name: str, *arguments: Any) -> str:
    """Code that defines ``law`` by the function ``name`` of galvi.lanes.laws."""
    literals = ", ".join(map(repr, arguments))
    return f"from galvi.lanes.laws import {name}\n\nlaw = {name}({literals})\n"


@lru_cache(maxsize=256)
def coupled_components(law: str, d: int) -> list[tuple[int, int]]:
    """The pairs (i, j), j < i, for which the factor L of the law's mass L D L^T is not 0."""
    return nonzero_factors(function_of(law), d)


def with_force(law: tuple[str, Array], force: tuple[str, Array]) -> tuple[str, Array]:
    """The code and constants of a law with an external force, from those of both."""
    forced = f"law = forced(law, force, {law[1].size})\n"
    head = "from galvi.lanes.laws import forced\n"
    lines = f"{law[0]}\n\n\n{force[0]}\n\n\n{head}\n{forced}"
    return lines, np.concatenate([law[1], force[1]])


def canonical_law(slopes: str, d: int, diagonal: bool) -> str:
    """Code that defines ``law`` by galvi.lanes.laws.canonical; ``slopes`` is the code of dV/dq."""
    head = "from galvi.lanes.laws import canonical\n"
    return f"{head}{slopes}\n\nlaw = canonical(slopes, {d}, {diagonal})\n"


def unit_mass_law(slopes: str, force: str, d: int, coupled: bool, forced_from: int) -> str:
    """Code that defines ``law`` by galvi.lanes.laws.of_unit_mass; ``slopes`` is the code of dV/dq,
    ``force`` that of the external force, "" without one."""
    head = "from galvi.lanes.laws import of_unit_mass\n"
    law = f"law = of_unit_mass(slopes, force, {d}, {coupled}, {forced_from})\n"
    return f"{slopes}\n\n\n{force or 'force = None'}\n\n\n{head}\n{law}"


def function_of(law: str, name: str = "law") -> Callable[..., Any]:
    """The Python function ``name`` that the code ``law`` defines, for numbers and arrays."""
    names: dict[str, Any] = {}
    exec(compile(law, "<a law>", "exec"), names)
    return cast(Callable[..., Any], names[name])


def printed_force(forces: Sequence[Any], places: Any) -> str:
    """Code that defines ``force`` from SymPy expressions; "" if lanes lack a function of these."""
    lines = symbolic_code.code_lines(forces, places, lambda k, code: f"r{k} = {code}", POWER)
    return function_lines("force(q, v, t, c)", lines, [f"r{k}" for k in range(len(forces))])


def printed_law(q: Any, v: Any, t: Any, L: Any, places: Any, differentiated: Any) -> str:
    """Code that defines the law of a SymPy Lagrangian; "" if lanes lack a function of it."""
    d = len(q)
    momenta = [differentiated(L, x) for x in v]
    expressions = [differentiated(L, x) for x in q] + momenta
    expressions += [differentiated(momenta[i], v[j]) for i in range(d) for j in range(i + 1)]
    lines = symbolic_code.code_lines(expressions, places, lambda k, code: f"r{k} = {code}", POWER)
    return law_lines(lines, [f"r{k}" for k in range(len(expressions))], d)


def law_lines(lines: Sequence[str], formulas: Sequence[str], d: int) -> str:
    """Code that defines ``law``, see `function_lines`.

    Parameters
    ----------
    formulas
        the code of dL/dq and dL/dv, (d,) each, and of the rows of d2L/dv2 up to its diagonal
    """
    rows, packed = [], formulas[2 * d :]
    for i in range(d):
        rows.append(f"[{', '.join(packed[: i + 1])}]")
        packed = packed[i + 1 :]
    rows_of_code = [f"[{', '.join(part)}]" for part in (formulas[:d], formulas[d : 2 * d], rows)]
    return function_lines("law(q, v, t, c)", lines, rows_of_code)


def function_lines(head: str, lines: Sequence[str], formulas: Sequence[str]) -> str:
    """Code that defines a function which returns a list; "" if lanes lack a function that it calls,
    or it contains a branch.

    Parameters
    ----------
    head
        name and arguments of the function
    lines
        lines that compute the variables of the formulas
    formulas
        code of the entries of the list
    """
    text = "\n".join([*lines, *formulas])
    used = sorted(symbolic_code.functions_in(text))
    if set(used) - LANE_FUNCTIONS or " if " in text:
        return ""
    imports = [f"from galvi.lanes.elementary import {', '.join(used)}"] * bool(used)
    body = (f"    {line}" for line in [*lines, f"return [{', '.join(formulas)}]"])
    return "\n".join([*imports, "", "", f"def {head}:", *body])


def fits(d: int, coupled: bool) -> bool:
    """Whether the accelerations on R^d are short enough for a law in lanes.

    Parameters
    ----------
    coupled
        whether the inverse mass is a full matrix
    """
    return d <= (WIDEST_COUPLED_FORCE if coupled else WIDEST_FORCE)
