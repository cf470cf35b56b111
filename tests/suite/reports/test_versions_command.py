"""`galvi versions`: what it prints and writes, its exit status, and what it refuses."""

from __future__ import annotations

import json
import re
import shlex
from pathlib import Path

import pandas as pd
import pytest

from benchmarks.applications.releases import versions
from benchmarks.applications.releases.requirements import installed
from reports.cli.commands import run
from tests.suite.benchmarks.planted_releases import EULER, FAILS, SAME, planted

pytest.importorskip("mujoco")
ROOT = Path(__file__).parents[3]
PAGE = (ROOT / "docs" / "judge.md").read_text()
(SHOWN,) = re.findall(r"```sh\ngalvi (versions [^\n]*)\n```\n```text\n(.*?)```", PAGE, re.DOTALL)
NUMBER = re.compile(r"\d+\.?\d*(?:e[-+]\d+)?")


@pytest.fixture
def folder(tmp_path, monkeypatch):
    """The current folder: empty but for a link to docs."""
    (tmp_path / "docs").symlink_to(ROOT / "docs")
    monkeypatch.chdir(tmp_path)
    return tmp_path


def test_sentences_a_table_and_json_say_what_changed_and_what_failed(folder, monkeypatch, capsys):
    faults = {"3.13.0": FAILS, "3.17.0": EULER, "3.18.0": SAME}
    monkeypatch.setattr(versions, "interpreter", planted(folder, faults))
    command = f"{SHOWN[0].partition(' --releases')[0]} --releases {','.join(faults)} --out out"
    assert run(None, shlex.split(command)) == 0  # type: ignore[arg-type]
    printed, newest = capsys.readouterr().out, installed("mujoco")
    assert printed.startswith(
        "Between 3.17.0 and 3.18.0 the order of MuJoCo RK4 went from 1.0 to 4.0; positions at t = "
    )
    assert f"From 3.18.0 to {newest} nothing changed by more than rounding." in printed
    assert "3.13.0 is left out: ValueError: XML Error: unrecognized attribute." in printed
    table = pd.read_csv("out/versions.csv").set_index("release")
    names = ("3.13.0", "3.17.0", "3.18.0", newest)
    assert list(table.index) == [f"mujoco {name}" for name in names]
    assert table["order"].round().tolist()[1:] == [1.0, 4.0, 4.0]
    assert table["error"].iloc[1] > 100.0 * table["error"].iloc[2] == 100.0 * table["error"].iloc[3]
    assert table["position_difference"].iloc[2] > 0.0 == table["position_difference"].iloc[3]
    assert Path("out/versions.md").read_text().count("\n") == 6
    written = json.loads(Path("out/versions.json").read_text())
    assert written["summary"] == printed.splitlines()[:-1]
    assert {change["quantity"] for change in written["changes"]} == {
        "order",
        "positions",
        "velocities",
        "energy",
    }
    assert written["releases"][0]["order"] is None


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ("docs/models/heavy_top.xml --releases newest", "--releases expects releases as"),
        ("docs/models/heavy_top.xml --own integrator=rk5", "must be one of euler, rk4"),
        ("docs/models/heavy_top.xml --key 3", "Key must be"),
        ("docs/models/heavy_top.xml --qpos 1", "Qpos must"),
        ("docs/models/heavy_top.xml --snapshot 2", "for REBOUND files"),
        ("docs/models/absent.xml", "docs/models/absent.xml"),
        ("absent.bin", "There is no file absent.bin"),
    ],
)
def test_what_cannot_be_carried_out_is_exit_2_and_one_sentence(folder, arguments, message, capsys):
    assert run(None, ["versions", *shlex.split(arguments), "--out", "out"]) == 2  # type: ignore[arg-type]
    out, err = capsys.readouterr()
    assert out == "" and message in err and err.count("\n") == 1


@pytest.mark.slow(beside="test_sentences_a_table_and_json_say_what_changed_and_what_failed")
def test_the_command_of_the_page_says_what_the_page_shows(folder, capsys):
    command, shown = SHOWN
    status = run(None, [*shlex.split(command), "--out", "galvi-out/versions"])  # type: ignore[arg-type]
    out, err = capsys.readouterr()
    if "No matching distribution" in out + err or "left out" in out:
        pytest.skip(f"releases cannot be installed: {out or err}")
    assert status == 0
    if installed("mujoco") != "4.0.1":
        pytest.skip("the page shows MuJoCo 4.0.1")
    printed = iter([NUMBER.sub("#", line.split(" (")[0]) for line in out.splitlines()])
    for line in shown.splitlines():  # in this order; "..." is for what the page leaves out
        assert line == "..." or NUMBER.sub("#", line.split(" (")[0]) in printed
    errors = [
        next(line for line in text.splitlines() if line.startswith("At its own step"))
        for text in (out, shown)
    ]
    numbers = [[float(x) for x in NUMBER.findall(line)] for line in errors]
    assert numbers[0] == pytest.approx(numbers[1], rel=0.02)  # errors
