"""Files and lines for CI services, read by the consumer itself where it can be installed, else by
its published format."""

from __future__ import annotations

import json
import math
import os
import shutil
import subprocess
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import yaml

from benchmarks.store.foreign_texts import visible
from reports.results.junit import JUnitCase, github_annotations
from reports.results.metrics import Metric, row_metrics, write_metrics
from tests.suite.reports.services import annotations, bencher_metrics, junit_cases
from tests.suite.reports.small_reports import ROW, claim, suite_of

HOSTILE = "<b>&]]>\"'\x00\x1b[31m\ud800\n::error::=1+1, é" + 2000 * "x"
METRICS = [
    Metric("orbit", "latency", 2.5e6, "ns", 1e5),
    Metric("orbit", "force evaluations (of the potential)", 16000.0),
    Metric("orbit", "error", math.nan),
    Metric("other", "latency", 1.0, "ns", math.inf),
    Metric(HOSTILE, HOSTILE, 0.0),
]
CONTRADICTED = replace(ROW, verdict="contradicted")


def test_verify_xml_and_its_annotations_point_at_the_class_and_have_the_numbers(ask, monkeypatch):
    monkeypatch.setenv("GITHUB_ACTIONS", "true")
    wrong = claim("A-mine", (CONTRADICTED, replace(ROW, quantity="an error")))
    suite = replace(suite_of(wrong, claim("V2")), definitions={"A-mine": ("src/a b,c.py", 12)})
    completed = ask("verify", suite)
    cases = junit_cases(Path("out/verify.xml"))
    assert cases["claim.V2", ROW.quantity]["at"] == (None, None)
    failed = cases["claim.A-mine", ROW.quantity]
    assert failed["results"] == ["Failure"] and failed["at"] == ("src/a b,c.py", "12")
    assert failed["measured"].startswith("0.25") and failed["bound"] == ROW.bound
    (shown,) = annotations(completed.out)
    assert (shown["kind"], shown["file"], shown["line"]) == ("error", "src/a b,c.py", "12")
    assert shown["title"] == f"claim.A-mine: {ROW.quantity}" and "bound at most" in shown["message"]
    measured = {"value": 0.25, "lower_value": 0.24, "upper_value": 0.26}
    metrics = bencher_metrics(Path("out/verify-bencher.json"))
    assert metrics["A-mine: an error"] == {"measured": measured} and len(metrics) == 3


def test_numbers_of_which_more_is_better_or_that_were_not_measured_are_left_out():
    rows = [
        replace(ROW, bound="order 2", quantity="error at the end, order"),
        replace(ROW, bound="at least 1"),
        replace(ROW, verdict="not run"),
        replace(ROW, measured=None),
        replace(ROW, bound="none", quantity="slope"),
    ]
    assert row_metrics(rows) == []
    measured_rows = [replace(ROW, measured=np.int64(2), uncertainty=None, bound="below 3")]
    assert [metric.value for metric in row_metrics(measured_rows)] == [2.0]


def test_metrics_are_of_benchers_format_whatever_the_names_are(tmp_path):
    write_metrics(tmp_path, "track", METRICS)
    content = bencher_metrics(tmp_path / "track-bencher.json")
    assert content["orbit"] == {
        "latency": {"value": 2.5e6, "lower_value": 2.4e6, "upper_value": 2.6e6},
        "force-evaluations-of-the-potential": {"value": 16000.0},
    }
    assert len(content) == 2  # not `other`, whose spread is not finite


def test_measures_that_bencher_would_name_alike_are_all_kept(tmp_path):
    names = [
        "force calls",
        "force_calls",
        "Force-calls!",
        "é",
        "ü",
        63 * "x" + " y",
        63 * "x" + " z",
    ]
    metrics = [Metric("b", name, -float(value)) for value, name in enumerate(names)]
    write_metrics(tmp_path, "track", metrics)
    measures = bencher_metrics(tmp_path / "track-bencher.json")["b"]
    assert [measure["value"] for measure in measures.values()] == [
        metric.value for metric in metrics
    ]
    assert list(measures)[:3] == ["force-calls", "force-calls-2", "force-calls-3"]
    assert not any(name.endswith("-") for name in measures)


def test_an_annotation_can_be_printed_and_parsed_whatever_its_texts_are(monkeypatch):
    monkeypatch.setenv("GITHUB_ACTIONS", "true")
    case = JUnitCase(HOSTILE, "a", 0.0, "failure", HOSTILE, defined_at=("a\udcff,b:c\r.py", 3))
    (line,) = github_annotations([case])
    (shown,) = annotations(line.encode().decode())
    assert shown["file"] == "a\\udcff,b:c\r.py" and shown["message"] == visible(HOSTILE)
    assert shown["title"] == visible(f"{HOSTILE}: a")


@pytest.mark.parametrize("text", ['{"a": {"b": {"value": NaN}}}', '{"a": {"b": {}}}', "[]"])
def test_another_format_than_benchers_would_be_noticed(text, tmp_path):
    (tmp_path / "x.json").write_text(text)
    with pytest.raises(Exception, match=r"NaN|'value' is a required|is not of type 'object'"):
        bencher_metrics(tmp_path / "x.json")


ACTION = "https://github.com/benchmark-action/github-action-benchmark"
RELEASE = "a60cea5bc7b49e15c1f58f411161f99e0df48372"  # v1.22.0
COMMIT = {"message": "m", "timestamp": "2026-01-01T00:00:00Z", "url": "u"}


@pytest.fixture(scope="module")
def benchmark_action(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The action at RELEASE, with its compiled program."""
    folder = tmp_path_factory.mktemp("benchmark-action")
    for arguments in (["init"], ["fetch", "--depth", "1", ACTION, RELEASE], ["checkout", RELEASE]):
        completed = subprocess.run(
            ["git", *arguments, "--quiet"], cwd=folder, capture_output=True, text=True
        )
        reason = (
            completed.returncode
            and f"{ACTION} cannot be fetched: {completed.stderr.strip()[-200:]}"
        )
        if reason := reason or ("" if shutil.which("node") else "there is no node"):
            assert not os.environ.get("CI"), reason
            pytest.skip(reason)
    return folder


def run_action(action: Path, folder: Path, commit: str) -> subprocess.CompletedProcess[str]:
    """Run the action as a job of a push would, with its numbers in data.json of the folder."""
    event = {
        "head_commit": COMMIT | {"id": commit},
        "repository": {"html_url": "https://github.com/a/b"},
    }
    (folder / "event.json").write_text(json.dumps(event))
    declarations = yaml.safe_load((action / "action.yml").read_text(encoding="utf-8"))["inputs"]
    inputs = {
        name: str(declaration.get("default", "")).lower()
        for name, declaration in declarations.items()
    } | {
        "tool": "customSmallerIsBetter",
        "output-file-path": "track-benchmark-action.json",
        "external-data-json-path": "data.json",
        "alert-threshold": "150%",
        "fail-on-alert": "true",
    }
    runner = {
        "GITHUB_EVENT_PATH": str(folder / "event.json"),
        "GITHUB_REPOSITORY": "a/b",
        "GITHUB_STEP_SUMMARY": str(folder / "summary.md"),
    }
    (folder / "summary.md").touch()
    variables = {f"INPUT_{name.upper()}": text for name, text in inputs.items()}
    return subprocess.run(
        ["node", action / "dist" / "src" / "index.js"],
        cwd=folder,
        capture_output=True,
        text=True,
        env=os.environ | runner | variables,
    )


@pytest.mark.slow(beside="test_metrics_are_of_benchers_format_whatever_the_names_are")
def test_github_action_benchmark_reads_the_numbers_and_sees_one_that_grows(
    benchmark_action, tmp_path
):
    write_metrics(tmp_path, "track", METRICS)
    completed = run_action(benchmark_action, tmp_path, "first")
    assert completed.returncode == 0, completed.stdout + completed.stderr
    ((entry,),) = json.loads((tmp_path / "data.json").read_text(encoding="utf-8"))[
        "entries"
    ].values()
    names = [(bench["name"], bench["value"], bench.get("range", "")) for bench in entry["benches"]]
    assert names[0] == ("orbit: latency", 2.5e6, "± 1e+05") and len(names) == 3
    write_metrics(tmp_path, "track", [replace(METRICS[0], value=5e6)])
    completed = run_action(benchmark_action, tmp_path, "second")
    assert completed.returncode == 1 and "Performance Alert" in completed.stdout
