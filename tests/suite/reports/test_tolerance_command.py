"""`galvi tolerance`: what it prints and writes, its exit status, and what it refuses."""

from __future__ import annotations

import json
import re
import shlex
from dataclasses import replace
from itertools import product
from pathlib import Path

import numpy
import pandas as pd
import pytest

from benchmarks.applications.releases import tolerance as tolerances
from benchmarks.applications.releases.own_run import SAMPLES, read_own_run
from benchmarks.applications.releases.requirements import installed
from benchmarks.applications.releases.tolerance import Variant, measure
from galvi.interop.judge import JudgeRequest
from reports.cli.commands import run
from reports.tables.tolerance import atol, lines_to_paste, sentences
from tests.suite.benchmarks.planted_releases import EULER, planted

mujoco = pytest.importorskip("mujoco")
rebound = pytest.importorskip("rebound")
ROOT = Path(__file__).parents[3]
PAGE = (ROOT / "docs" / "judge.md").read_text()
(SHOWN,) = re.findall(r"```sh\ngalvi (tolerance [^\n]*)\n```\n```text\n(.*?)```", PAGE, re.DOTALL)
NUMBER = re.compile(r"\d+\.?\d*(?:e[-+]\d+)?|:-+")


@pytest.fixture
def folder(tmp_path, monkeypatch):
    """The current folder: empty but for a link to docs."""
    (tmp_path / "docs").symlink_to(ROOT / "docs")
    monkeypatch.chdir(tmp_path)
    return tmp_path


def exit_status(command):
    return run(None, shlex.split(command))  # type: ignore[arg-type]


def pasted(out):
    """The lines to paste."""
    return out[out.index("import json") : out.index("Written: ")].rstrip()


def test_the_command_of_the_page_says_what_the_page_shows(folder, capsys):
    command, shown = SHOWN
    assert exit_status(f"{command} --out galvi-out/tolerance") == 0
    out = capsys.readouterr().out
    if installed("mujoco") != "4.0.1" or "not tried" in out:
        pytest.skip("the page shows MuJoCo 4.0.1 on x86")
    printed = iter([NUMBER.sub("#", line) for line in out.splitlines()])
    for line in shown.splitlines():  # in this order; "..." is for what the page leaves out
        assert line == "..." or NUMBER.sub("#", line) in printed


def test_the_pasted_lines_pass_on_the_users_own_run_and_fail_on_a_fault(folder, capsys):
    assert exit_status("tolerance docs/models/heavy_top.xml --key 0 --duration 0.5 --out .") == 0
    lines = pasted(capsys.readouterr().out)
    model = mujoco.MjModel.from_xml_path("docs/models/heavy_top.xml")
    state = mujoco.MjData(model)
    mujoco.mj_resetDataKeyframe(model, state, 0)
    mujoco.mj_step(model, state, nstep=500)
    names = {"__file__": str(folder / "test_top.py"), "data": state}
    assert "# From the start after mujoco.mj_step(model, data, nstep=500) with steps of " in lines
    exec(lines, names)
    floors = pd.read_csv("tolerance.csv").iloc[-1]
    faults = [(state.qpos, "positions", k) for k in range(4)]
    faults += [(state.qvel, "velocities", k) for k in range(3)]
    for (values, name, k), sign in product(faults, (-1.0, 1.0)):
        correct = values.copy()
        values[k] += sign * 20.0 * floors[f"{name}_floor"]
        with pytest.raises(AssertionError, match="Not equal to tolerance"):
            exec(lines, names)
        values[:] = correct
    written = json.loads(Path("tolerance.json").read_text())
    assert written["seed"] == 0 and len(written["start"]["velocities"]) == 3
    assert written["expected"] == written["states"][-1] and written["provenance"]["cpu"]
    assert written["provenance"]["command"].startswith("python -m reports tolerance docs/models")
    assert written["paste"] == lines.splitlines() and len(written["bounds"]) == SAMPLES


def test_the_pasted_lines_pass_on_a_users_own_simulation_where_a_bound_holds(folder, capsys):
    """Three bodies that meet closely: at the end rounding is all, so that they compare earlier."""
    sim = rebound.Simulation()
    for mass, x, y in ((3.0, 1.0, 3.0), (4.0, -2.0, -1.0), (5.0, 1.0, -1.0)):
        sim.add(m=mass, x=x, y=y)
    sim.integrator = "ias15"
    sim.save_to_file("bodies.bin")
    assert exit_status("tolerance bodies.bin --duration 70 --out .") == 1
    out = capsys.readouterr().out
    assert "positions at t = 70: no bound, since rounding has grown to more than a thous" in out
    (latest,) = re.findall(r"^Compare at t = (\d+) instead, with a bound of ", out, re.MULTILINE)
    sim.integrate(float(latest))
    exec(pasted(out), {"__file__": str(folder / "test_bodies.py"), "sim": sim})


def test_another_release_is_named_with_what_to_do(folder, monkeypatch, capsys):
    monkeypatch.setattr(tolerances, "interpreter", planted(folder, {"3.17.0": EULER}))
    command = "tolerance docs/models/heavy_top.xml --key 0 --duration 0.1 --releases 3.17.0,3.18.0"
    assert exit_status(f"{command} --out .") == 1  # neither is known to be within the bounds
    out = capsys.readouterr().out
    (differs,) = [line for line in out.splitlines() if line.startswith("mujoco 3.17.0: your run")]
    assert re.search(r"differs by \S+e\+\d+ floors, which is more than rounding; ", differs)
    assert differs.endswith("`galvi versions` says what changed.")
    assert "mujoco 3.18.0: No matching distribution" in out


def test_runs_that_do_not_repeat_and_quantities_without_a_bound_are_said(folder):
    """A model whose ball touches the floor exactly; an engine that does not repeat is planted."""
    file = folder / "rest.xml"
    file.write_text(
        '<mujoco><worldbody><geom type="plane" size="5 5 .1"/><body pos="0 0 .1"><freejoint/>'
        '<geom size=".1" mass="1"/></body></worldbody></mujoco>'
    )
    users_run = read_own_run(file, JudgeRequest(duration=0.02))
    tolerance = measure(users_run, (), folder, lambda sentence: None)
    text = " ".join(sentences(tolerance))
    assert tolerance.latest == -1 and lines_to_paste(tolerance) == []
    assert (
        atol(tolerance, "positions", -1) == "" and "have no bound at any of the ten times" in text
    )
    assert "repeated: bit-identical." in text and "two threads: bit-identical." in text
    threads = Variant("two threads", numpy.full((2, 3, SAMPLES), 1e-9), floors=3.0)
    text = " ".join(sentences(replace(tolerance, variants=[threads])))
    assert (
        "two threads: not bit-identical, by up to 3 floors; the engine is not deterministic."
        in text
    )


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ("docs/models/heavy_top.xml --releases newest", "--releases expects releases as"),
        ("docs/models/heavy_top.xml --releases 3.6.0..4.0.1", "which is for `galvi versions`"),
        ("docs/models/heavy_top.xml --own integrator=rk5", "must be one of euler, rk4"),
        ("docs/models/heavy_top.xml --key 3", "Key must be"),
        ("docs/models/absent.xml", "docs/models/absent.xml"),
        ("fixed.xml", "Nothing can move in your model: it has no joints."),
        ("docs/models/heavy_top.xml --qvel 1e12,0,0", "Your run fails"),
    ],
)
def test_what_cannot_be_carried_out_is_exit_2_and_one_sentence(folder, arguments, message, capsys):
    (folder / "fixed.xml").write_text("<mujoco><worldbody/></mujoco>")
    assert exit_status(f"tolerance {arguments} --out out") == 2
    out, err = capsys.readouterr()
    assert out == "" and message in err.splitlines()[-1]
