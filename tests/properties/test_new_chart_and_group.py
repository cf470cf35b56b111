"""A new chart, or group, is one kernel file, one value and one entry: nothing else changes."""

import ast
import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

import galvi
from galvi.charts import CHARTS
from galvi.kernels.lie.dispatch import CHARTS as MODULES

SOURCE = Path(galvi.__file__).parent
NOW = [MODULES[chart.number].__name__.rpartition(".")[2] for chart in CHARTS]
LIKE = CHARTS.index(galvi.ModifiedRodrigues())
USE = """
import numpy as np
from galvi.charts import CHARTS
from galvi.charts.chart import coordinates, place
from galvi.kernels.lie import product
from galvi.groups import GROUPS
from galvi.kernels.lie.dispatch import CHARTS as MODULES
from galvi.run.saving.files import storable_values

assert [MODULES[chart.number].__name__.rpartition(".")[2] for chart in CHARTS] == {charts}
chart, like = CHARTS[-1], CHARTS[{like}]
for group in GROUPS:
    name = type(group).__name__
    if name != "Product":
        g = np.eye(group.shape[0]) if len(group.shape) == 2 else np.zeros(group.shape)
        xi, eta = np.linspace(0.3, -0.7, group.dimension), np.linspace(1.0, 2.0, group.dimension)
        there = place(chart, group, g, xi)
        assert np.array_equal(there, place(like, group, g, xi)), name
        assert np.allclose(coordinates(chart, group, g, there), xi, rtol=0.0, atol=1e-15), name
        slopes = np.zeros((2, xi.size))
        for each, row in zip((chart, like), slopes):
            product.momentum_slope(group.layout, each.number, xi, eta, np.ones(xi.size), row)
        assert np.any(slopes) == (name != "Rn") and np.array_equal(*slopes), name
stored = set(storable_values().values())
assert type(chart) in stored and {{type(group) for group in GROUPS}} <= stored
print(type(chart).__name__, [type(group).__name__ for group in GROUPS])
"""


def copied(old, new, names, only=""):
    """A file of the package under another name, with other words in it; of a file with several
    classes only the one of this name, and their bases."""
    text = old.read_text()
    if only:
        parts = [one for one in ast.parse(text).body
                 if not isinstance(one, ast.ClassDef)
                 or one.name in (only, "_Matrices", "_Motions")]  # fmt: skip
        text = "\n".join(map(ast.unparse, parts))
    for one, other in names.items():
        text = text.replace(one, other)
    new.write_text(text)


def entered(path, imported, before, after):
    """One more entry in the tuple of an __init__.py."""
    text = path.read_text()
    assert before in text
    path.write_text(imported + text.replace(before, after))


def outcome(folder, charts):
    """What a Python without numba's compiler says of the copy."""
    return subprocess.run(
        [sys.executable, "-c", USE.format(charts=charts, like=LIKE)],
        cwd=folder,
        env={**os.environ, "NUMBA_DISABLE_JIT": "1", "PYTHONPATH": str(folder)},
        capture_output=True,
        text=True,
        check=False,
    )


@pytest.fixture
def copy(tmp_path):
    """The package, to add to."""
    shutil.copytree(SOURCE, tmp_path / "galvi", ignore=shutil.ignore_patterns("__pycache__"))
    return tmp_path


@pytest.mark.slow(
    beside="tests/suite/architecture/test_additions.py::test_every_row_names_folders_and_lists_that_exist"
)
def test_a_chart_is_a_kernel_file_a_value_and_an_entry(copy):
    """Its name comes first in its folder, so that all other numbers change."""
    names = {"modified_rodrigues": "another", "ModifiedRodrigues": "Another"}
    folder = copy / "galvi/kernels/lie/charts"
    copied(folder / "modified_rodrigues.py", folder / "another.py", names)
    folder = copy / "galvi/charts"
    copied(folder / "chart.py", folder / "another.py", names, "ModifiedRodrigues")
    entries = copy / "galvi/charts/__init__.py"
    text = entries.read_text().rstrip().removesuffix(")") + ", Another())\n"
    entries.write_text("from galvi.charts.another import Another\n" + text)
    found = outcome(copy, [*NOW, "another"])
    assert found.returncode == 0, found.stderr
    assert found.stdout.startswith("Another")


@pytest.mark.slow(
    beside="tests/suite/architecture/test_additions.py::test_every_row_names_folders_and_lists_that_exist"
)
def test_a_group_is_a_kernel_file_a_value_and_an_entry(copy):
    names = {"se2,": "another,", "kernels = se2": "kernels = another", "SE2": "Another"}
    folder = copy / "galvi/kernels/lie/groups"
    copied(folder / "se2.py", folder / "another.py", names)
    folder = copy / "galvi/groups"
    copied(folder / "group.py", folder / "another.py", names, "SE2")
    entered(
        copy / "galvi/groups/__init__.py",
        "from galvi.groups.another import Another\n",
        "SE3(), Product",
        "SE3(), Another(), Product",
    )
    found = outcome(copy, NOW)
    assert found.returncode == 0, found.stderr
    assert "'Another'" in found.stdout
