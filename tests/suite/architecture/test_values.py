"""Values are frozen, and one that holds arrays is compared by what it is, not by its entries."""

from __future__ import annotations

import ast
import re
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[3]
PACKAGES = ("galvi", "references", "benchmarks", "reports")
CHANGE = {  # what a search, a measurement or a process knows so far
    "Scan", "_Motion", "_Ladder", "_Measurement", "ExternalIntegrator", "TimedRun", "BuildCache",
    "Pair", "Printed", "_Runs",
}  # fmt: skip
ARRAYS = re.compile(r"(Array|Codes|pd\.DataFrame)( \| None)?|tuple\[Array, .*\]")


def dataclasses(package: str) -> list[tuple[str, dict[str, bool], bool]]:
    """Name, options and whether a field is an array, of each dataclass; the sources are read."""
    found = []
    for path in sorted((ROOT / package).rglob("*.py")):
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            for one in (
                getattr(node, "decorator_list", ()) if isinstance(node, ast.ClassDef) else ()
            ):
                call = one if isinstance(one, ast.Call) else ast.Call(one, [], [])
                if ast.unparse(call.func) == "dataclass":
                    fields = [x.annotation for x in node.body if isinstance(x, ast.AnnAssign)]
                    arrays = any(ARRAYS.fullmatch(ast.unparse(field)) for field in fields)
                    options = {x.arg: ast.literal_eval(x.value) for x in call.keywords}
                    found.append((node.name, options, arrays))
    return found


@pytest.mark.slow_cases(but=["references"])
@pytest.mark.parametrize("package", PACKAGES)
def test_values_are_frozen_and_those_with_arrays_compared_by_identity(package: str) -> None:
    """Arrays that are compared entry by entry have no truth value, and no digest."""
    known = dataclasses(package)
    assert known
    assert {name for name, options, _ in known if not options.get("frozen")} <= CHANGE
    assert [name for name, options, arrays in known if arrays and options.get("eq", True)] == []
