"""Values are frozen, and one that holds arrays is compared by what it is, not by its entries."""

from __future__ import annotations

import re
from dataclasses import fields, is_dataclass
from pathlib import Path

import pytest

import galvi

ROOT = Path(__file__).parents[3]
MADE = re.compile(r"^@dataclass(\(.*\))?\nclass (\w+)", re.MULTILINE)
CHANGE = {  # what a search, a measurement or a process knows so far
    "Scan", "_Motion", "_Ladder", "_Measurement", "_Measured", "ExternalIntegrator", "TimedRun",
    "BuildCache", "Pair", "Printed", "_Runs", "Runs", "ServedChecks",
}  # fmt: skip


@pytest.mark.parametrize("package", ["galvi", "references", "benchmarks", "reports"])
def test_values_are_frozen(package: str) -> None:
    texts = [path.read_text(encoding="utf-8") for path in (ROOT / package).rglob("*.py")]
    made = [one for text in texts for one in MADE.findall(text)]
    assert made and {name for options, name in made if "frozen=True" not in options} <= CHANGE


def test_values_that_hold_arrays_are_compared_by_identity() -> None:
    """Arrays that are compared entry by entry have no truth value, and no digest."""
    values = [value for value in vars(galvi).values() if is_dataclass(value)]
    holders = [one for one in values if any("Array" in str(x.type) for x in fields(one))]
    assert galvi.NBody in holders
    assert [one for one in holders if one.__eq__ is not object.__eq__] == []
