"""A study, a figure or a column of the cost table is one value in one place, and then it is shown.

The files are added to a copy of the sources, as CONTRIBUTING says.
"""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]

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
FIGURE = """    Figure(
        name="mine",
        source="H fig. 2.3",
        title="My figure",
        claims=("V1",),
        draw=lambda axes, frame: axes.plot(frame["n"], frame["value"]),
    ),
"""
COLUMN = """    Column("curves", lambda cost: int(cost.run.curves is not None), "curves kept"),
"""
SHOW = """
import sys
from dataclasses import replace
from pathlib import Path

from benchmarks.work_precision import cost
from reports.build.build import build
from reports.contents import SECTIONS, load
from reports.results.comparison import Options

cases = cost._cases(True)
cost._cases = lambda quick: cases[:1]
suite = load()
claims = tuple(one for one in suite.claims if one.id == "V1")
small = replace(
    suite, claims=claims, sections=SECTIONS[-1:], problems=lambda quick: (), in_workers={},
    work_precision=lambda quick, report: None[0],
)
build(small, Options(quick=True, out=Path(sys.argv[1])))
"""


def insert(path: Path, before: str, text: str) -> None:
    """Put the text before the last such line of the file."""
    head, found, tail = path.read_text().rpartition(before)
    assert found, f"{path.name} has no {before!r}"
    path.write_text(f"{head}{text}{before}{tail}")


@pytest.fixture(scope="module")
def out(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The report of a copy to which all three were added."""
    copy = tmp_path_factory.mktemp("copy")
    for package in ("benchmarks", "reports"):
        ignored = shutil.ignore_patterns("*.pyc", "out")  # compiled kernels are taken along
        shutil.copytree(ROOT / package, copy / package, ignore=ignored)
    (copy / "reports" / "studies" / "mine.py").write_text(STUDY)
    contents = copy / "reports" / "contents.py"
    insert(contents, "\nCHECKS = ", "from reports.studies.mine import MINE\n")
    insert(contents, ")\n\n\ndef load", "    MINE,\n")
    catalogue = copy / "reports" / "figures" / "catalogue" / "oscillator_and_planets.py"
    insert(catalogue, ")  # fmt: skip", FIGURE)
    insert(copy / "benchmarks" / "work_precision" / "cost.py", ")\n\n\ndef cost_table", COLUMN)
    done = subprocess.run(
        [sys.executable, "-c", SHOW, str(copy / "out")], capture_output=True, text=True, cwd=copy,
        env=os.environ | {"PYTHONPATH": os.pathsep.join((str(copy), str(ROOT)))}, timeout=300,
    )  # fmt: skip
    assert done.returncode == 0, done.stdout + done.stderr
    return copy / "out"


@pytest.mark.slow
def test_a_study_is_a_file_and_an_entry(out: Path) -> None:
    assert (out / "mine.csv").read_text() == "n\n1\n2\n"
    assert (out / "tables" / "mine.md").exists()
    page = (out / "studies.html").read_text()
    assert '<h2 id="mine">My study</h2>' in page and "Two numbers." in page


@pytest.mark.slow
def test_a_figure_is_an_entry_of_the_catalogue(out: Path) -> None:
    assert (out / "figures" / "mine.svg").exists()
    assert "My figure" in (out / "claims.html").read_text()


@pytest.mark.slow
def test_a_column_of_the_cost_table_is_a_value(out: Path) -> None:
    assert (out / "cost.csv").read_text().splitlines()[0].endswith(",curves")
    page = (out / "comparisons.html").read_text()
    assert '<th scope="col" class="number">curves kept</th>' in page
