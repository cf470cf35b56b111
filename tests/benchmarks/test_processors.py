"""The study of processors sees a bit, and a status, that differ."""

from __future__ import annotations

import copy
import math
import platform
import subprocess
import sys

import pandas as pd
import pytest

from benchmarks.applications.processors import study
from benchmarks.applications.processors.cases import CASES
from reports.studies.costs import processors_table

END = {"q": [(3.0).hex(), (0.5).hex()], "p": [(1.0).hex()], "status": "Completed.", "iterations": 7}


@pytest.fixture
def ends():
    other = copy.deepcopy(END)
    other["q"][1] = math.nextafter(0.5, 1.0).hex()
    return {"": {"a": END}, "generic": {"a": other}, "znver4": None}


def test_a_difference_is_in_units_of_the_largest_entry_and_a_missing_processor_is_named(ends):
    (row,) = study.compared(ends, "generic")
    assert row["units"] == 0.25 and row["status"] == ""  # the place of 3 is four times that of 0.5
    (row,) = study.compared(ends, "znver4")
    assert row["status"] == study.NOT_HERE
    (row,) = study.compared(ends, "")
    assert row["units"] == 0.0


def test_a_status_that_differs_is_shown(ends):
    ends["generic"]["a"]["status"] = "Stopped."
    rows = [row for name in ends for row in study.compared(ends, name)]
    table, _ = processors_table(pd.DataFrame(rows).assign(commit="a", date=""))
    assert table.loc[0, "generic"] == "Stopped." and study.HOST not in table


def test_every_case_names_a_problem_and_a_method_that_fit():
    for problem, method, step, _ in CASES.values():
        assert step > 0 and problem().q0 is not None and method.name


SQUARES = """
import numba

@numba.njit(fastmath=True)
def squares(x):
    total = 0.0
    for k in range(x.size):
        total += x[k] * x[k]
    return total

squares.compile('(float64[::1],)')
print(next(iter(squares.inspect_asm().values())))
"""


@pytest.mark.skipif(platform.machine() != "x86_64", reason="instructions of x86-64")
def test_no_instruction_is_used_that_the_named_processor_lacks():
    """On a machine with AVX-512, whose registers are called zmm, the name alone would use it."""
    done = subprocess.run(
        [sys.executable, "-c", SQUARES],
        env=study.environment("haswell"), capture_output=True, text=True, check=True,
    )  # fmt: skip
    assert "ymm" in done.stdout and "zmm" not in done.stdout
