"""Defects of other codes: what the kept tables say follows from them, and planted ones are told."""

from __future__ import annotations

import pandas as pd
import pytest

from benchmarks.experiments import engine_defects, signatures
from benchmarks.experiments.engine_defects import DEFECTS, VERSIONS, changes, of_versions, span
from benchmarks.studies.engine_versions import NESTED
from references.rebound import defects as of_rebound
from references.rebound.simulation import missing

OLD, NEW = "mujoco 3.6.0", "mujoco-core 4.0.1"


@pytest.fixture
def kept() -> pd.DataFrame:
    return pd.read_csv(VERSIONS)


def test_what_is_said_of_versions_follows_from_what_is_kept_of_them(kept: pd.DataFrame) -> None:
    written = pd.read_csv(DEFECTS)
    said = written.loc[written["command"] == engine_defects.OF_VERSIONS]
    found = [("defect", *one) for one in of_versions(kept)]
    found += [("change", *one) for one in changes(kept)]
    assert (
        list(said[["kind", "what", "versions", "seen"]].itertuples(index=False, name=None)) == found
    )
    assert any(one.startswith("RK4 turns a body") for one in said["what"])
    assert written["date"].notna().all() and written["seen"].notna().all()


def test_planted_an_order_a_nested_body_and_a_new_step_are_told(kept: pd.DataFrame) -> None:
    sound = kept[kept["engine"] == NEW]
    assert not list(of_versions(sound)) and not list(changes(sound))
    for row, column, value, word in (
        (("RK4", "ball"), "order", 2.0, "order 2 instead of 4"),
        (("Euler", NESTED), "attitude_error", 0.5, "half of its inertia"),
    ):
        wrong = sound.copy()
        here = (wrong["integrator"] == row[0]) & (wrong["joint"] == row[1])
        wrong.loc[here, column] = value
        (told,) = of_versions(wrong)
        assert word in told[0] and "4.0.1" in told[1]
    before = sound.assign(engine="mujoco-core 4.0.0")
    before["attitude_error"] *= before["integrator"].map(lambda one: 1.5 if one == "RK4" else 1.0)
    (told,) = changes(pd.concat([before, sound]))
    assert told[0] == "RK4 turns a free body otherwise" and told[1].endswith("4.0.0 to 4.0.1")


def test_versions_between_are_named_where_they_are_not_all() -> None:
    ran = ["mujoco 1.0", "mujoco 2.0", "mujoco 3.0"]
    assert span(ran[:2], ran) == "mujoco 1.0 to 2.0; ran: 1.0, 2.0, 3.0"
    assert span([ran[0], ran[2]], ran).startswith("mujoco 1.0, 3.0;")


@pytest.mark.skipif(bool(missing()), reason=missing() or "present")
def test_what_was_seen_of_rebound_is_seen_again_or_the_page_is_old() -> None:
    written = pd.read_csv(DEFECTS).set_index("what")
    for defect, seen in of_rebound.seen().items():
        if seen or defect in written.index:
            assert seen == written.loc[defect, "seen"] or "AVX" in defect or "512" in defect


def test_a_version_that_moves_otherwise_fails_or_is_gone_is_told() -> None:
    names = {"problem": "p", "settings": "step=1", "engines": "engine 1"}
    here = pd.DataFrame(
        [{**names, "contender": who, "error": error, "status": ""}
         for who, error in (("same", 1e-3), ("round-off", 1e-14), ("other", 1e-3), ("ends", 1e-3),
                            ("gone", 1e-3))]
    )  # fmt: skip
    new = here.assign(error=[1.001e-3, 4e-13, 2e-3, float("nan"), 1e-3])
    new.loc[3, "status"] = "It failed."
    assert list(signatures.differences(here, here)) == []
    assert list(signatures.differences(here, new[:4])) == [
        "p, other, step=1: the error 0.001 became 0.002.",
        "p, ends, step=1: '' became 'It failed.'.",
        "p, gone, step=1: not there.",
    ]
