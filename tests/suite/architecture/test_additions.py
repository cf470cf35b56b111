"""The table "Adding something" of CONTRIBUTING.md, followed in a copy of the sources.

Charts and groups are added in tests/properties/test_new_chart_and_group.py; test_frames.py there
has a case of every frame, reports/test_figures.py in tests/suite one of every figure, and the whole
cost table is filled in benchmarks/test_work_precision.py there.
"""

from __future__ import annotations

import re
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[3]
TESTED_ELSEWHERE = {
    "chart",
    "frame",
    "group",
    "figure of a claim",
    "column of the cost table (`cost.csv`, what a step of galvi costs)",
}

SPACE = """
from dataclasses import dataclass

from numpy.polynomial.chebyshev import chebder, chebvander
import numpy as np


@dataclass(frozen=True)
class Mine:
    degree: int
    exact: bool = False

    @property
    def dimension(self):
        return self.degree + 1

    def basis(self, t):
        return chebvander(2 * t - 1, self.degree)

    def derivative(self, t):
        return 2 * chebvander(2 * t - 1, self.degree - 1) @ chebder(np.eye(self.dimension))
"""
RULE = """
import numpy as np

from galvi.rules.rule import Rule


def mine(points):
    x, w = np.polynomial.legendre.leggauss(points)
    return Rule(f"mine {points}", 2 * points - 1, (1 + x) / 2, w / 2)
"""
PROBLEM = """
from dataclasses import replace

from galvi.problems.pendulums import harmonic_oscillator


def mine():
    return replace(harmonic_oscillator(), name="mine")
"""
REFERENCE = """
from dataclasses import replace

from references.closed_forms.oscillator import OSCILLATOR

MINE = replace(OSCILLATOR, name="mine")
"""
CLAIM = """
def measure(make_method, quick, report):
    return {"error": 1e-9}
"""
SECTION = """
### V99: My claim

Ours: it is small.

- measured by: vector_spaces.mine
- source: mine
- reason: so

| quantity | bound | caught |
| --- | --- | --- |
| error | at most 1e-8 | b 1e-6 |
"""
WORK_PRECISION = """
from dataclasses import replace

from benchmarks.work_precision.problems.planets import kepler_orbit
from galvi import problems


def mine(quick):
    return replace(kepler_orbit(quick), problem=problems.mine())
"""
STUDY = """
import pandas as pd

from reports.results.section import Section

MINE = Section(
    name="mine",
    title="My study",
    text="Two numbers.",
    measure=lambda quick, report: pd.DataFrame({"n": [1, 2]}),
    table=lambda frame: (frame.astype(str), {"n": "number"}),
)
"""
USE = """
import galvi
from benchmarks.claims import CLAIMS
from benchmarks.work_precision.problems import work_precision_problems
from galvi.rules import RULES
from galvi.spaces import SPACES
from references import REFERENCES, reference
from reports.contents import SECTIONS

method = galvi.Galerkin(SPACES[-1](4), RULES[-1](4))
assert method.order == 8 and method.name == "Gauss collocation, 4 stages", method.name
assert "mine" in galvi.problems.__all__ and galvi.problems.mine().name == "mine"
assert reference("mine") is REFERENCES[-1] and REFERENCES[-1].supports(galvi.problems.mine())
(claim,) = (claim for claim in CLAIMS if claim.id == "V99")
(row,) = claim.judge(claim.study(galvi.Galerkin, True, print))
assert (row.id, row.verdict, row.bound) == ("V99", "holds", "at most 1e-08")
assert work_precision_problems(True)[-1].problem.name == "mine"
assert SECTIONS[-1].name == "mine" and len(SECTIONS[-1].measure(True, print)) == 2
"""
# row of the table: (file, its text, import, entry)
ADDED = {
    "space": ("galvi/spaces/mine.py", SPACE, "from galvi.spaces.mine import Mine", "Mine"),
    "rule": ("galvi/rules/mine.py", RULE, "from galvi.rules.mine import mine", "mine"),
    "problem": ("galvi/problems/mine.py", PROBLEM,
                "from galvi.problems.mine import mine", '"mine"'),
    "reference": ("references/closed_forms/mine.py", REFERENCE,
                  "from references.closed_forms.mine import MINE", "MINE"),
    "work-precision problem": ("benchmarks/work_precision/problems/mine.py", WORK_PRECISION,
                               "from benchmarks.work_precision.problems.mine import mine", "mine"),
    "study": ("reports/studies/mine.py", STUDY, "from reports.studies.mine import MINE", "MINE"),
}  # fmt: skip


ADDED_CLAIM = ("benchmarks/claims/vector_spaces/mine.py", CLAIM, "benchmarks/claims/own.md")


def rows() -> dict[str, tuple[list[str], list[tuple[str, str]]]]:
    """(folders of the file, (list, file) of each entry) of each row of the table."""
    page = (ROOT / "CONTRIBUTING.md").read_text()
    table = page.partition("| new | file | entry |")[2].partition("\n\n")[0]
    additions = {}
    for line in table.splitlines()[2:]:
        kind, file, entry = (cell.strip() for cell in line.strip("|").split("|"))
        folders = re.findall(r"`([\w/]+/)(?:NAME\.py)?`", file.replace("ENGINE/", ""))
        lists = re.findall(r"`([A-Z_a-z]+)`[^`]*(?:`[A-Z]+`)? (?:in|of) `(\S+\.py)`", entry)
        additions[kind] = folders, lists
    return additions


def enter(path: Path, name: str, imported: str, entry: str) -> None:
    """Append the import to a source file, and the entry to its list `name`."""
    text = path.read_text()
    assert re.search(rf"^{name}\b.*=", text, re.M)
    path.write_text(f"{text}\n{imported}\n\n{name} = (*{name}, {entry})\n")


def test_every_row_names_folders_and_lists_that_exist() -> None:
    assert set(rows()) == set(ADDED) | TESTED_ELSEWHERE | {"claim"}  # each is followed by a test
    for kind, (folders, entries) in rows().items():
        assert [folder for folder in folders if not (ROOT / folder).is_dir()] == [], kind
        for name, file in entries:
            assert re.search(rf"^{name}\b.*=", (ROOT / file).read_text(), re.M), (kind, name)


@pytest.fixture
def copy(tmp_path: Path) -> Path:
    for package in ("galvi", "references", "benchmarks", "reports"):
        ignored = shutil.ignore_patterns("*.pyc", "out")  # compiled kernels are copied too
        shutil.copytree(ROOT / package, tmp_path / package, ignore=ignored)
    return tmp_path


@pytest.mark.slow(beside="test_every_row_names_folders_and_lists_that_exist")
def test_a_new_member_is_one_file_and_one_entry(copy: Path) -> None:
    table = rows()
    for kind, (file, text, imported, entry) in ADDED.items():
        (copy / file).write_text(text)
        name, list_file = table[kind][1][0]
        enter(copy / list_file, name, imported, entry)
    file, text, document = ADDED_CLAIM
    (copy / file).write_text(text)
    with (copy / document).open("a") as claims:
        claims.write(SECTION)
    completed = subprocess.run(
        [sys.executable, "-c", USE],
        cwd=copy,
        env={"PYTHONPATH": str(copy)},
        capture_output=True,
        text=True,
    )
    assert completed.returncode == 0, completed.stderr
