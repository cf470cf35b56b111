"""Stored tables on other codes still hold: signatures of peers, defects, public models."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import pandas as pd
import pytest

from benchmarks.store.provenance import ROOT
from benchmarks.studies import public_models as public
from benchmarks.studies import signatures
from references.rebound import defects as of_rebound
from references.rebound.simulation import missing

# ---- how peers move


def test_a_version_that_moves_otherwise_fails_or_is_gone_is_told() -> None:
    names = {"problem": "p", "settings": "step=1", "engines": "engine 1"}
    old = pd.DataFrame(
        [
            {**names, "contender": contender, "error": error, "status": ""}
            for contender, error in (
                ("same", 1e-3),
                ("round-off", 1e-14),
                ("other", 1e-3),
                ("ends", 1e-3),
                ("gone", 1e-3),
            )
        ]
    )
    new = old.assign(error=[1.001e-3, 4e-13, 2e-3, float("nan"), 1e-3])
    new.loc[3, "status"] = "It failed."
    assert list(signatures.differences(old, old)) == []
    assert list(signatures.differences(old, new[:4])) == [
        "p, other, step=1: the error 0.001 became 0.002.",
        "p, ends, step=1: '' became 'It failed.'.",
        "p, gone, step=1: not there.",
    ]


def test_what_is_written_and_read_again_is_the_same(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    row = {"problem": "p", "settings": "step=1", "engines": "engine 1"}
    rows = [
        {**row, "contender": "moves", "error": 0.1 + 0.2, "status": ""},
        {**row, "contender": "ends", "error": float("nan"), "status": "Failed."},
    ]
    monkeypatch.setattr(signatures, "signatures", lambda: pd.DataFrame(rows))
    file = str(tmp_path / "signatures.csv")
    assert signatures.main(["--write", file]) == signatures.main([file]) == 0
    assert "2 signatures are the same." in capsys.readouterr().out


# ---- defects: docs/why.md says where those of MuJoCo are measured again

DEFECTS, CHANGES, VERSIONS = (
    ROOT / "docs" / name for name in ("defects.csv", "changes_of_mujoco.csv", "engine_versions.csv")
)
QUOTED_STEP = 0.0125  # step of the errors that the lines on versions quote


@pytest.mark.skipif(bool(missing()), reason=missing() or "present")
def test_what_was_seen_of_rebound_is_seen_again_or_the_page_is_old() -> None:
    written = pd.read_csv(DEFECTS).set_index("what")
    for defect, reproduced in of_rebound.observations().items():
        if reproduced or defect in written.index:
            assert reproduced == written.loc[defect, "seen"] or "AVX" in defect or "512" in defect


def unknown(written: pd.DataFrame, versions: pd.DataFrame) -> list[str]:
    """Figures in the lines on versions that are not among the stored ones of the integrator."""
    unknown_figures = []
    for line in written[written["command"].str.startswith("`galvi studies")].to_dict("records"):
        name = line["what"].split()[0]
        errors = versions.loc[versions["integrator"] == name, "attitude_error"]
        expected = {f"{x:{form}}" for x in errors for form in (".1e", ".3g")} | {f"{QUOTED_STEP:g}"}
        figures = re.findall(r"0\.\d+|\d\.\d+e-\d+", line["seen"].partition("attitude error")[2])
        unknown_figures += [f"{name}: {figure}" for figure in figures if figure not in expected]
        assert figures, line
    return unknown_figures


def test_figures_of_mujoco_are_those_kept_of_its_versions_and_another_is_told() -> None:
    written = pd.concat([pd.read_csv(file) for file in (DEFECTS, CHANGES)], ignore_index=True)
    versions = pd.read_csv(VERSIONS)
    assert written["seen"].notna().all() and versions["date"].notna().all()
    assert unknown(written, versions) == []
    (order,) = versions.loc[versions["attitude_error"] == 4.67e-05, "order"].round().unique()
    assert order == 2 and written["what"].str.contains("with order 2 instead of 4").any()
    versions.loc[versions["integrator"] == "RK4", "attitude_error"] *= 1.01
    assert {line.split(":")[0] for line in unknown(written, versions)} == {"RK4"}


# ---- public models

LARGEST_DIFFERENCE = 1e-11  # 1e-12 measured: rounding in trees of 56 velocities


def stored() -> pd.DataFrame:
    table = pd.read_csv(ROOT / public.TABLE, keep_default_na=False)
    return table.assign(difference=pd.to_numeric(table["difference"]))


def changes(before: pd.DataFrame, now: pd.DataFrame) -> list[str]:
    """Rows on models that only one table has, and models whose difference is too large."""
    columns = ["model", "version", "velocities", "left_out", "why_not"]
    rows = (table[columns].itertuples(index=False) for table in (before, now))
    earlier, later = ({tuple(row) for row in table} for table in rows)
    large = now[now["difference"] > LARGEST_DIFFERENCE]["model"]
    return sorted(f"{row}" for row in earlier ^ later) + sorted(large)


def test_the_table_is_of_the_wheels_that_are_kept() -> None:
    line = (ROOT / "Makefile").read_text().partition("\nMODELS ?= ")[2].partition("\nBIN")[0]
    pinned = dict(word.split("==") for word in line.replace("\\", " ").split())
    table = stored()
    folders = table["model"].str.partition("/")[0].str.replace("_", "-")
    versions = dict(zip(folders, table["version"], strict=True))
    assert versions.pop("mujoco")
    assert versions == {name.replace("_", "-"): version for name, version in pinned.items()}


def test_every_public_model_that_moves_and_that_mujoco_reads_is_read() -> None:
    table = stored()
    assert len(table) == 153 and table["velocities"].max() == 132
    assert (table["why_not"] == "").equals(table["velocities"] > 0)
    assert table["difference"].max() <= LARGEST_DIFFERENCE
    assert not changes(table, table)


@pytest.mark.parametrize(
    ("column", "value"),
    [("why_not", "the model must be trees"), ("left_out", ", sleep"), ("difference", 1e-6)],
)
def test_a_change_is_seen(column: str, value: Any) -> None:
    before, now = stored(), stored()
    row = now.index[now["velocities"] == 132][0]
    now.loc[row, column] += value
    for after in (now, now.drop(row)):
        assert changes(before, after)
        assert all("drosophila" in change for change in changes(before, after))


@pytest.mark.slow(
    beside="tests/properties/test_trees_of_engines.py::"
    "test_the_trees_of_a_model_move_as_in_mujoco_once_what_is_beyond_is_left_out"
)
def test_public_models_are_read_as_the_table_says() -> None:
    wheels = {tuple(wheel.name.split("-")[:2]) for wheel in public.WHEELS.glob("*.whl")}
    table = stored()
    engines = {("mujoco", version) for version in table["version"]}
    packages = table["model"].str.partition("/")[0]
    if not set(zip(packages, table["version"], strict=True)) <= {*wheels, *engines}:
        pytest.skip(f"{public.WHEELS.name} in the environment lacks wheels: make install")
    assert changes(table, public.table()) == []
