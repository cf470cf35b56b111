"""Rows of another machine stand beside one's own, dated; what is not known is refused."""

from __future__ import annotations

import pytest

from benchmarks.store.cells import as_csv
from reports.build.build import build_kept
from reports.build.kept import kept_comparison
from reports.results.machines import Machine, machines, merge, other_machines
from reports.results.options import Options
from reports.results.origins import note_origin
from reports.tables.readme import SPEED, TIMES, by_machine
from tests.suite.reports.small_reports import suite_of, work_precision

ORIGIN = {
    "date": "2026-01-02 03:04 UTC",
    "commit": "0123456789abcdef",
    "cpu": "EPYC 7",
    "compiled for": "znver3, AVX2",
}
HERE = {**ORIGIN, "cpu": "Xeon", "compiled for": "sapphirerapids, AVX-512"}


def report(folder, **origin):
    folder.mkdir(parents=True, exist_ok=True)
    (folder / "work_precision.csv").write_text(as_csv(work_precision(True, print)))
    note_origin(folder, "work_precision.csv", {**ORIGIN, **origin}, False)
    return folder


def test_rows_and_benches_come_with_where_they_are_from(tmp_path):
    remote, out = report(tmp_path / "there"), report(tmp_path / "out", **HERE)
    bench = remote / "benchmarks" / "Linux" / "0001.json"
    bench.parent.mkdir(parents=True)
    bench.write_text("{}")
    rows, benches = merge(out, [remote])
    assert "6 rows of EPYC 7 (znver3, AVX2), 2026-01-02, commit 0123456789ab" in rows
    assert "1 benchmark files copied" in benches and (out / bench.relative_to(remote)).exists()
    local, merged = machines(out)
    assert (local.vector_set, merged.vector_set) == ("AVX-512", "AVX2")
    assert merged.runs["seconds"].tolist() == pytest.approx(
        work_precision(True, print)["seconds"].tolist(), nan_ok=True
    )
    assert any(
        "skipped" in message for message in merge(out, [remote])
    )  # the rows in `out` are as new
    newer = report(tmp_path / "newer", date="2026-02-02 00:00 UTC")
    merge(out, [newer])
    assert [machine.origin["date"][:7] for machine in machines(out)] == ["2026-01", "2026-02"]
    merge(tmp_path / "third", [out])  # with what was merged into it
    assert len(machines(tmp_path / "third")) == 2


def test_a_folder_without_rows_or_with_rows_from_nowhere_is_refused(tmp_path):
    good, out = report(tmp_path / "good"), tmp_path / "out"
    (tmp_path / "empty").mkdir()
    nowhere = report(tmp_path / "nowhere")
    (nowhere / "provenance.json").unlink()
    narrow = report(tmp_path / "narrow")
    (narrow / "work_precision.csv").write_text("problem,error\np,1\n")
    for folder, message in (
        ("empty", "which has neither"),
        ("nowhere", "it does not"),
        ("narrow", "without contender, settings, seconds, is_truth"),
    ):
        with pytest.raises(ValueError, match=message):
            merge(out, [good, tmp_path / folder])
        assert not out.exists()


def test_a_report_without_an_origin_of_its_own_shows_the_machines_that_were_merged(tmp_path):
    out = report(tmp_path / "out")
    merge(out, [report(tmp_path / "there", **HERE)])
    (out / "provenance.json").unlink()
    assert [machine.vector_set for machine in other_machines(out)] == ["AVX-512"]
    assert len(machines(out)) == 1


def test_rows_that_do_not_say_which_is_the_truth_are_left_out(tmp_path, capsys):
    file = report(tmp_path) / "work_precision.csv"
    assert len(machines(tmp_path)) == 1 and kept_comparison(tmp_path).work_precision is not None
    file.write_text(as_csv(work_precision(True, print).drop(columns="is_truth")))
    assert machines(tmp_path) == [] and kept_comparison(tmp_path).work_precision is None
    assert capsys.readouterr().err.count("it has no column 'is_truth'") == 2


def test_rows_of_earlier_versions_get_the_errors_that_count(tmp_path):
    file = report(tmp_path) / "work_precision.csv"
    lucky = work_precision(True, print).drop(columns=["own_error", "error_is_bound"])
    lucky.loc[2, "error"] = 1e-4  # at a step of 3; at 2 it is 1e-3
    file.write_text(as_csv(lucky))
    for runs in (kept_comparison(tmp_path).work_precision, machines(tmp_path)[0].runs):
        assert runs is not None and runs.loc[2, "error"] == 1e-3
        assert runs.loc[2, "own_error"] == 1e-4


@pytest.mark.usefixtures("undrawn")
def test_the_page_shows_both_machines(tmp_path):
    out = report(tmp_path / "out", **HERE)
    merge(out, [report(tmp_path / "there")])
    build_kept(suite_of(), Options(False, (), out, "build --kept", ()))
    page = (out / "results" / "comparisons.html").read_text(encoding="utf-8")
    assert "On EPYC 7 (znver3, AVX2), 2026-01-02, commit 0123456789ab" in page
    assert "On Xeon; galvi and heyoka compile for sapphirerapids, AVX-512." in page
    assert "no AVX but where it chooses at run time" in page  # how REBOUND was compiled


def test_a_table_has_a_block_for_each_kind_of_processor_by_the_report_s_own_machine():
    runs = work_precision(True, print)
    local, remote = Machine(runs, HERE), Machine(runs, {**ORIGIN, "date": "2026-03-03"})
    twin = Machine(runs, {**HERE, "cpu": "Xeon 2"})
    blocks = by_machine([local, twin, remote], *TIMES[SPEED])
    assert blocks.count("On ") == 2 and "Xeon 2" not in blocks
    assert blocks.index("AVX-512") < blocks.index("AVX2") and "2026-03-03" in blocks
