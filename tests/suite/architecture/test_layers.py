"""The import contracts of pyproject.toml hold, and each catches a planted fault."""

from __future__ import annotations

import shutil
import subprocess
import sys
import tomllib
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[3]
PACKAGES = ("galvi", "references", "benchmarks", "reports")

# contract id: (a file, an import in it that the contract must catch)
FAULTS = {
    "folders": ("references/__init__.py", "import benchmarks"),
    "alone": ("galvi/arrays.py", "import sympy"),
    "engines": ("benchmarks/__init__.py", "import rebound"),
    "frames": ("references/__init__.py", "import pandas"),
    "pictures": ("benchmarks/__init__.py", "import matplotlib"),
    "kernels": ("galvi/kernels/forces/nbody.py", "import scipy"),
    "galvi": ("galvi/kernels/forces/nbody.py", "from galvi import arrays"),
    "references": ("references/newton.py", "from references.scipy import ivp"),
    "independent": ("references/newton.py", "from galvi.kernels.forces import nbody"),
    "benchmarks": ("benchmarks/store/tables.py", "from benchmarks.studies import scaling"),
    "reports": ("reports/tables/writing.py", "from reports.figures import picture"),
    "cycles": ("galvi/spaces/polynomials.py", "from galvi.spaces import fourier"),
}


def lint_imports(folder: Path, *contracts: str) -> subprocess.CompletedProcess[str]:
    command = "from importlinter.cli import lint_imports_command; lint_imports_command()"
    options = [word for contract in contracts for word in ("--contract", contract)]
    return subprocess.run(
        [sys.executable, "-c", command, "--no-cache", "--no-logo", *options],
        cwd=folder,
        capture_output=True,
        text=True,
    )


@pytest.fixture
def copy(tmp_path: Path) -> Path:
    """A folder with the four packages and their contracts, to plant faults in."""
    for package in PACKAGES:
        shutil.copytree(
            ROOT / package, tmp_path / package, ignore=shutil.ignore_patterns("__pycache__", "out")
        )
    shutil.copy(ROOT / "pyproject.toml", tmp_path)
    return tmp_path


def test_every_import_contract_holds() -> None:
    completed = lint_imports(ROOT)
    assert completed.returncode == 0, completed.stdout + completed.stderr


def test_every_import_contract_has_a_planted_fault() -> None:
    settings = tomllib.loads((ROOT / "pyproject.toml").read_text())["tool"]["importlinter"]
    assert {contract["id"] for contract in settings["contracts"]} == set(FAULTS)


@pytest.mark.slow(beside="test_an_upward_import_for_types_or_inside_a_function_counts")
def test_a_forbidden_import_breaks_its_contract(copy: Path) -> None:
    for contract, (file, fault) in FAULTS.items():
        text = (copy / file).read_text()
        (copy / file).write_text(f"{text}\n{fault}\n")
        completed = lint_imports(copy, contract)
        (copy / file).write_text(text)
        assert completed.returncode == 1, contract
        assert fault.split()[-1] in completed.stdout.partition("Broken contracts")[2], contract


def test_an_upward_import_for_types_or_inside_a_function_counts(copy: Path) -> None:
    for file, fault in (
        (
            "rules/rule",
            "from typing import TYPE_CHECKING\nif TYPE_CHECKING:\n    from galvi import run\n",
        ),
        ("spaces/space", "def later():\n    from galvi import run\n    return run\n"),
    ):
        with (copy / "galvi" / f"{file}.py").open("a") as source:
            source.write(f"\n{fault}")
    completed = lint_imports(copy, "galvi")
    assert completed.returncode == 1
    assert "galvi.rules.rule -> galvi.run" in completed.stdout
    assert "galvi.spaces.space -> galvi.run" in completed.stdout


@pytest.mark.slow(beside="test_an_upward_import_for_types_or_inside_a_function_counts")
def test_a_module_outside_the_layers_of_its_package_is_refused(copy: Path) -> None:
    for package in PACKAGES:
        stray = copy / package / "stray.py"
        stray.touch()
        completed = lint_imports(copy, package)
        assert completed.returncode == 1 and f"{package}.stray" in completed.stdout
        stray.unlink()
