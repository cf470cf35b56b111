"""The kit: its truths have two sources, its tests need no galvi and see planted faults."""

from __future__ import annotations

import hashlib
import json
import math
import re
import shutil
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import galvi
from benchmarks.applications.kit.models import all_models
from benchmarks.applications.kit.point_masses import (
    ARENSTORF_PERIOD,
    ARENSTORF_START,
    all_point_masses,
)
from benchmarks.applications.kit.truths import LARGEST_DISAGREEMENT, Source, agreed_truth
from benchmarks.store.isolated_environment import EnvironmentUnavailable, environment
from references import IAS15, MUJOCO_RK4
from reports.tables import kit as kit_files

ROOT = Path(__file__).parents[3]
SMALL_KIT_NAMES = {
    "two_bodies_e03",
    "figure_eight",
    "retrograde_planet",
    "pendulum",
    "free_body",
    "heavy_top",
}
COMPILER = shutil.which("g++")
OLD = "mujoco==3.17.0"  # whose RK4 turns bodies with order 2
needs_engines = pytest.mark.skipif(
    bool(IAS15.missing or MUJOCO_RK4.missing), reason=IAS15.missing or MUJOCO_RK4.missing or "here"
)
needs_compiler = pytest.mark.skipif(COMPILER is None, reason="there is no g++ here")
MIDPOINT = """
import mujoco
step = mujoco.mj_step
def midpoint(model, data, nstep):
    h = model.opt.timestep
    if model.opt.integrator != mujoco.mjtIntegrator.mjINT_RK4:
        return step(model, data, nstep)
    for _ in range(nstep):
        q, v = data.qpos.copy(), data.qvel.copy()
        mujoco.mj_forward(model, data)
        mujoco.mj_integratePos(model, data.qpos, v, h / 2)
        data.qvel[:] = v + h / 2 * data.qacc
        mujoco.mj_forward(model, data)
        mujoco.mj_integratePos(model, q, data.qvel, h)
        data.qpos[:], data.qvel[:] = q, v + h * data.qacc
mujoco.mj_step = midpoint
"""
WRONG_G = """
import rebound
integrate = rebound.Simulation.integrate
def integrate_with_another_constant(simulation, t):
    simulation.G *= 1 + 1e-6
    integrate(simulation, t)
rebound.Simulation.integrate = integrate_with_another_constant
"""


@pytest.fixture(scope="module")
def small_kit(tmp_path_factory):
    """A kit of a few problems and models."""
    folder = tmp_path_factory.mktemp("kit")
    with pytest.MonkeyPatch.context() as patch:
        for name, make in (("all_point_masses", all_point_masses), ("all_models", all_models)):
            cases = tuple(case for case in make() if case.name in SMALL_KIT_NAMES)
            patch.setattr(kit_files, name, lambda few=cases: few)
        return kit_files.write_kit(folder)


@pytest.fixture
def copied(small_kit, tmp_path):
    """A kit in which faults may be planted."""
    return Path(shutil.copytree(small_kit, tmp_path / "kit"))


def run_test(
    kit_folder: Path, name: str, python: str = sys.executable, before: str = ""
) -> tuple[int, str]:
    """The exit status and stderr of a test, in a process without galvi."""
    path = kit_folder / "tests" / f"test_{name}.py"
    path.write_text(before + path.read_text(), "utf-8")
    completed = subprocess.run(
        [python, "-I", str(path)], cwd=kit_folder, capture_output=True, text=True
    )
    return completed.returncode, completed.stderr


def run_table_test(kit_folder: Path, folder: Path) -> int:
    """The exit status of the test in C++."""
    program, source = folder / "test_table", kit_folder / "tests" / "test_table.cpp"
    subprocess.run([str(COMPILER), "-o", program, source], check=True)
    return subprocess.run([program, kit_folder / "point_masses/two_bodies_e03.txt"]).returncode


def failures(text: str) -> set[tuple[str, str]]:
    """(problem or model, further parameters) of each subtest that failed in a text of unittest."""
    return set(re.findall(r"^FAIL: .*\[(.*)\] \((.*)\)$", text, re.MULTILINE))


def edited(path: Path, old: str, new: str) -> None:
    text = path.read_text()
    assert text.count(old) == 1
    path.write_text(text.replace(old, new))


@needs_engines
@pytest.mark.parametrize("name", ["rebound", "mujoco", "plain"])
def test_the_kit_s_tests_pass_without_galvi(copied, name):
    status, text = run_test(copied, name)
    assert status == 0, text
    assert "galvi" not in (ROOT / f"docs/kit/test_{name}.py").read_text()


@needs_engines
@needs_compiler
def test_the_table_is_read_without_a_library(copied, tmp_path):
    assert run_table_test(copied, tmp_path) == 0
    table = copied / "point_masses/two_bodies_e03.txt"
    table.write_text(table.read_text().replace(" 0.25 ", " 0.250001 "))
    assert run_table_test(copied, tmp_path) == 1  # the mass of a body is off by 4e-6


@needs_engines
@pytest.mark.parametrize(
    ("file", "old", "new", "name", "faulty"),
    [
        (
            "point_masses/figure_eight.json",
            '"G": 1.0',
            '"G": 1.000000001',
            "rebound",
            "figure_eight",
        ),
        (
            "point_masses/two_bodies_e03.json",
            '{"m": 0.25',
            '{"m": 0.250000001',
            "rebound",
            "two_bodies_e03",
        ),
        ("models/free_body.xml", ".5 .5 -.5 .5", ".5 -.5 .5 -.5", "mujoco", "free_body"),
        ("models/heavy_top.xml", 'mass="1"', 'mass="1.001"', "mujoco", "heavy_top"),
    ],
    ids=["G off by 1e-9", "mass of a point", "transposed quaternion", "mass of a body"],
)
def test_a_planted_fault_is_seen_where_it_is(copied, file, old, new, name, faulty):
    edited(copied / file, old, new)
    status, text = run_test(copied, name)
    assert status == 1 and {problem for problem, _ in failures(text)} == {faulty}


@needs_engines
def test_a_runge_kutta_method_of_order_2_is_seen_on_every_model(copied):
    status, text = run_test(copied, "mujoco", before=MIDPOINT)
    models = ("free_body", "heavy_top", "pendulum")
    assert status == 1 and failures(text) == {(name, "integrator='RK4'") for name in models}


@needs_engines
def test_an_engine_with_the_wrong_constant_is_seen_on_every_problem(copied):
    status, text = run_test(copied, "rebound", before=WRONG_G)
    names = {name for name, _ in failures(text)}
    assert status == 1 and names == {"figure_eight", "retrograde_planet", "two_bodies_e03"}


@needs_engines
@pytest.mark.parametrize(
    ("name", "old", "new"),
    [
        ("plain", "in range(count):", "in range(count + 1):"),
        ("plain", "step / 2)\n    return", "step)\n    return"),
        ("plain", "** 3", "** 2.999"),
        ("mujoco", "timestep = step", "timestep = 1.0001 * step"),
        ("mujoco", "mujoco.mj_resetDataKeyframe(model, data, 0)", "pass"),
    ],
    ids=["a step too many", "last drift", "power of the distance", "step", "no keyframe"],
)
def test_a_faulty_integrator_fails(copied, name, old, new):
    edited(copied / "tests" / f"test_{name}.py", old, new)
    assert run_test(copied, name)[0] == 1


@needs_engines
@needs_compiler
@pytest.mark.parametrize(
    ("old", "new"),
    [("-step * gm", "-step * first.gm"), ("add(position, step / 2, velocity);\n    }", "}")],
    ids=["mass", "drift"],
)
def test_a_faulty_integrator_in_cpp_fails(copied, tmp_path, old, new):
    edited(copied / "tests/test_table.cpp", old, new)
    assert run_table_test(copied, tmp_path) == 1


@needs_engines
def test_the_manifest_has_the_digest_of_every_file_and_no_licence_is_invented(small_kit):
    manifest = json.loads((small_kit / "manifest.json").read_text())
    paths = [path for path in small_kit.rglob("*") if path.is_file()]
    digests = {
        str(path.relative_to(small_kit)): hashlib.sha256(path.read_bytes()).hexdigest()
        for path in paths
        if path.name != "manifest.json"
    }
    assert manifest["sha256"] == digests
    assert manifest["format"] == 1 and manifest["galvi"] == galvi.__version__
    assert "no licence file" in manifest["licences"]["models, numbers and texts"]
    assert not [path for path in ROOT.iterdir() if path.name.lower().startswith("licen")]
    used = {
        key
        for kind in ("point_masses", "models")
        for name in manifest[kind]
        for key in json.loads((small_kit / kind / f"{name}.json").read_text())
    }
    described = {word for field in manifest["fields"] for word in field.split(", ")}
    assert used <= described


@needs_engines
def test_tables_and_json_hold_the_same_numbers(small_kit):
    case = json.loads((small_kit / "point_masses/retrograde_planet.json").read_text())
    table = np.loadtxt(small_kit / "point_masses/retrograde_planet.txt").reshape(-1, 3, 10)
    for truth, rows in zip(case["truth"], table[1:], strict=True):
        assert rows[:, 2:5].tolist() == truth["q"] and rows[:, 5:8].tolist() == truth["v"]
        assert set(rows[:, 8]) == {truth["error_q"]} and set(rows[:, 0]) == {truth["t"]}
    start = [[body[x] for x in ("m", "x", "y", "z", "vx", "vy", "vz")] for body in case["bodies"]]
    assert table[0, :, 1:8].tolist() == start


@needs_engines
def test_arenstorf_s_orbit_closes_after_the_published_period():
    case = next(case for case in all_point_masses() if case.name == "arenstorf")
    truth = case.truth()
    x, y = truth.q[-1, 2] @ [
        [math.cos(ARENSTORF_PERIOD), -math.sin(ARENSTORF_PERIOD)],
        [math.sin(ARENSTORF_PERIOD), math.cos(ARENSTORF_PERIOD)],
    ]
    assert len(truth.t) == 11 and math.hypot(x - ARENSTORF_START[0], y) < truth.error_q[-1]


def _sources(growth: float) -> tuple[Source, Source]:
    """Two sources whose distance grows as growth^k with the k-th time."""
    gap = 1e-13 * growth ** np.arange(11.0)[:, None, None]
    still = np.ones((11, 1, 2))
    first = Source("first", lambda problem, duration: (still, still))
    return first, Source("second", lambda problem, duration: (still + gap, still))


def test_times_at_which_sources_disagree_are_left_out_and_errors_never_fall():
    problem = galvi.Problem(galvi.NBody([1.0]), [[1.0, 1.0]], [[1.0, 1.0]], name="alone")
    truth = agreed_truth(problem, 1.0, _sources(10.0), problem)
    assert len(truth.t) == 4 and truth.error_q[0] == 0.0  # sqrt(2) 1e-9 comes at the fifth
    assert np.all(np.diff(truth.error_q) > 0.0)
    assert np.all(truth.error_q[1:] > 10.0 * math.sqrt(2.0) * 10.0 ** np.arange(-12.0, -9.0))
    assert truth.error_q[-1] < 20.0 * LARGEST_DISAGREEMENT
    with pytest.raises(ValueError, match="two sources of the truth of alone must agree"):
        agreed_truth(problem, 1.0, _sources(1e5), problem)


@needs_engines
def test_a_model_that_is_not_that_of_its_closed_form_has_no_truth(monkeypatch):
    model = next(model for model in all_models() if model.name == "pendulum")
    planted = replace(model)
    planted.__dict__["mjcf"] = model.mjcf.replace('mass="1"', 'mass="1.001"')
    assert len(planted.truth().t) == 11  # its closed form is that of what MuJoCo reads
    sources, differences = (model.sources[0], planted.sources[1]), (model.differences, np.subtract)
    with pytest.raises(ValueError, match="must agree"):
        agreed_truth(model.problem, 5.0, sources, model.problem, differences)


@pytest.mark.parametrize(
    ("command", "sentence"),
    [
        ("kit --format latex", "Kit takes only --to and --out; leave out --format"),
        ("kit --all", "Kit takes only --to and --out; leave out --all"),
        ("kit --to a.txt", "--to expects a folder to write in; received a.txt: File exists"),
        ("kit --to a.txt/kit", "--to expects a folder to write in; received a.txt/kit: Not a"),
        ("kit --to -", "--to expects a folder for kit; received -"),
        ("kit --to full", "Kit expects a new or empty folder, or an earlier kit; 'full' holds"),
        ("ratios --to full", "--to expects a file; received the folder 'full'"),
    ],
)
def test_what_the_kit_does_not_take_is_refused(ask, command, sentence):
    Path("a.txt").write_text("mine")
    Path("full").mkdir()
    Path("full/manifest.json").write_text('{"name": "of a web page"}')
    completed = ask(f"export {command}")
    assert completed.status == 2 and sentence in " ".join(completed.err.split())
    assert [path.name for path in Path("full").iterdir()] == ["manifest.json"]


def test_a_missing_engine_is_named_before_work_starts(ask, monkeypatch):
    monkeypatch.setitem(sys.modules, "rebound", None)
    completed = ask("export kit")
    assert completed.status == 3 and "rebound" in completed.err and not list(Path().rglob("*.json"))


@needs_engines
@pytest.mark.slow(beside="test_the_kit_s_tests_pass_without_galvi")
def test_the_whole_kit_is_small_its_tests_pass_and_an_old_mujoco_fails(ask, tmp_path):
    assert ask("export kit").status == 0
    kit_folder = Path("out/kit").absolute()
    assert sum(path.stat().st_size for path in kit_folder.rglob("*")) < 1e6
    for name in ("rebound", "mujoco", "plain"):
        status, text = run_test(kit_folder, name)
        assert status == 0, text
    try:
        with environment(OLD, tmp_path / "old") as python:
            status, text = run_test(kit_folder, "mujoco", str(python))
    except EnvironmentUnavailable as error:
        pytest.skip(f"{OLD} cannot be installed here: {error}")
    turning = {
        (model.name, "integrator='RK4'")
        for model in all_models()
        if 'type="ball"' in model.mjcf or "<freejoint" in model.mjcf
    }
    assert status == 1 and failures(text) == turning
