"""What the checkout holds: its top level, names of files, no trace of a machine."""

from __future__ import annotations

import re
import subprocess
import tomllib
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[3]

TOP_LEVEL = {
    ".ci",
    ".github",
    ".gitignore",
    "CHANGELOG.md",
    "CITATION.cff",
    "CONTRIBUTING.md",
    "Makefile",
    "README.md",
    "benchmarks",
    "constraints.txt",
    "cosmic-ray.toml",
    "docs",
    "galvi",
    "pyproject.toml",
    "setup.py",
    "references",
    "reports",
    "tests",
}
NAMES_THAT_SAY_NOTHING = {"utils", "helpers", "common", "base", "misc"}
A_MACHINE = re.compile(r"(?<![\w./])/(?:home|root|tmp|work|opt|mnt|Users)/\w|\b[A-Z]:\\Users\b")


@pytest.fixture(scope="module")
def files() -> list[Path]:
    """What git tracks, or would on the next `git add .`, relative to the root."""
    command = ["git", "ls-files", "--cached", "--others", "--exclude-standard", "-z"]
    listed = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=True).stdout
    return sorted(Path(name) for name in listed.split("\0") if name and (ROOT / name).is_file())


def test_the_top_level_holds_what_the_design_lists_and_nothing_else(files: list[Path]) -> None:
    assert {file.parts[0] for file in files} == TOP_LEVEL


def test_every_folder_of_tests_is_run(files: list[Path]) -> None:
    settings = tomllib.loads((ROOT / "pyproject.toml").read_text())["tool"]["pytest"]["ini_options"]
    tests = [file for file in files if file.parts[0] == "tests" and file.name.startswith("test_")]
    assert sorted(settings["testpaths"]) == sorted({str(file.parent) for file in tests})


def test_no_file_or_folder_has_a_name_that_says_nothing(files: list[Path]) -> None:
    named = [file for file in files if NAMES_THAT_SAY_NOTHING & {*file.parts[:-1], file.stem}]
    assert named == []


def test_no_file_names_a_place_on_the_machine_it_was_written_on(files: list[Path]) -> None:
    found = []
    for file in files:
        try:
            text = (ROOT / file).read_text(encoding="utf-8")
        except UnicodeDecodeError:
            continue
        found += [f"{file}: {match.group()}" for match in A_MACHINE.finditer(text)]
    assert found == []


def test_the_search_for_places_on_a_machine_finds_one_and_leaves_relative_paths_alone() -> None:
    assert A_MACHINE.search("cd " + "/".join(["", "home", "someone", "galvi"]))
    assert not A_MACHINE.search("see docs/home/index.md, work/precision and https://a.org/home/x")
