"""GitHub's workflows: they parse, and the commands and actions that they name exist."""

from __future__ import annotations

import os
import re
import shlex
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest
import yaml

from reports.cli.commands import application
from tests.suite.architecture.composite_job import ACTION

ROOT = Path(__file__).parents[3]
WORKFLOWS = sorted((ROOT / ".github" / "workflows").glob("*.yml"))
EXAMPLE_WORKFLOW = ROOT / "docs" / "workflow.yml"
PAGE = ROOT / "docs" / "suite.md"
# the name of galvi's action in another project
GALVI_ACTION = "OWNER/galvi/.github/actions/galvi@COMMIT"
PINNED = re.compile(r"uses: (actions/[a-z/-]+)@([0-9a-f]{40}) # (v\d+\.\d+\.\d+)")
ON_MAIN = (
    "github.ref == 'refs/heads/main'",
    "github.ref_name == github.event.repository.default_branch",
)
SYSTEMS = {"ubuntu-latest", "macos-15", "windows-latest"}
REPORTS = [".venv/bin/python", "-m", "reports"]
each_workflow = pytest.mark.parametrize("path", WORKFLOWS, ids=lambda path: path.stem)


def steps(text: str) -> list[dict[str, Any]]:
    """The steps of all jobs of a workflow, or of a composite action."""
    content = yaml.safe_load(text)
    jobs = [content["runs"]] if "runs" in content else content["jobs"].values()
    return [step for job in jobs for step in job["steps"]]


def commands(text: str) -> list[str]:
    """Every line that a workflow runs."""
    runs = [step["run"] for step in steps(text) if "run" in step]
    return [line for run in runs for line in run.splitlines()]


def unknown(line: str) -> list[str]:
    """The words of a command that are no command, target, file or option of this project."""
    tokens = shlex.split(re.sub(r"\$\{\{.*?\}\}", "x", line))
    if tokens == [".ci/run"]:
        return [] if (ROOT / ".ci" / "run").stat().st_mode & 0o111 else tokens
    if tokens[0] == "make":
        makefile = (ROOT / "Makefile").read_text()
        targets = {
            *re.findall(r"^([a-z]+):", makefile, re.M),
            *re.findall(r"\(([A-Z]+)\)", makefile),
        }
        return [word for word in tokens[1:] if word.partition("=")[0] not in targets]
    if tokens[0] in ("awk", "cd"):
        return []  # a test runs them
    if tokens[:3] == ["python", "-m", "pytest"]:
        return [word for word in tokens[3:] if not (ROOT / word).is_file()]
    if tokens[:4] == ["python", "-m", "pip", "install"]:
        return []
    if tokens[:3] != REPORTS:
        return tokens
    import typer

    group = typer.main.get_command(application())
    command = group.commands.get(tokens[3])
    if command is None:
        return [tokens[3]]
    options = {name for parameter in command.params for name in parameter.opts}
    return [word for word in tokens[4:] if word.startswith("--") and word not in options]


@each_workflow
def test_a_workflow_says_when_where_and_for_how_long(path: Path) -> None:
    workflow = yaml.safe_load(path.read_text())
    assert workflow[True] and workflow["permissions"] == {"contents": "read"}  # True: "on"
    for job in workflow["jobs"].values():
        systems = job.get("strategy", {}).get("matrix", {}).get("system", [job["runs-on"]])
        assert set(systems) <= SYSTEMS and 0 < job["timeout-minutes"] <= 150


def unpinned(text: str) -> list[str]:
    """The lines that name an action otherwise than by the digest of a commit and its version."""
    lines = [line.strip().removeprefix("- ") for line in text.splitlines()]
    uses = [line for line in lines if line.startswith("uses:") and line != f"uses: {GALVI_ACTION}"]
    return [line for line in uses if not PINNED.fullmatch(line)]


def saved_anywhere(text: str) -> list[str]:
    """The actions that save a cache from branches other than main."""
    saving = [x for x in steps(text) if re.match("actions/cache(/save)?@", x.get("uses", ""))]
    return [x["uses"] for x in saving if not {*ON_MAIN} & {*x.get("if", "").split(" && ")}]


pinned = pytest.mark.parametrize(
    "path", [*WORKFLOWS, EXAMPLE_WORKFLOW, ACTION], ids=lambda path: path.name
)


@pinned
def test_actions_are_pinned_by_digest_and_version_and_save_caches_from_main_alone(
    path: Path,
) -> None:
    text = path.read_text()
    assert PINNED.search(text) and unpinned(text) == [] and saved_anywhere(text) == []


@pytest.mark.parametrize(
    "action",
    [
        "actions/checkout@v4",
        "actions/checkout@11bd719 # v4.2.2",
        "actions/checkout@" + 40 * "a",
        "actions/checkout@" + 40 * "a" + " # v4",
    ],
)
def test_an_action_that_is_not_pinned_would_be_noticed(action: str) -> None:
    assert unpinned(f"    steps:\n      - uses: {action}\n") == [f"uses: {action}"]


@pytest.mark.parametrize(
    "step", ["actions/cache@x", f"actions/cache/save@x, if: always() || {ON_MAIN[0]}"]
)
def test_a_cache_saved_from_a_pull_request_would_be_noticed(step: str) -> None:
    assert saved_anywhere(f"jobs: {{x: {{steps: [{{uses: {step}}}]}}}}")


@each_workflow
def test_every_command_of_a_workflow_exists(path: Path) -> None:
    lines = commands(path.read_text())
    assert (
        lines and {line: unknown_words for line in lines if (unknown_words := unknown(line))} == {}
    )


def test_the_workflow_to_copy_has_ten_lines_and_names_an_action_and_inputs_that_exist() -> None:
    text = EXAMPLE_WORKFLOW.read_text()
    (step,) = [step for step in steps(text) if step["uses"] == GALVI_ACTION]
    action_path = GALVI_ACTION.removeprefix("OWNER/galvi/").removesuffix("@COMMIT")
    assert ROOT / action_path / "action.yml" == ACTION and len(text.splitlines()) <= 10
    inputs = yaml.safe_load(ACTION.read_text())["inputs"]
    assert step["with"].keys() <= inputs.keys()
    (section,) = re.findall(r"^## In your CI\n(.*?)^## ", PAGE.read_text(), re.M | re.S)
    assert re.findall(r"^\| `([a-z-]+)` \|", section, re.M) == [*inputs]
    assert all(step.get("shell") == "bash" for step in steps(ACTION.read_text()) if "run" in step)


def test_the_smoke_test_runs_readmes_first_example(tmp_path: Path) -> None:
    lines = [
        step["run"]
        for step in steps((WORKFLOWS[0].parent / "smoke.yml").read_text())
        if "awk" in step.get("run", "")
    ]
    variables = os.environ | {"RUNNER_TEMP": str(tmp_path), "PYTHONPATH": str(ROOT)}
    variables["PATH"] = f"{Path(sys.executable).parent}{os.pathsep}{variables['PATH']}"
    command = ["bash", "-e", "-c", *lines]
    completed = subprocess.run(command, cwd=ROOT, env=variables, capture_output=True, text=True)
    assert completed.returncode == 0 and "Completed. 100 steps" in completed.stdout, (
        completed.stderr
    )


def test_commands_of_the_page_and_of_ci_exist() -> None:
    page = PAGE.read_text() + (ROOT / ".ci" / "run").read_text()
    page = re.sub("^galvi ", ".venv/bin/python -m reports ", page, flags=re.M)
    lines = re.findall(r"^\.venv/bin/python -m reports[^\n#]*", page, re.M)
    assert len(lines) >= 4 and [line for line in lines if unknown(line)] == []


def test_ci_runs_tests_that_exist() -> None:
    named = re.findall(r"^ +(tests/\S+)$", (ROOT / ".ci" / "run").read_text(), re.M)
    assert named and [name for name in named if not (ROOT / name).is_file()] == []


@pytest.mark.parametrize(
    "line",
    [
        "make instal",
        ".venv/bin/python -m reports verfy",
        "rm -r x",
        ".venv/bin/python -m reports verify --requires rebound",
    ],
)
def test_a_command_that_does_not_exist_would_be_noticed(line: str) -> None:
    assert unknown(line)
