"""What is kept: provenance, versions, benches, the catalogue of timings."""

from __future__ import annotations

import json
import math
import subprocess
import sys
from dataclasses import asdict, replace
from pathlib import Path

import numpy as np
import pytest

import galvi
from benchmarks.store import provenance
from benchmarks.timings.case import ROUND_OFF, STEP, TRAJECTORY, Case
from benchmarks.timings.catalogue import CASES
from benchmarks.timings.truth import Unknown, error_of, true_ends
from references import reference


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


@pytest.mark.parametrize(
    ("version", "commit"),
    [
        ("0.1.0.dev0+gf6e5c5a015ae.dirty", "f6e5c5a015ae+dirty"),
        ("0.1.0", "unknown"),
    ],
)
def test_the_commit_of_an_installation_is_that_of_its_version(
    version: str, commit: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Also inside of another project's checkout, whose commit is none of galvi's."""
    subprocess.run(["git", "init", "-q", tmp_path], check=True)
    identity = ["-c", "user.name=me", "-c", "user.email=me@localhost"]
    words = ["commit", "-q", "--allow-empty", "-m", "theirs"]
    subprocess.run(["git", "-C", tmp_path, *identity, *words], check=True)
    installed = tmp_path / "site-packages"
    installed.mkdir()
    monkeypatch.setattr(provenance, "ROOT", installed)
    monkeypatch.setattr(provenance, "galvi_version", lambda: version)
    assert provenance.commit() == commit


def test_an_engine_that_is_absent_is_said_to_be(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(provenance, "ENGINES", ("numpy", "no-such-engine"))
    assert provenance.versions()["no-such-engine"] == "not installed"


ROOT = Path(__file__).parents[3]


@pytest.mark.slow(
    beside="tests/suite/reports/test_track_history.py::test_each_quantity_of_each_bench_is_a_row"
)
def test_a_bench_is_stored_with_what_is_read_of_it(tmp_path: Path) -> None:
    words = ["-m", "pytest", "benchmarks/timings", "-q", "-k", "oscillator and closed"]
    words += ["--benchmark-enable", "--benchmark-only", "-p", "no:cacheprovider"]
    words += [f"--benchmark-storage=file://{tmp_path}"]
    subprocess.run([sys.executable, *words], cwd=ROOT, capture_output=True, check=True)
    (path,) = tmp_path.rglob("*.json")
    rows = json.loads(path.read_text())["benchmarks"]
    assert rows and len(rows) == len({row["name"] for row in rows})
    for row in rows:
        assert row["extra_info"]["yardstick"]["seconds"] > 0.0 and row["stats"]["data"]
        assert {"error", "counts", "status", "settings", "versions"} < set(row["extra_info"])


def test_every_problem_has_cases_of_each_kind_by_names_of_their_own_and_as_plain_data() -> None:
    for kind in (STEP, TRAJECTORY):
        found = {case.problem for case in CASES if case.kind == kind}
        assert found == set(galvi.problems.__all__)
    assert len({case.name for case in CASES}) == len(CASES)
    for case in CASES:
        assert Case(**json.loads(json.dumps(asdict(case)))) == case
        problem = getattr(galvi.problems, case.problem)(**case.arguments)
        assert not case.truth or reference(case.truth).supports(problem), case.name
    quick = [case for case in CASES if case.quick]
    assert {case.kind for case in quick} == {STEP, TRAJECTORY, ROUND_OFF}
    assert len(quick) < len(CASES) / 2


def test_a_case_without_a_truth_says_so() -> None:
    with pytest.raises(Unknown, match="no truth but galvi's own"):
        true_ends(replace(CASES[0], truth=""))


def test_the_error_is_the_rms_over_starts_and_nan_for_a_failed_run() -> None:
    truth = [[0.0, 0.0], [0.0, 0.0]]
    assert error_of([[3.0, 0.0], [0.0, -4.0]], truth) == pytest.approx(12.5**0.5)
    assert math.isnan(error_of([[math.nan, 0.0], [0.0, 0.0]], truth))


def test_a_version_of_changed_files_is_not_that_of_the_commit() -> None:
    digits, plus, digest = provenance.version().partition("+")
    assert len(digits) in (7, 12) and (not plus or len(digest) == 8)
