"""Forces and integrators: quadruple runs have theory's rates, planted faults are seen."""

import csv
import sys
from pathlib import Path

import numpy as np
import pytest

from benchmarks.studies import forces
from references.heyoka.taylor import HEYOKA_QUADRUPLE
from references.rebound import extras, whfast512
from references.rebound.simulation import arithmetic_kept, simulation
from reports.studies.engines import FORCES

DOCS = Path(__file__).parents[3] / "docs"


@pytest.fixture(scope="module")
def frame():
    if HEYOKA_QUADRUPLE.missing:
        pytest.skip(HEYOKA_QUADRUPLE.missing)
    return forces.forces_table(quick=True)


def test_theory_and_galvi_are_right_and_a_wrong_sign_and_a_missing_kick_are_seen(frame):
    errors = frame.set_index(["force", "contender"])[["verdict", "error", "error_quarter"]]
    for name in forces.QUICK:
        assert errors.loc[(name, forces.THEORY), "verdict"] == forces.RIGHT
        ours = errors.loc[(name, forces.GALVI)]
        assert ours["verdict"] == forces.RIGHT
        assert max(ours["error"], ours["error_quarter"]) < 1e-10  # 1e-12
        missing = errors.loc[(name, forces.NO_KICK)]
        assert missing["verdict"] == forces.WRONG and abs(missing["error"] - 1.0) < 1e-3
    other = errors.loc[("J2", forces.WRONG_SIGN)]
    assert other["verdict"] == forces.WRONG and abs(other["error"] - 2.0) < 1e-3
    acts = frame[frame["status"] == "The force does not act."]["contender"]
    assert forces.NO_KICK in set(acts) and forces.GALVI not in set(acts)


def test_frame_and_clock_are_right_where_they_take_a_force_and_say_what_they_refuse(frame):
    rows = frame.set_index(["force", "contender"])
    for contender in (forces.FRAME, forces.CLOCK):
        right = rows.loc[("J2", contender)]
        assert right["verdict"] == forces.RIGHT
        assert max(right["error"], right["error_quarter"]) < 1e-9  # 1e-11
    refused, once = (rows.loc[(forces.QUICK[1], one)] for one in (forces.FRAME, forces.CLOCK))
    assert refused["verdict"] == forces.REFUSED and "a KeplerFrame takes" in refused["status"]
    assert once["verdict"] == forces.RIGHT and once["error"] < 1e-9  # 1e-11
    assert np.isnan(once["error_quarter"]) and once["status"] == forces.ONCE


def test_formulas_of_theory_with_a_fault_are_seen(frame):
    case = forces.CASES["J2"]
    true, theory = forces.Orbit(case, 0.2).truth()
    bound = frame[frame["force"] == "J2"]["bound"].iloc[0] * np.max(np.abs(true))
    assert np.max(np.abs(true - theory)) < bound
    for fault in (theory * [1, 1, -1, 1], theory * [1, 1, 1, 1.001], theory[[0, 1, 3, 2]]):
        assert np.max(np.abs(true - fault)) > bound


@pytest.mark.parametrize(
    ("errors", "found"),
    [
        ([1e-5, 1e-6], forces.RIGHT),
        ([1e-2, 1e-6], forces.LATER),
        ([0.5, 0.03], forces.LATER),
        ([0.4, 0.1], forces.WRONG),
        ([1e-5, 0.1], forces.WRONG),
        ([np.nan, 0.1], forces.WRONG),
        ([0.1, np.nan], forces.WRONG),
        ([1e-5, np.nan], forces.WRONG),
        ([2.0], forces.WRONG),
    ],
)
def test_a_verdict_takes_both_steps(errors, found):
    assert forces.verdict(np.array(errors), 1e-4) == found


@pytest.mark.slow(beside="test_the_table_of_the_docs_is_what_the_study_finds")
def test_the_whole_table_of_the_docs_is_what_the_study_finds():
    test_the_table_of_the_docs_is_what_the_study_finds(forces.forces_table())


def test_the_table_of_the_docs_is_what_the_study_finds(frame):
    if extras.missing():
        pytest.skip(extras.missing())
    text = (DOCS / "forces.md").read_text(encoding="utf-8")
    if f"With {extras.versions().replace(', ', ' and ')}:" not in text:
        pytest.skip(f"the table is of other versions than {extras.versions()}")
    with (DOCS / "data" / "forces.csv").open(encoding="utf-8", newline="") as file:
        lines = {(line["force"], line["e"]): line for line in csv.DictReader(file)}
    table, _ = FORCES.table(frame)
    assert len(lines) == sum(len(case.eccentricities) for case in forces.CASES.values())
    for row in table.to_dict("records"):
        shown = lines[row["force"], row["e"]]
        for contender, cell in row.items():
            (what, _, much), (said, _, printed) = (
                one.partition(" by ") for one in (cell, shown[contender])
            )
            assert what == said, (row, contender)
            if much:
                sizes = [float(one.removesuffix(" %")) for one in (much, printed)]
                assert sizes[0] == pytest.approx(sizes[1], rel=0.1, abs=0.1), (row, contender)
    assert sys.float_info.min / 2.0 > 0.0  # subnormal numbers are numbers still
    said = FORCES.summary(frame)
    assert extras.versions() in said and "REBOUND whfast: REBOUNDx: Passing a velocity" in said


def test_whfast512_chosen_after_a_force_was_added_runs_without_it():
    if extras.missing() or whfast512.missing():
        pytest.skip(extras.missing() or whfast512.missing())
    import reboundx

    ends = []
    for name in ("", "gr_potential"):
        made = simulation(forces.problem(0.2), "ias15", {})
        rebx = reboundx.Extras(made.engine)
        if name:
            force = rebx.load_force(name)
            rebx.add_force(force)
            force.params["c"] = 3.0
        made.engine.integrator, made.engine.dt = "whfast512", 0.1
        made.engine.integrator.concatenate_steps = 100
        made.engine.exact_finish_time = 0
        with arithmetic_kept():
            made.engine.steps(1)
        ends.append(made.states()[0])
    assert np.array_equal(*ends)
