"""The workflows for a forge's CI: they parse, and what they run exists."""

from __future__ import annotations

import re
import shlex
from pathlib import Path

import pytest
import yaml

from reports.cli.commands import application
from reports.contents import load

ROOT = Path(__file__).parents[2]
WORKFLOWS = sorted((ROOT / ".github" / "workflows").glob("*.yml"))
KNOWN_ACTIONS = re.compile(r"actions/[a-z/-]+@v\d+")
REPORTS = [".venv/bin/python", "-m", "reports"]
every = pytest.mark.parametrize("path", WORKFLOWS, ids=lambda path: path.stem)


def commands(text: str) -> list[str]:
    """Every line that a workflow runs."""
    jobs = yaml.safe_load(text)["jobs"].values()
    runs = [step["run"] for job in jobs for step in job["steps"] if "run" in step]
    return [line for run in runs for line in run.splitlines()]


def unknown(line: str) -> list[str]:
    """The words of a command that nothing here understands."""
    words = shlex.split(re.sub(r"\$\{\{.*?\}\}", "x", line))
    if words == [".ci/run"]:
        return [] if (ROOT / ".ci" / "run").stat().st_mode & 0o111 else words
    if words[0] == "make":
        targets = re.findall(r"^([a-z]+):", (ROOT / "Makefile").read_text(), re.M)
        return [word for word in words[1:] if word not in targets]
    if words[:3] != REPORTS:
        return words
    import typer

    group = typer.main.get_command(application(load, ""))
    command = group.commands.get(words[3])
    if command is None:
        return [words[3]]
    options = {name for parameter in command.params for name in parameter.opts}
    return [word for word in words[4:] if word.startswith("--") and word not in options]


def test_there_is_one_for_verify_and_one_for_track() -> None:
    assert {"ci", "verify", "track"} <= {path.stem for path in WORKFLOWS}


@every
def test_a_workflow_says_when_where_and_for_how_long(path: Path) -> None:
    workflow = yaml.safe_load(path.read_text())
    assert workflow["name"] == path.stem
    assert workflow[True]  # "on", as YAML 1.1 reads it
    assert workflow["permissions"] == {"contents": "read"}
    for job in workflow["jobs"].values():
        assert job["runs-on"] == "ubuntu-latest" and 0 < job["timeout-minutes"] <= 60
        for step in job["steps"]:
            assert ("run" in step) != ("uses" in step)
            assert KNOWN_ACTIONS.fullmatch(step.get("uses", "actions/checkout@v4"))


@every
def test_every_command_of_a_workflow_exists(path: Path) -> None:
    found = commands(path.read_text())
    assert found and {line: words for line in found if (words := unknown(line))} == {}


def test_commands_of_the_page_and_of_ci_exist() -> None:
    page = (ROOT / "docs" / "suite.md").read_text() + (ROOT / ".ci" / "run").read_text()
    lines = re.findall(r"^\.venv/bin/python -m reports[^\n#]*", page, re.M)
    assert len(lines) >= 4 and [line for line in lines if unknown(line)] == []


def test_ci_runs_tests_for_other_processors_that_exist() -> None:
    script = (ROOT / ".ci" / "run").read_text()
    named = re.findall(r"^ +(tests/\S+)$", script, re.M)
    assert {"generic", "haswell"} == set(re.findall(r"NUMBA_CPU_NAME=(\w+)", script))
    assert script.index("export NUMBA_CPU_FEATURES=''") < script.index("NUMBA_CPU_NAME=")
    assert len(named) > 2 and [name for name in named if not (ROOT / name).is_file()] == []


@pytest.mark.parametrize(
    "line", ["make instal", ".venv/bin/python -m reports verfy", "rm -r x",
             ".venv/bin/python -m reports verify --requires rebound"],
)  # fmt: skip
def test_a_command_that_does_not_exist_would_be_noticed(line: str) -> None:
    assert unknown(line)
