"""The table of public models is that of the wheels that are kept, and a change of it is seen."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pandas as pd
import pytest

from benchmarks.studies import public_models as public

ROOT = Path(__file__).parents[3]
CLOSE = 1e-11  # 1e-12: MuJoCo's rounding and ours, in trees of 56 velocities


def stored() -> pd.DataFrame:
    table = pd.read_csv(ROOT / public.TABLE, keep_default_na=False)
    return table.assign(difference=pd.to_numeric(table["difference"]))


def changes(before: pd.DataFrame, now: pd.DataFrame) -> list[str]:
    """What is said of a model in one table and not in the other; and differences above CLOSE."""
    words = ["model", "version", "velocities", "left_out", "why_not"]
    rows = (table[words].itertuples(index=False) for table in (before, now))
    one, other = ({tuple(row) for row in table} for table in rows)
    large = now[now["difference"] > CLOSE]["model"]
    return sorted(f"{row}" for row in one ^ other) + sorted(large)


def test_the_table_is_of_the_wheels_that_are_kept() -> None:
    line = (ROOT / "Makefile").read_text().partition("\nMODELS ?= ")[2].partition("\nBIN")[0]
    pinned = dict(word.split("==") for word in line.replace("\\", " ").split())
    table = stored()
    folders = table["model"].str.partition("/")[0].str.replace("_", "-")
    found = dict(zip(folders, table["version"], strict=True))
    assert found.pop("mujoco")
    assert found == {name.replace("_", "-"): version for name, version in pinned.items()}


def test_every_public_model_that_moves_and_that_mujoco_reads_is_read() -> None:
    table = stored()
    assert len(table) == 153 and table["velocities"].max() == 132
    assert (table["why_not"] == "").equals(table["velocities"] > 0)
    assert table["difference"].max() <= CLOSE
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
    kept = {tuple(wheel.name.split("-")[:2]) for wheel in public.WHEELS.glob("*.whl")}
    asked = stored()
    engines = {("mujoco", version) for version in asked["version"]}
    packages = asked["model"].str.partition("/")[0]
    if not set(zip(packages, asked["version"], strict=True)) <= {*kept, *engines}:
        pytest.skip(f"{public.WHEELS.name} in the environment lacks wheels: make install")
    assert changes(asked, public.table()) == []
