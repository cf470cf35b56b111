"""Provenance names versions, commit, machine, date and command, and no folder."""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np
import pytest

from benchmarks.store import provenance


def test_it_names_the_versions_that_run() -> None:
    found = provenance.provenance("make report")
    assert found["numpy"] == np.__version__
    assert found["python"] == ".".join(map(str, sys.version_info[:3]))
    assert found["command"] == "make report"
    assert int(found["threads"]) >= 1
    assert all(isinstance(value, str) and value for value in found.values())


def test_the_command_is_the_one_typed_without_folders(monkeypatch: pytest.MonkeyPatch) -> None:
    program = str(Path("somewhere") / "deep" / "reports" / "__main__.py")
    monkeypatch.setattr(sys, "argv", [program, "verify", "--quick"])
    assert provenance.provenance()["command"] == "python -m reports verify --quick"
    monkeypatch.setattr(sys, "argv", [str(Path("somewhere") / "pytest"), "-q"])
    assert provenance.provenance()["command"] == "pytest -q"


def test_outside_git_the_commit_is_unknown(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(provenance, "ROOT", tmp_path)
    monkeypatch.setenv("GIT_CEILING_DIRECTORIES", str(tmp_path.parent))
    assert provenance.commit() == "unknown"


def test_an_engine_that_is_absent_is_said_to_be(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(provenance, "ENGINES", ("numpy", "no-such-engine"))
    assert provenance.versions()["no-such-engine"] == "not installed"
