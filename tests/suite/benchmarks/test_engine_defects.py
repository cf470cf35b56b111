"""Defects of other codes: REBOUND's are seen again, MuJoCo's have the figures that are kept of it.

``docs/engine_versions.csv``, how each version of MuJoCo turns a free body, and ``docs/defects.csv``
were written by ``benchmarks.experiments.engine_defects``: docs/why.md says where it is run again.
"""

from __future__ import annotations

import re

import pandas as pd
import pytest

from benchmarks.store.provenance import ROOT
from references.rebound import defects as of_rebound
from references.rebound.simulation import missing

DEFECTS, CHANGES, VERSIONS = (
    ROOT / "docs" / name for name in ("defects.csv", "changes_of_mujoco.csv", "engine_versions.csv")
)
SHOWN = 0.0125  # step of the errors that the lines on versions state


@pytest.mark.skipif(bool(missing()), reason=missing() or "present")
def test_what_was_seen_of_rebound_is_seen_again_or_the_page_is_old() -> None:
    written = pd.read_csv(DEFECTS).set_index("what")
    for defect, seen in of_rebound.seen().items():
        if seen or defect in written.index:
            assert seen == written.loc[defect, "seen"] or "AVX" in defect or "512" in defect


def unknown(written: pd.DataFrame, kept: pd.DataFrame) -> list[str]:
    """Figures of the lines on versions that are not those kept of the integrator, to the digits."""
    found = []
    for line in written[written["command"].str.startswith("`galvi studies")].to_dict("records"):
        name = line["what"].split()[0]
        errors = kept.loc[kept["integrator"] == name, "attitude_error"]
        known = {f"{x:{form}}" for x in errors for form in (".1e", ".3g")} | {f"{SHOWN:g}"}
        figures = re.findall(r"0\.\d+|\d\.\d+e-\d+", line["seen"].partition("attitude error")[2])
        found += [f"{name}: {figure}" for figure in figures if figure not in known]
        assert figures, line
    return found


def test_figures_of_mujoco_are_those_kept_of_its_versions_and_another_is_told() -> None:
    written = pd.concat([pd.read_csv(file) for file in (DEFECTS, CHANGES)], ignore_index=True)
    kept = pd.read_csv(VERSIONS)
    assert written["seen"].notna().all() and kept["date"].notna().all()
    assert unknown(written, kept) == []
    (order,) = kept.loc[kept["attitude_error"] == 4.67e-05, "order"].round().unique()
    assert order == 2 and written["what"].str.contains("with order 2 instead of 4").any()
    kept.loc[kept["integrator"] == "RK4", "attitude_error"] *= 1.01
    assert {one.split(":")[0] for one in unknown(written, kept)} == {"RK4"}
