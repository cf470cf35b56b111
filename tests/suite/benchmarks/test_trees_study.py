"""Trees: galvi's methods and MuJoCo's integrators have their orders, no less and no more."""

from __future__ import annotations

from dataclasses import replace

import pandas as pd
import pytest

import galvi
from benchmarks.studies import trees as study
from benchmarks.work_precision.galvi_methods import Variational, gauss_collocation
from reports.studies.engines import orders, trees_table

pytest.importorskip("mujoco")
METHODS = 6  # on each of two trees


@pytest.fixture(scope="module")
def tree_rows() -> pd.DataFrame:
    return study.tree_study(quick=True)


def misses(tree_rows: pd.DataFrame) -> list[float]:
    """For each fit, the distance of its order from theory's plus twice its uncertainty."""
    theory = tree_rows.groupby(["problem", "contender"], sort=False)["order"].first()
    return [
        abs(fit.rate - theory[key]) + 2.0 * fit.uncertainty
        for key, fit in orders(tree_rows).items()
    ]


@pytest.mark.slow(beside="test_a_tree_with_an_armature_off_by_a_millionth_loses_the_order")
def test_every_integrator_has_its_order_on_both_trees(tree_rows: pd.DataFrame) -> None:
    assert tuple(tree_rows.columns) == study.COLUMNS and (tree_rows["status"] == "").all()
    order_misses = misses(tree_rows)
    assert len(order_misses) == 2 * METHODS and max(order_misses) < 0.25  # 0.08
    assert tree_rows["unsure"].max() < 1e-11


@pytest.mark.slow(beside="test_scaling.py::test_every_setting_of_every_contender_has_its_row")
def test_the_finest_steps_are_timed_and_shown(tree_rows: pd.DataFrame) -> None:
    timed = tree_rows["seconds_per_step"].dropna()  # on a busy machine not all of them are
    assert (timed > 0.0).all()
    table, _ = trees_table(tree_rows)
    assert len(table) == 2 * METHODS and set(table["order"]) == {"1", "2", "4", "6"}
    assert (table["error"] != "").all() and (table["time to 1e-06"] != "").sum() == len(timed)


def test_a_tree_with_an_armature_off_by_a_millionth_loses_the_order() -> None:
    """The planted fault."""

    class Wrong(Variational):
        def run(self, problem, duration, setting):
            links = [
                replace(
                    link, joints=[replace(j, armature=j.armature * 1.000001) for j in link.joints]
                )
                for link in problem.system.links
            ]
            system = galvi.Multibody(links, problem.system.gravity)
            return super().run(replace(problem, system=system), duration, setting)

    tree = study.trees()[0]
    wrong = Wrong(gauss_collocation(3).method)
    truth, unsure = study.truth(tree)
    rows = [study.row(tree, wrong.name, wrong, 6, n, truth, unsure) for n in tree.counts[3]]
    assert not misses(pd.DataFrame(rows))[0] <= 1.0  # NaN where nothing can be fitted


def test_without_mujoco_the_section_says_so(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("references.mujoco.engine.missing", lambda: "No MuJoCo here.")
    table, _ = trees_table(study.tree_study())
    assert list(table["status"]) == ["No MuJoCo here."]
