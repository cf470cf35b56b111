"""Compiles laws of motion for lanes, from generated source that is cached on disk."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any, cast

from galvi.symbolic import code as symbolic_code
from galvi.symbolic.code import POWER

# of galvi.kernels.lanes.elementary
FUNCTIONS = {
    "sin", "cos", "tan", "exp", "log", "sqrt", "sinh", "cosh", "tanh", "atan2", POWER
}  # fmt: skip
PASS = """

pass_of_law = one_pass(law, {d})


def law_pass_DIGEST(work, tables, constants, numbers):
    pass_of_law(work, tables, constants, numbers)
"""


def law_source(law: str, d: int) -> str:
    """The source of the pass of a law on R^d from the lines that define ``law``."""
    head = "from galvi.kernels.lanes.law_pass import one_pass\n"
    return symbolic_code.with_digest(head + law + PASS.format(d=d))


def compiled_law(source: str) -> Callable[..., Any]:
    """The law's galvi.kernels.lanes.law_pass, compiled at the first call."""
    return cast(Callable[..., Any], symbolic_code.functions(source)["law_pass"])


def printed_law(q: Any, v: Any, t: Any, L: Any, places: Any, differentiated: Any) -> str:
    """The lines that define the law of a SymPy Lagrangian; "" where lanes lack a function of it."""
    d = len(q)
    momenta = [differentiated(L, x) for x in v]
    results = [differentiated(L, x) for x in q] + momenta
    results += [differentiated(momenta[i], v[j]) for i in range(d) for j in range(i + 1)]
    lines = symbolic_code.written(results, places, lambda k, code: f"r{k} = {code}", POWER)
    text = "\n".join(lines)
    if symbolic_code.functions_in(text) - FUNCTIONS or " if " in text or "abs(" in text:
        return ""
    return law_lines(lines, [f"r{k}" for k in range(len(results))], d)


def law_lines(lines: Sequence[str], results: Sequence[str], d: int) -> str:
    """The lines that define a law, from those that compute its results and the code of each.

    results  of dL/dq and dL/dv, (d,) each, and the rows of d2L/dv2 up to its diagonal
    """
    rows, rest = [], results[2 * d :]
    for i in range(d):
        rows.append(f"[{', '.join(rest[: i + 1])}]")
        rest = rest[i + 1 :]
    listed = [f"[{', '.join(x)}]" for x in (results[:d], results[d : 2 * d], rows)]
    return function_lines("law(q, v, t, c)", lines, ", ".join(listed))


def function_lines(head: str, lines: Sequence[str], returned: str) -> str:
    """The lines that define a function of galvi.kernels.lanes.elementary."""
    used = sorted(symbolic_code.functions_in("\n".join([*lines, returned])))
    imports = [f"from galvi.kernels.lanes.elementary import {', '.join(used)}"] * bool(used)
    body = (f"    {line}" for line in (*lines, f"return {returned}"))
    return "\n".join([*imports, "", "", f"def {head}:", *body])
