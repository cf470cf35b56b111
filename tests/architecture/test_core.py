"""The core runs alone, and imports nothing of what makes it fast."""

from __future__ import annotations

import ast
import os
import subprocess
import sys
import tomllib
from pathlib import Path

import pytest

import galvi

ROOT = Path(__file__).parents[2]
RUN = """
import sys
import numpy as np
import galvi

method = galvi.Galerkin(galvi.Polynomials(6), galvi.gauss(6))
ready = galvi.problems
for problem in (ready.kepler(0.6), ready.pendulum_3d(), ready.double_pendulum()):
    run = galvi.integrate(problem, method, 0.05, 20)
    assert run.success and run.engine == {engine!r}, (problem.name, run.engine, run.status)
    print(repr(float(np.sum(run.q[-1]))))
fast = [name for name in sys.modules if name.startswith("galvi.fast")]
assert bool(fast) is (galvi.FAST), fast
if not galvi.FAST:
    assert not any(name.startswith("galvi.ensembles") for name in sys.modules)
"""


def told(code: str, fast: str) -> str:
    done = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, cwd=ROOT,
        env={**os.environ, "GALVI_FAST": fast, "PYTHONPATH": str(ROOT)},
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
    return done.stdout


def module_file(name: str) -> Path | None:
    path = ROOT / name.replace(".", "/")
    files = (path.with_suffix(".py"), path / "__init__.py")
    return next((one for one in files if one.is_file()), None)


def behind(start: str) -> dict[str, Path]:
    """The modules of galvi that one imports, directly or not, also inside functions."""
    found: dict[str, Path] = {}
    left = [start]
    while left:
        name = left.pop()
        file = module_file(name)
        if file is None or name in found:
            continue
        found[name] = file
        for node in ast.walk(ast.parse(file.read_text(encoding="utf-8"))):
            if isinstance(node, ast.ImportFrom) and (node.module or "").startswith("galvi"):
                left += [] if node.module == "galvi" else [str(node.module)]
                left += [f"{node.module}.{one.name}" for one in node.names]
            elif isinstance(node, ast.Import):
                left += [one.name for one in node.names if one.name.startswith("galvi.")]
    return found


def test_what_integrate_needs_is_the_core() -> None:
    found = behind("galvi.run.integrate")
    settings = tomllib.loads((ROOT / "pyproject.toml").read_text())["tool"]["importlinter"]
    core = next(one for one in settings["contracts"] if one["id"] == "core")
    assert {name for name in found if name.startswith(("galvi.fast", "galvi.ensembles"))} == set()
    assert {".".join(name.split(".")[:2]) for name in found} <= set(core["source_modules"])
    assert "galvi.tableau" in found


def test_the_core_runs_alone_and_agrees_with_what_is_fast() -> None:
    alone = told(RUN.format(engine="general"), "0").split()
    beside = told(RUN.format(engine="lanes"), "1").split()
    assert len(alone) == 3
    for one, other in zip(alone, beside, strict=True):
        assert abs(float(one) - float(other)) < 1e-13


def test_without_fast_its_names_are_refused_in_words() -> None:
    code = (
        "import galvi\n"
        "for name in galvi.IN_FAST:\n"
        "    assert name not in galvi.__all__\n"
        "    try: getattr(galvi, name)\n"
        "    except AttributeError as error: print(error)\n"
        "    else: raise AssertionError(name)\n"
        "try: galvi.Lagrangian.from_sympy('L')\n"
        "except ImportError as error: print(error)\n"
    )
    said = told(code, "0").splitlines()
    assert said[-1] == "Lagrangian.from_sympy needs galvi.fast, without GALVI_FAST=0."
    assert "galvi.KeplerFrame needs galvi.fast, which GALVI_FAST=0 leaves out." in said


REFUSED = """
import galvi
try:
    galvi.load({run!r})
except ValueError as error:
    print(error)
"""


@pytest.mark.slow(beside="test_without_fast_its_names_are_refused_in_words")
def test_a_saved_run_in_a_frame_is_refused_in_words(tmp_path: Path) -> None:
    frame = galvi.Galerkin(galvi.Polynomials(4), galvi.gauss(4), chart=galvi.KeplerFrame())
    run = str(tmp_path / "run.npz")
    galvi.save(galvi.integrate(galvi.problems.solar_system(), frame, 10.0, 5), run)
    assert told(REFUSED.format(run=run), "0").strip() == (
        f"the run in {run} has a KeplerFrame, which needs galvi.fast: GALVI_FAST=0 leaves it out."
    )


def test_a_mistyped_setting_is_refused() -> None:
    with pytest.raises(AssertionError, match=r"GALVI_FAST must be 0 or 1; received '2'\."):
        told("import galvi", "2")
