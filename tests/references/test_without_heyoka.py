"""Tests of references pass where heyoka, which is optional, is not installed, as in CI."""

from __future__ import annotations

import subprocess
import sys
from importlib.util import find_spec
from pathlib import Path

import pytest

HERE = Path(__file__).parent
HEYOKA_IS_ABSENT = find_spec("heyoka") is None


def pytest_without_heyoka(*files: str) -> subprocess.CompletedProcess[str]:
    options = ["-m", "pytest", "-q", "-p", "no:cacheprovider", "--without", "heyoka"]
    command = [sys.executable, *options, *(str(HERE / file) for file in files)]
    return subprocess.run(command, capture_output=True, text=True, cwd=HERE.parents[1])


@pytest.mark.skipif(HEYOKA_IS_ABSENT, reason="heyoka is not installed: all tests run without it")
def test_the_contract_of_references_is_kept_without_heyoka():
    completed = pytest_without_heyoka("test_registry.py", "test_heyoka.py")
    assert completed.returncode == 0, completed.stdout
    assert "Install heyoka" in completed.stdout  # why the tests of heyoka itself were skipped
