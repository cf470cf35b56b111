"""Faults planted in another project's integrators, and where `track --against` sees them.

`python -m pytest tests/suite/reports/test_track_plants.py -m slow -s` prints the table.
"""

from __future__ import annotations

import json
from dataclasses import dataclass
from pathlib import Path

import pytest

from reports.cli.track import track_command
from reports.tracking.tracked_problems import PROBLEMS
from tests.suite.reports.test_track_against import git

ADAPTIVE = Path(__file__).parents[3] / "docs" / "examples" / "adaptive.py"
YOSHIDA = """
import numpy as np
import galvi

A = np.array([0.78451361047755726382, 0.23557321335935813368, -1.17767998417887100695])
W = np.array([*A, 1.0 - 2.0 * A.sum(), *A[::-1]])


class Yoshida6:
    name = "Yoshida 6"
    order = 6

    def supports(self, problem):
        known = isinstance(problem.system, (galvi.Canonical, galvi.NBody))
        return known and getattr(problem.system, "force", None) is None

    def settings(self, problem, duration):
        return [{"step": duration / n, "save_every": n} for n in (60, 120, 240, 2000)]

    def run(self, problem, duration, setting):
        h, every, q, v = setting["step"], setting["save_every"], problem.q0, problem.v0
        saved, t = [(q, v)], problem.t0
        steps = round(duration / h)
        for k in range(steps):
            for w in W:
                q = q + 0.5 * w * h * v
                v = v + w * h * problem.system.acceleration(q, t + 0.5 * w * h)
                q = q + 0.5 * w * h * v
                t = t + w * h
            t = problem.t0 + (k + 1) * h
            saved += [(q, v)] if (k + 1) % every == 0 else []
        q, v = np.swapaxes(saved, 0, 1)
        times, p = problem.t0 + h * every * np.arange(len(q)), problem.system.momentum(v)
        counts = {"steps": steps, "force_evaluations": len(W) * steps}
        return galvi.Trajectory(problem, times, q, p, counts=counts)
"""
DRIFT = "                q = q + 0.5 * w * h * v\n"
KICK = "                v = v + w * h * problem.system.acceleration(q, t + 0.5 * w * h)\n"
STEP = "            t = problem.t0 + (k + 1) * h\n"
START = "        saved, t = [(q, v)], problem.t0\n"
SLEEP = "import time; time.sleep(9999)"
LEAK = "        KEPT.append(np.ones(2_500_000))\n"
WASTE = "                for _ in range({}):\n                    q * v\n"


@dataclass(frozen=True)
class Plant:
    """Edits of a module (text, other text), the exit status, and the gates that may see it.

    min_problems  smallest number of problems that must show it
    """

    name: str
    edits: tuple[tuple[str, str], ...]
    status: int = 1
    gates: tuple[str, ...] = ()
    min_problems: int = 1
    module: str = "yoshida"
    timeout: float = 60.0


def insert(after, line):
    return ((after, after + line),)


PLANTS = (
    Plant("nothing", insert("import galvi\n", "# a comment\n"), 0),
    Plant(
        "other last bits",
        (
            (
                f"{DRIFT}                v",
                DRIFT.replace("0.5 * w * h", "(h * w) * 0.5") + " " * 16 + "v",
            ),
            ("v + w * h * problem.system", "v + h * (w * problem.system"),
            ("(q, t + 0.5 * w * h)", "(q, t + 0.5 * w * h))"),
        ),
        0,
    ),
    Plant("adaptive, nothing", insert("import galvi\n", "# a comment\n"), 0, module="adaptive"),
    Plant(
        "adaptive, rtol x 1000",
        (('"rtol": setting', '"rtol": 1e3 * setting'),),
        gates=("error",),
        module="adaptive",
    ),
    Plant(
        "order 6 to 4",
        (
            (
                "W = np.array([*A, 1.0 - 2.0 * A.sum(), *A[::-1]])",
                "W = np.array([1.3512071919596578, -1.7024143839193153, 1.3512071919596578])",
            ),
        ),
        gates=("error",),
        min_problems=5,
    ),
    Plant(
        "a coefficient + 1e-7",
        (("0.78451361047755726382", "0.78451371047755726382"),),
        gates=("error",),
        min_problems=4,
    ),
    Plant("-h", insert(START, "        h = -h\n"), gates=("error", "status"), min_problems=6),
    Plant("a(q, -t)", (("(q, t + 0.5 * w * h)", "(q, -(t + 0.5 * w * h))"),), gates=("error",)),
    Plant(
        "NaN after step 1500",
        insert(STEP, "            q = q if k < 1500 else q + np.nan\n"),
        gates=("error",),
        min_problems=6,
    ),
    Plant(
        "NaN after step 3000",
        insert(STEP, "            q = q if k < 3000 else q + np.nan\n"),
        gates=("error",),
    ),
    Plant("30 % more time", insert(KICK, WASTE.format(4)), gates=("time",), min_problems=3),
    Plant(
        "a leak of 20 MB",
        (("\n\nclass", "\n\nKEPT = []\n\n\nclass"), (START, LEAK + START)),
        gates=("memory",),
        min_problems=6,
    ),
    Plant(
        "a leak of 16 kB a step",
        (
            ("\n\nclass", "\n\nKEPT = []\n\n\nclass"),
            (STEP, f"{STEP}            KEPT.append(bytearray(b'1' * 16_384))\n"),
        ),
        gates=("memory",),
    ),
    Plant(
        "200 MB more for a while",
        insert(START, "        np.ones(25_000_000)\n"),
        gates=("memory",),
        min_problems=6,
    ),
    Plant(
        "noise of 1e-14",
        insert(KICK, "                v = v + 1e-14 * np.random.rand()\n"),
        gates=("not deterministic",),
        min_problems=6,
    ),
    Plant(
        "hash('a')",
        insert(START, "        q = q + 1e-15 * (hash('a') % 1000)\n"),
        gates=("not deterministic",),
        min_problems=5,
    ),
    Plant(
        "sleeps for ever",
        insert(START, f"        {SLEEP}\n"),
        gates=("status",),
        min_problems=6,
        timeout=20.0,
    ),
    Plant(
        "sleeps after step 3000",
        insert(STEP, f"            if k > 3000: {SLEEP}\n"),
        gates=("status",),
        timeout=20.0,
    ),
)


def adaptive():
    """The integrator that adapts its steps, as docs/suite.md shows it."""
    return ADAPTIVE.read_text(encoding="utf-8")


@pytest.fixture
def repository(tmp_path, monkeypatch: pytest.MonkeyPatch):
    """The src folder of the current folder, a repository with both integrators."""
    src = tmp_path / "project" / "src"
    src.mkdir(parents=True)
    (src / "yoshida.py").write_text(YOSHIDA)
    (src / "adaptive.py").write_text(adaptive())
    git(src.parent, "init", "--quiet")
    git(src.parent, "add", ".")
    git(src.parent, "commit", "--quiet", "-m", "first")
    monkeypatch.chdir(src.parent)
    monkeypatch.syspath_prepend(str(src))
    return src


CLASSES = {"yoshida": "yoshida:Yoshida6", "adaptive": "adaptive:Adaptive"}


def replaced(text, plant):
    for old, new in plant.edits:
        assert text.count(old) == 1, (plant.name, text.count(old), old)
        text = text.replace(old, new)
    compile(text, plant.module, "exec")
    return text


@pytest.mark.parametrize("plant", PLANTS, ids=lambda plant: plant.name)
def test_a_plant_finds_its_place(plant):
    replaced(YOSHIDA if plant.module == "yoshida" else adaptive(), plant)


@pytest.mark.slow(beside="test_track_gates.py::test_a_change_is_red_at_its_gate_alone")
@pytest.mark.parametrize("plant", PLANTS, ids=lambda plant: plant.name)
def test_a_planted_fault_is_seen_and_equal_code_is_not(repository, tmp_path, monkeypatch, plant):
    if plant.status and "time" not in plant.gates:
        monkeypatch.setattr("reports.tracking.against.interleave", lambda *_: None)
    module = repository / f"{plant.module}.py"
    module.write_text(replaced(module.read_text(), plant))
    out = tmp_path / "out"
    status = track_command(
        out, {}, "HEAD", (), False, False, (CLASSES[plant.module],), plant.timeout
    )
    rows = json.loads((out / "against.json").read_text())["benchmarks"]
    alarms = {row["name"]: [gate for gate in row["alarms"] if gate in plant.gates] for row in rows}
    print(f"\n{plant.name} | {status}")
    for row in rows:
        print(f"    {row['name']} | {row['alarms'] or 'not worse'} | {row['notes']}")
    assert status == plant.status
    if plant.gates:
        assert sum(map(bool, alarms.values())) >= plant.min_problems, alarms


def test_each_problem_tracked_is_one_that_moves_at_its_start():
    """At rest, a reversed time gives the same motion."""
    from benchmarks.timings.worker import problem_of

    problems = {case.name: problem_of(vars(case)) for case in PROBLEMS}
    assert all(abs(problem.v0).max() > 0.0 for problem in problems.values())
    assert any(problem.t0 for problem in problems.values())
