"""Compiles laws of motion for lanes, from generated source that is cached on disk."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, cast

import numpy as np

from galvi.symbolic import code as symbolic_code
from galvi.symbolic.code import POWER

# of galvi.kernels.lanes.elementary
FUNCTIONS = {"sin", "cos", "tan", "exp", "log", "sqrt", "atan2", POWER}
PASS = """

pass_of_law = one_pass(law, {d})


def law_pass_DIGEST(work, tables, constants, numbers):
    pass_of_law(work, tables, constants, numbers)
"""
GROUP_PASS = """

pass_of_law = group_pass(law, {layout}, {chart})


def law_pass_DIGEST(work, tables, constants, numbers):
    pass_of_law(work, tables, constants, numbers)
"""


def law_source(law: str, d: int) -> str:
    """The source of the pass of a law on R^d from the lines that define ``law``."""
    head = "from galvi.kernels.lanes.law_pass import one_pass\n"
    return symbolic_code.with_digest(head + law + PASS.format(d=d))


def group_law_source(law: str, layout: Any, chart: int) -> str:
    """The source of the pass of a law on a group from the lines that define ``law``.

    layout, chart  of galvi.kernels.lie.product
    """
    head = "from galvi.kernels.lanes.group_pass import group_pass\n"
    tail = GROUP_PASS.format(layout=np.asarray(layout).tolist(), chart=chart)
    return symbolic_code.with_digest(head + law + tail)


def built_in_law(name: str, *arguments: Any) -> str:
    """The lines that define a law of galvi.kernels.lanes.laws, made with these arguments."""
    return f"from galvi.kernels.lanes.laws import {name}\n\nlaw = {name}{arguments!r}\n"


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
    used = sorted(symbolic_code.functions_in(text))
    names = [f"r{k}" for k in range(len(results))]
    rows, rest = [], names[2 * d :]
    for i in range(d):
        rows.append(f"[{', '.join(rest[: i + 1])}]")
        rest = rest[i + 1 :]
    head = [f"from galvi.kernels.lanes.elementary import {', '.join(used)}"] * bool(used)
    body = [*lines, f"return [{', '.join(names[:d])}], [{', '.join(names[d : 2 * d])}], ["
            f"{', '.join(rows)}]"]  # fmt: skip
    return "\n".join([*head, "", "", "def law(q, v, t, c):", *(f"    {line}" for line in body)])
