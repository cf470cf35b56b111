"""The general kernel runs alone, and no module fills what another one holds."""

from __future__ import annotations

import ast
import os
import re
import subprocess
import sys
from pathlib import Path

import pytest

import galvi

ROOT = Path(__file__).parents[3]
RUN = """
import numpy as np
import galvi
from galvi.run.engines import ENGINES
from galvi.systems.traces import NO_TRACES, traces

assert [engine.name for engine in ENGINES] == {engines!r}
method = galvi.Galerkin(galvi.Polynomials(6), galvi.gauss(6))
ready = galvi.problems
for problem in (ready.kepler(0.6), ready.pendulum_3d(), ready.double_pendulum()):
    run = galvi.integrate(problem, method, 0.05, 20)
    assert run.success and run.engine == {engine!r}, (problem.name, run.engine, run.status)
    print(repr(float(np.sum(run.q[-1]))))
own = galvi.Problem(galvi.Canonical(1.0, lambda q: 1.0 - np.cos(q[0])), [1.0], [0.0])
clocked = galvi.Galerkin(galvi.Polynomials(6), galvi.gauss(6), clock=galvi.Sundman())
for problem, chosen in ((own, method), (ready.kepler(0.6), clocked)):
    run = galvi.integrate(problem, chosen, 0.05, 20)
    assert run.success, run.status
    print(repr(float(np.sum(run.q[-1]))))
assert (traces(own.system) is NO_TRACES) is not galvi.FAST
"""
REFUSED = """
import galvi
frame = galvi.Galerkin(galvi.Polynomials(4), galvi.gauss(4), chart=galvi.KeplerFrame())
try:
    galvi.integrate(galvi.problems.solar_system(), frame, 10.0, 5)
except ValueError as error:
    print(error)
"""
FILLS = ("append", "extend", "update", "add", "insert", "register", "setdefault", "__setitem__")


def output(code: str, fast: str) -> str:
    done = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, cwd=ROOT,
        env={**os.environ, "GALVI_FAST": fast, "PYTHONPATH": str(ROOT)},
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
    return done.stdout


def test_the_general_kernel_runs_alone_and_agrees_with_the_other_engines() -> None:
    alone = output(RUN.format(engines=["general"], engine="general"), "0").split()
    names = ["clock", "frame", "lanes", "general"]
    beside = output(RUN.format(engines=names, engine="lanes"), "1").split()
    assert len(alone) == len(beside) == 5
    for one, other in zip(alone, beside, strict=True):
        assert abs(float(one) - float(other)) < 1e-13


def test_alone_it_refuses_moving_frames_in_words() -> None:
    sentence = "moving frames need the lanes, which GALVI_FAST=0 leaves out."
    assert output(REFUSED, "0").strip() == sentence


def test_a_mistyped_setting_is_refused() -> None:
    with pytest.raises(AssertionError, match=r"GALVI_FAST must be 0 or 1; received '2'\."):
        output("import galvi", "2")


def filled_at_import(source: str) -> list[str]:
    """Statements of a module that call something, or change what another name holds, when it is
    imported."""
    found = []
    for node in ast.parse(source).body:
        if isinstance(node, ast.Expr) and isinstance(node.value, ast.Call):
            called = node.value.func
            if isinstance(called, ast.Name) or (
                isinstance(called, ast.Attribute) and called.attr in FILLS
            ):
                found.append(ast.unparse(node))
        targets = node.targets if isinstance(node, ast.Assign) else []
        if any(isinstance(target, ast.Attribute | ast.Subscript) for target in targets):
            found.append(ast.unparse(node))
        if isinstance(node, ast.For | ast.While) and "setattr" in ast.unparse(node):
            found.append(ast.unparse(node))
    return found


def test_no_module_of_galvi_fills_what_another_one_holds() -> None:
    found = {
        path.relative_to(ROOT).as_posix(): filled
        for path in sorted((ROOT / "galvi").rglob("*.py"))
        if (filled := filled_at_import(path.read_text(encoding="utf-8")))
    }
    assert found == {}


@pytest.mark.parametrize(
    "planted",
    ["ENGINES.append(mine)", "Trajectory.plot_of = plot", "FAST[:] = [mine]", "register()",
     "for name in NAMES:\n    setattr(Trajectory, name, Later(name))"],
)  # fmt: skip
def test_a_hook_is_found(planted: str) -> None:
    assert filled_at_import(planted) == [planted]


def test_the_page_on_a_call_names_files_and_objects_that_there_are() -> None:
    page = (ROOT / "docs" / "life_of_a_call.md").read_text(encoding="utf-8")
    quoted = set(re.findall(r"`([^`\n]+)`", page))
    paths = {word for word in quoted if "/" in word and word.isascii() and "NAME" not in word}
    assert len(paths) > 20 and [path for path in paths if not (ROOT / path).exists()] == []
    sources = "\n".join(
        path.read_text(encoding="utf-8")
        for folder in ("galvi", "references", "benchmarks", "tests")
        for path in (ROOT / folder).rglob("*.py")
    )
    names = {word for word in quoted if re.fullmatch(r"[A-Za-z_]\w+", word)}
    missing = [name for name in sorted(names) if not re.search(rf"\b{name}\b", sources)]
    assert len(names) > 25 and missing == []


def test_fast_says_whether_other_engines_are_asked() -> None:
    assert galvi.FAST is (os.environ.get("GALVI_FAST", "1") != "0")
