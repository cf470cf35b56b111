"""The matrix of forces and integrators: theory and galvi are right, planted faults are seen."""

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
def force_rows():
    if HEYOKA_QUADRUPLE.missing:
        pytest.skip(HEYOKA_QUADRUPLE.missing)
    return forces.forces_table(quick=True)


def test_theory_and_galvi_are_right_and_a_wrong_sign_and_a_missing_kick_are_seen(force_rows):
    errors = force_rows.set_index(["force", "contender"])[["verdict", "error", "error_quarter"]]
    for name in forces.QUICK_FORCES:
        assert errors.loc[(name, forces.THEORY), "verdict"] == forces.RIGHT_VERDICT
        galvi_row = errors.loc[(name, forces.GALVI)]
        assert galvi_row["verdict"] == forces.RIGHT_VERDICT
        assert max(galvi_row["error"], galvi_row["error_quarter"]) < 1e-10  # 1e-12
        missing = errors.loc[(name, forces.NO_KICK)]
        assert missing["verdict"] == forces.WRONG and abs(missing["error"] - 1.0) < 1e-3
    wrong_sign = errors.loc[("J2", forces.WRONG_SIGN)]
    assert wrong_sign["verdict"] == forces.WRONG and abs(wrong_sign["error"] - 2.0) < 1e-3
    without_effect = force_rows[force_rows["status"] == "The force does not act."]["contender"]
    assert forces.NO_KICK in set(without_effect) and forces.GALVI not in set(without_effect)


def test_frame_and_clock_are_right_where_they_take_a_force_and_say_what_they_refuse(force_rows):
    rows = force_rows.set_index(["force", "contender"])
    for contender in (forces.FRAME, forces.CLOCK):
        right = rows.loc[("J2", contender)]
        assert right["verdict"] == forces.RIGHT_VERDICT
        assert max(right["error"], right["error_quarter"]) < 1e-9  # 1e-11
    refused, single = (
        rows.loc[(forces.QUICK_FORCES[1], contender)] for contender in (forces.FRAME, forces.CLOCK)
    )
    assert refused["verdict"] == forces.REFUSED and "a KeplerFrame takes" in refused["status"]
    assert single["verdict"] == forces.RIGHT_VERDICT and single["error"] < 1e-9  # 1e-11
    assert np.isnan(single["error_quarter"]) and single["status"] == forces.ONE_STEP_LENGTH_NOTE


def test_formulas_of_theory_with_a_fault_are_seen(force_rows):
    case = forces.CASES["J2"]
    true, theory = forces.Orbit(case, 0.2).truth()
    bound = force_rows[force_rows["force"] == "J2"]["bound"].iloc[0] * np.max(np.abs(true))
    assert np.max(np.abs(true - theory)) < bound
    for fault in (theory * [1, 1, -1, 1], theory * [1, 1, 1, 1.001], theory[[0, 1, 3, 2]]):
        assert np.max(np.abs(true - fault)) > bound


@pytest.mark.parametrize(
    ("errors", "expected"),
    [
        ([1e-5, 1e-6], forces.RIGHT_VERDICT),
        ([1e-2, 1e-6], forces.RIGHT_FOR_SHORT_STEPS),
        ([0.5, 0.03], forces.RIGHT_FOR_SHORT_STEPS),
        ([0.4, 0.1], forces.WRONG),
        ([1e-5, 0.1], forces.WRONG),
        ([np.nan, 0.1], forces.WRONG),
        ([0.1, np.nan], forces.WRONG),
        ([1e-5, np.nan], forces.WRONG),
        ([2.0], forces.WRONG),
    ],
)
def test_a_verdict_takes_both_steps(errors, expected):
    assert forces.verdict(np.array(errors), 1e-4) == expected


@pytest.mark.slow(beside="test_the_table_of_the_docs_is_what_the_study_finds")
def test_the_whole_table_of_the_docs_is_what_the_study_finds():
    test_the_table_of_the_docs_is_what_the_study_finds(forces.forces_table())


def test_the_table_of_the_docs_is_what_the_study_finds(force_rows):
    if extras.missing():
        pytest.skip(extras.missing())
    text = (DOCS / "forces.md").read_text(encoding="utf-8")
    if f"With {extras.versions().replace(', ', ' and ')}:" not in text:
        pytest.skip(f"the table is of other versions than {extras.versions()}")
    with (DOCS / "data" / "forces.csv").open(encoding="utf-8", newline="") as file:
        lines = {(line["force"], line["e"]): line for line in csv.DictReader(file)}
    table, _ = FORCES.table(force_rows)
    assert len(lines) == sum(len(case.eccentricities) for case in forces.CASES.values())
    for row in table.to_dict("records"):
        shown = lines[row["force"], row["e"]]
        for contender, cell in row.items():
            (verdict, _, size), (printed_verdict, _, printed_size) = (
                text.partition(" by ") for text in (cell, shown[contender])
            )
            assert verdict == printed_verdict, (row, contender)
            if size:
                sizes = [float(text.removesuffix(" %")) for text in (size, printed_size)]
                assert sizes[0] == pytest.approx(sizes[1], rel=0.1, abs=0.1), (row, contender)
    assert sys.float_info.min / 2.0 > 0.0  # subnormal numbers are numbers still
    summary = FORCES.summary(force_rows)
    assert (
        extras.versions() in summary and "REBOUND whfast: REBOUNDx: Passing a velocity" in summary
    )


def test_whfast512_chosen_after_a_force_was_added_runs_without_it():
    if extras.missing() or whfast512.missing():
        pytest.skip(extras.missing() or whfast512.missing())
    import reboundx

    ends = []
    for name in ("", "gr_potential"):
        sim = simulation(forces.problem(0.2), "ias15", {})
        rebx = reboundx.Extras(sim.engine)
        if name:
            force = rebx.load_force(name)
            rebx.add_force(force)
            force.params["c"] = 3.0
        sim.engine.integrator, sim.engine.dt = "whfast512", 0.1
        sim.engine.integrator.concatenate_steps = 100
        sim.engine.exact_finish_time = 0
        with arithmetic_kept():
            sim.engine.steps(1)
        ends.append(sim.states()[0])
    assert np.array_equal(*ends)
