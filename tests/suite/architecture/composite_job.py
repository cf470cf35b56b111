"""A GitHub job that runs the commands of the composite action, with the variables that a runner
sets. Steps that use other actions, such as caches, are left out."""

from __future__ import annotations

import os
import re
import subprocess
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import yaml

ROOT = Path(__file__).parents[3]
ACTION = ROOT / ".github" / "actions" / "galvi" / "action.yml"
EXPRESSION = re.compile(r"\$\{\{ (.*?) \}\}")
FILES = ("GITHUB_OUTPUT", "GITHUB_ENV", "GITHUB_STEP_SUMMARY")
PYTHON_OF_CONDITION = {
    "always()": "True",
    "success()": "passed",
    "failure()": "(not passed)",
    "github.ref_name == github.event.repository.default_branch": "on_main",
    "&&": " and ",
    "||": " or ",
}


@dataclass
class Job:
    """A job that runs the action on a checkout of a project.

    Attributes
    ----------
    project
        the checkout
    runner
        folder for the runner's files
    galvi
        folder into which the runner puts galvi's repository
    event
        such as "pull_request"
    variables
        the job's environment
    inputs
        the action's inputs that differ from their defaults
    status, printed
        exit status and output of each step that ran, by its id or its command
    outputs
        outputs of the steps, by "step.outputs.name"
    skipped
        ids of the steps whose condition did not hold
    """

    project: Path
    runner: Path
    galvi: Path
    event: str
    variables: dict[str, str]
    inputs: Mapping[str, str] = field(default_factory=dict)
    status: dict[str, int] = field(default_factory=dict)
    printed: dict[str, str] = field(default_factory=dict)
    outputs: dict[str, str] = field(default_factory=dict)
    skipped: set[str] = field(default_factory=set)

    @property
    def passed(self) -> bool:
        """Whether no step failed."""
        return not any(self.status.values())

    @property
    def summary(self) -> str:
        """The text that GitHub shows on the job's page."""
        return (self.runner / "GITHUB_STEP_SUMMARY").read_text(encoding="utf-8")

    def run(self, *step_ids: str) -> None:
        """Run the commands of the action, or only the steps with these ids."""
        self.runner.mkdir(exist_ok=True)
        for name in FILES:
            (self.runner / name).touch()
        action = yaml.safe_load(ACTION.read_text(encoding="utf-8"))
        defaults = {name: declaration["default"] for name, declaration in action["inputs"].items()}
        assert set(self.inputs) <= set(defaults)
        for step in action["runs"]["steps"]:
            if "run" in step and (not step_ids or step.get("id") in step_ids):
                self._run(step, defaults | dict(self.inputs))

    def _run(self, step: Mapping[str, Any], inputs: Mapping[str, str]) -> None:
        name = step.get("id", step["run"])
        if not self._condition_holds(step.get("if", "success()")):
            self.skipped.add(name)
            return
        files = {file: str(self.runner / file) for file in FILES}
        action_folder = self.galvi / ".github" / "actions" / "galvi"
        action_folder.mkdir(parents=True, exist_ok=True)
        github = {
            "GITHUB_ACTIONS": "true",
            "GITHUB_ACTION_PATH": str(action_folder),
            "GITHUB_EVENT_NAME": self.event,
            "RUNNER_TEMP": str(self.runner),
            "PIP_REQUIRE_VIRTUALENV": "1",  # where PATH has no other Python, nothing is installed
        }
        values = {f"inputs.{key}": text for key, text in inputs.items()}
        values |= {f"steps.{key}": text for key, text in self.outputs.items()}
        folder, *texts = (
            EXPRESSION.sub(lambda match: values[match[1]], text)
            for text in (step.get("working-directory", "."), *step.get("env", {}).values())
        )
        step_environment = dict(zip(step.get("env", {}), texts, strict=True))
        (self.runner / "GITHUB_OUTPUT").write_text("")
        assert step["shell"] == "bash" and not EXPRESSION.search(step["run"])
        completed = subprocess.run(
            ["bash", "--noprofile", "--norc", "-eo", "pipefail", "-c", step["run"]],
            cwd=self.project / folder,
            env=self.variables | files | github | step_environment,
            text=True,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
        )
        self.status[name], self.printed[name] = completed.returncode, completed.stdout
        self.outputs |= {
            f"{name}.outputs.{key}": text for key, text in self._assignments("GITHUB_OUTPUT")
        }
        self.variables |= dict(self._assignments("GITHUB_ENV"))

    def _condition_holds(self, condition: str) -> bool:
        """Whether the condition of a step holds after the steps that ran."""
        for word, python in PYTHON_OF_CONDITION.items():
            condition = condition.replace(word, python)
        for pattern, holds in (
            (r"steps\.(\w+)\.outcome != 'skipped'", lambda step: step not in self.skipped),
            (r"steps\.(\w+\.outputs\.\w+) != ''", lambda output: bool(self.outputs.get(output))),
        ):
            condition = re.sub(pattern, lambda match, holds=holds: str(holds(match[1])), condition)
        names = {"passed": self.passed, "on_main": self.event == "push"}
        return bool(eval(condition, {"__builtins__": {}}, names))

    def _assignments(self, file: str) -> list[tuple[str, str]]:
        lines = (self.runner / file).read_text(encoding="utf-8").splitlines()
        return [(line.partition("=")[0], line.partition("=")[2]) for line in lines]


def checked_out(repository: Path, folder: Path) -> Path:
    """The folder with a clone of the last commit only, as actions/checkout makes it."""
    command = ["git", "clone", "--quiet", "--depth", "1", repository.as_uri(), folder]
    subprocess.run(command, check=True, env=os.environ | {"GIT_CONFIG_GLOBAL": os.devnull})
    return folder
