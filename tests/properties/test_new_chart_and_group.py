"""A new chart, or group, is one kernel file, one value and one entry: nothing else changes."""

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
CHART_MODULES = [MODULES[chart.number].__name__.rpartition(".")[2] for chart in CHARTS]
INDEX_OF_COPIED_CHART = CHARTS.index(galvi.ModifiedRodrigues())
KERNELS = {"charts": ("modified_rodrigues", "NewChart"), "groups": ("se2", "NewGroup")}  # copied
VALUES = {
    "charts": """
from dataclasses import dataclass
from typing import ClassVar

from galvi.charts.chart import ModifiedRodrigues
from galvi.kernels.lie.charts import another
from galvi.kernels.lie.dispatch import CHARTS


@dataclass(frozen=True)
class NewChart(ModifiedRodrigues):
    name: ClassVar[str] = "another"
    number: ClassVar[int] = CHARTS.index(another)
""",
    "groups": """
from dataclasses import dataclass

from galvi.groups.group import SE2
from galvi.kernels.lie.groups import another


@dataclass(frozen=True)
class NewGroup(SE2):
    _kernels = another
""",
}
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
assert (type(chart).__name__, type(GROUPS[-1]).__name__) == ("NewChart", "NewGroup")
for group in GROUPS:
    name = type(group).__name__
    if name != "Product":
        g = np.eye(group.shape[0]) if len(group.shape) == 2 else np.zeros(group.shape)
        xi, eta = np.linspace(0.3, -0.7, group.dimension), np.linspace(1.0, 2.0, group.dimension)
        element = place(chart, group, g, xi)
        assert np.array_equal(element, place(like, group, g, xi)), name
        assert np.allclose(coordinates(chart, group, g, element), xi, rtol=0.0, atol=1e-15), name
        slopes = np.zeros((2, xi.size))
        for tested, row in zip((chart, like), slopes):
            product.momentum_slope(group.layout, tested.number, xi, eta, np.ones(xi.size), row)
        assert np.any(slopes) == (name != "Rn") and np.array_equal(*slopes), name
assert {{type(chart), *map(type, GROUPS)}} <= set(storable_values().values())
"""


@pytest.mark.slow(
    beside="tests/suite/architecture/test_additions.py::test_every_row_names_folders_and_lists_that_exist"
)
def test_a_chart_and_a_group_are_each_a_kernel_file_a_value_and_an_entry(tmp_path):
    """Their modules come first in their folders, so that the numbers of all others change."""
    shutil.copytree(SOURCE, tmp_path / "galvi", ignore=shutil.ignore_patterns("__pycache__"))
    for folder, (like, name) in KERNELS.items():
        kernels, values = tmp_path / "galvi/kernels/lie" / folder, tmp_path / "galvi" / folder
        shutil.copy(kernels / f"{like}.py", kernels / "another.py")
        (values / "another.py").write_text(VALUES[folder])
        text = (values / "__init__.py").read_text().rstrip().removesuffix(")")
        imported = f"from galvi.{folder}.another import {name}\n"
        (values / "__init__.py").write_text(imported + f"{text}, {name}())\n")
    subprocess.run(  # by a Python without numba's compiler
        [
            sys.executable,
            "-c",
            USE.format(charts=[*CHART_MODULES, "another"], like=INDEX_OF_COPIED_CHART),
        ],
        cwd=tmp_path,
        env={**os.environ, "NUMBA_DISABLE_JIT": "1", "PYTHONPATH": str(tmp_path)},
        check=True,
    )
