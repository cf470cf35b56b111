"""Work-precision problems: who takes part, their truths, and wrong laws that are seen."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import pandas as pd
import pytest

import galvi
from benchmarks.work_precision import run as work_precision
from benchmarks.work_precision.galvi_methods import InClock, gauss_collocation
from benchmarks.work_precision.own_problem import ADAPTIVE, FIXED
from benchmarks.work_precision.participants import readable_setting
from benchmarks.work_precision.problem import (
    ANGLE,
    ATTITUDE,
    COORDINATES,
    MOTION,
    Participant,
    WorkPrecisionProblem,
    largest_difference,
)
from benchmarks.work_precision.problems import work_precision_problems
from benchmarks.work_precision.problems.arms import brownout, skew_arm
from benchmarks.work_precision.problems.encounters import ENCOUNTERS, clock_label
from benchmarks.work_precision.problems.pendulums import (
    double_pendulum,
    elastic_pendulum,
    fermi_pasta_ulam_tsingou,
    henon_heiles,
    planar_chain,
)
from benchmarks.work_precision.problems.planets import (
    applegate,
    kepler_polar,
    outer_solar_system,
    solar_system,
)
from benchmarks.work_precision.problems.rigid_bodies import (
    MUJOCO_CONTENDERS,
    TEXTBOOK_DOP853,
    TEXTBOOK_RK4,
    free_body,
    free_body_se3,
    heavy_top,
    pendulum,
)
from benchmarks.work_precision.truths import TRUTHS
from galvi import Problem, Trajectory
from galvi.charts import CHARTS
from references import reference
from references.mujoco.accelerations_ivp import MUJOCO_ACCELERATIONS
from references.mujoco.steps import MUJOCO_RK4
from references.scipy.ivp import DOP853, TIGHT
from reports.figures.drawing import ERROR_MEASURES

Make = Callable[[bool], WorkPrecisionProblem]
PLANETS = (outer_solar_system, solar_system, applegate)


def gauss(*degrees: int, suffix: str = "") -> set[str]:
    return {f"galvi degree {s}, Gauss {s}{suffix}" for s in degrees}


def by_label(case: WorkPrecisionProblem) -> dict[str, Participant]:
    return {participant.label: participant for participant in case.participants}


def error_of(case: WorkPrecisionProblem, run: Trajectory) -> float:
    return case.distance(run.q[-1], case.truth().end)


@pytest.mark.parametrize("quick", [True, False])
def test_the_arenas_name_each_contender_once_and_use_whole_steps(quick: bool) -> None:
    for case in work_precision_problems(quick):
        assert len(by_label(case)) == len(case.participants) and case.quantity in ERROR_MEASURES
        for _, contender, settings in case.participants:
            assert settings and contender.supports(case.problem)
            for setting in settings:
                if "step" in setting and not isinstance(contender, InClock):
                    assert (case.duration / setting["step"]) == pytest.approx(
                        setting["save_every"], rel=1e-12
                    )


# ---- who takes part

ON_BODIES = {TEXTBOOK_RK4, TEXTBOOK_DOP853, *(engine.name for engine in MUJOCO_CONTENDERS)}
ON_BODIES |= {
    label for chart in CHARTS for label in gauss(4, 6, 8, 10, 12, suffix=f", {chart.name}")
}
MORE = {f"galvi degree {s}, Gauss {s + 1}, Cayley" for s in (6, 8, 10)}
ON_CHAINS = {
    "MuJoCo RK4",
    "MuJoCo implicit",
    "SciPy DOP853, chains",
    "heyoka, chains",
    *gauss(4, 8),
}
ON_COORDINATES = {"heyoka, Lagrangians", *gauss(4, 6, 8, 12)}
IN_SPACE = {"REBOUND SABA", "heyoka", "REBOUND IAS15", "REBOUND WHFast, best", *gauss(8, 12, 16)}
IN_CLOCKS = {
    "REBOUND IAS15",
    "REBOUND BS",
    "heyoka",
    "SciPy DOP853",
    *map(clock_label, (8, 12, 16)),
}
SCIPY, WHFAST512, TRACE = "SciPy DOP853", "REBOUND WHFast512", "REBOUND TRACE"
HEAVY_TOP = {MUJOCO_RK4.name, TEXTBOOK_DOP853, "heyoka, rigid bodies"}
# problem: (contenders that take part, contenders that do not, their number or None, quantity of
# the errors or "")
TAKE_PART: dict[Make, tuple[set[str], set[str], int | None, str]] = {
    free_body: (ON_BODIES | MORE, set(), None, ATTITUDE),
    pendulum: (ON_BODIES, MORE, None, ATTITUDE),
    heavy_top: (HEAVY_TOP, set(), 7, ATTITUDE),
    double_pendulum: (ON_CHAINS, set(), None, ANGLE),
    planar_chain: (ON_CHAINS, set(), None, ANGLE),
    elastic_pendulum: (ON_COORDINATES, set(), 6, COORDINATES),
    henon_heiles: (ON_COORDINATES, set(), 6, COORDINATES),
    fermi_pasta_ulam_tsingou: (ON_COORDINATES, set(), 6, COORDINATES),
    kepler_polar: (ON_COORDINATES, set(), 6, COORDINATES),
    free_body_se3: (gauss(5, suffix=", general kernel"), set(), None, MOTION),
    brownout: (gauss(4, suffix=", general kernel"), set(), None, COORDINATES),
    outer_solar_system: (IN_SPACE | {SCIPY}, {WHFAST512}, None, ""),
    solar_system: (IN_SPACE | {SCIPY, WHFAST512}, set(), None, ""),
    applegate: (IN_SPACE, {SCIPY, WHFAST512}, None, ""),
}
# relative to the largest entry
TRUTH_ERRORS = {ATTITUDE: 2e-16, ANGLE: 1e-15, MOTION: 1e-15, COORDINATES: 2e-15}
for make in ENCOUNTERS:
    dominant = make(False).problem.name == "HD 80606 and a companion"
    TAKE_PART[make] = (
        (IN_CLOCKS | {TRACE}, set(), None, "") if dominant else (IN_CLOCKS, {TRACE}, None, "")
    )


@pytest.mark.parametrize("make", TAKE_PART)
def test_everyone_takes_part_and_the_truth_is_better_than_they_are(make: Make) -> None:
    present, absent, number, quantity = TAKE_PART[make]
    for quick in (True, False):
        case, truth = make(quick), make(quick).truth()
        labels = by_label(case)
        assert present <= set(labels) and not absent & set(labels), make
        assert number in (None, len(labels)) and quantity in ("", case.quantity)
        if make in PLANETS:
            assert "quadruple" in truth.description or "real128" in truth.description
        assert truth.source is None
        assert truth.error < (
            TRUTH_ERRORS[quantity] * np.abs(truth.end).max() if quantity else 1e-11
        )


def test_contenders_take_part_at_their_defaults_and_at_their_best() -> None:
    for make in PLANETS:
        settings = {
            label: participant.settings for label, participant in by_label(make(True)).items()
        }
        assert settings["REBOUND IAS15"][0]["adaptive_mode"] == "PRS23"
        assert settings["REBOUND IAS15, GLOBAL"][0]["adaptive_mode"] == "GLOBAL"
        for name, mode in (("best", 0), ("default", 1)):
            assert all(
                setting["safe_mode"] == mode for setting in settings[f"REBOUND WHFast, {name}"]
            )
    for make, degree in ((free_body_se3, 5), (brownout, 4)):
        fast, general = (
            by_label(make(False))[next(iter(gauss(degree, suffix=suffix)))]
            for suffix in ("", ", general kernel")
        )
        assert general.contender == fast.contender
        assert [{**setting, "solver": "newton"} for setting in fast.settings] == list(
            general.settings
        )


def test_applegate_s_planets_meet_the_contenders_of_the_outer_planets_but_for_the_slowest() -> None:
    of_applegate, of_outer = by_label(applegate(False)), by_label(outer_solar_system(False))
    assert set(of_outer) - set(of_applegate) == {
        "SciPy DOP853",
        *(f"galvi Kepler frame, Gauss {s}, 2 passes" for s in (8, 16)),
    }
    assert all(
        len(participant.settings) <= len(of_outer[label].settings)
        for label, participant in of_applegate.items()
    )


def test_the_quick_report_leaves_applegate_out_and_most_encounters() -> None:
    of_quick, of_full = (
        {case.problem.name for case in work_precision_problems(quick)} for quick in (True, False)
    )
    met, left_out = {make(False).problem.name for make in ENCOUNTERS}, of_full - of_quick
    assert of_quick < of_full and left_out - met == {"outer solar system after Applegate"}
    assert met - left_out == {"Burrau's problem", "two bodies, e = 0.99"}


# ---- truths


def test_the_truth_of_a_grain_holds_as_far_as_it_says() -> None:
    case = brownout(True)
    loose = {"samples": 1, "rtol": 10.0 * TIGHT["rtol"], "atol": 10.0 * TIGHT["atol"]}
    run = DOP853.run(case.problem, case.duration, loose)
    assert error_of(case, run) < 4.0 * case.truth().error
    galvi_run = gauss_collocation(6).run(case.problem, case.duration, {"step": 0.005})
    assert error_of(case, galvi_run) < 1e-11


def test_of_a_contender_that_is_the_truth_only_the_run_that_it_is_is_not_compared() -> None:
    pytest.importorskip("mujoco")
    case = skew_arm(quick=False)
    source = case.truth().source
    labels = [
        (participant.label, readable_setting(setting))
        for participant in case.participants
        for setting in participant.settings
    ]
    assert labels.count(source) == 1 and [label for label, _ in labels].count(source[0]) > 2


# ---- errors and times


def study(case: WorkPrecisionProblem, *labels: str, **changes: Any) -> pd.DataFrame:
    """The problem with these contenders only, in the quick setting."""
    participants = tuple(
        participant for participant in case.participants if participant.label in labels
    )
    reduced = replace(case, participants=participants, **changes)
    return work_precision._study(reduced, lambda sentence: None, quick=True)


def test_errors_are_of_the_attitude_and_times_of_the_whole_run() -> None:
    galvi_label = "galvi degree 8, Gauss 8, Cayley"
    rows = study(free_body(True), galvi_label, TEXTBOOK_RK4, TEXTBOOK_DOP853)
    assert (rows["quantity"] == ATTITUDE).all() and rows["seconds"].gt(0.0).all()
    errors = rows.groupby("contender")["error"].min()
    assert errors[galvi_label] < 1e-10 and errors[TEXTBOOK_DOP853] < 1e-9  # 1.2e-11, 8.9e-11
    longer, shorter = rows[rows["contender"] == TEXTBOOK_RK4].to_dict("records")[::-1]
    assert longer["seconds"] / shorter["seconds"] > 4.0  # 16 times as many steps: 15 times


def test_the_error_is_the_largest_difference_of_an_entry() -> None:
    assert largest_difference(np.array([1.0, -2.0]), np.array([1.5, 1.0])) == 3.0
    assert np.isnan(largest_difference(np.array([np.nan, 0.0]), np.zeros(2)))


@dataclass(frozen=True)
class WrongLaw:
    """galvi on a problem with a wrong force law."""

    problem: Problem
    name: str = "galvi, wrong law"
    missing: str = ""

    def supports(self, problem: Problem) -> bool:
        return True

    def run(self, problem: Problem, duration: float, setting: Mapping[str, Any]) -> Trajectory:
        return gauss_collocation(8).run(self.problem, duration, setting)


def pulled_up() -> Problem:
    """The pendulum with a planted fault: its weight pulls up."""
    problem: Any = pendulum(True).problem
    weight = problem.system.potential
    up = galvi.UniformGravity(weight.mass, weight.centre, -weight.g)
    return Problem(galvi.RigidBody(problem.system.inertia, up), problem.q0, problem.v0)


@pytest.mark.parametrize(
    ("make", "wrong"),
    [
        (elastic_pendulum, lambda: galvi.problems.elastic_pendulum(stiffness=40.4)),
        (fermi_pasta_ulam_tsingou, lambda: galvi.problems.fermi_pasta_ulam_tsingou(beta=0.01)),
        (free_body_se3, lambda: galvi.problems.free_body_se3(g=(0.0, 0.0, -0.01))),
        (pendulum, pulled_up),
    ],
)
def test_a_wrong_law_stands_out_though_it_conserves_its_own_energy(
    make: Make, wrong: Callable[[], Problem]
) -> None:
    case = make(True)
    label = next(label for label in by_label(case) if label.startswith("galvi degree 8, Gauss 8"))
    participant, contender = by_label(case)[label], WrongLaw(wrong())
    planted = Participant(contender.name, contender, participant.settings)
    rows = study(
        replace(case, participants=(participant, planted)),
        label,
        planted.label,
        repeated_run=False,
        net_time=False,
    )
    correct_error, planted_error = (
        rows["error"][rows["contender"] == x].max() for x in (label, planted.label)
    )
    assert correct_error < 1e-5 < 1e-4 < planted_error
    energy = galvi.energy(contender.run(case.problem, case.duration, participant.settings[0]))
    assert np.ptp(energy) < 1e-6 * max(1.0, abs(energy[0]))


# ---- problems of one's own

TEXTBOOK = {"Stormer-Verlet", "Forest-Ruth", "RK4"}
MUJOCO_CODES = {f"MuJoCo {name}" for name in ("RK4", "Euler", "implicit", "implicitfast")}
REBOUND_CODES = {
    f"REBOUND {name}"
    for name in ("WHFast", "SABA", "MERCURIUS", "TRACE", "leapfrog", "BS", "IAS15")
}


def potential(q):
    return 0.5 * np.log(0.01 + q[0] ** 2 + (q[1] / 0.9) ** 2)


def gradient(q):
    square = 0.01 + q[0] ** 2 + (q[1] / 0.9) ** 2
    return np.array([q[0] / square, q[1] / (0.81 * square)])


def of_potential(potential_gradient=None, **options):
    return galvi.Problem(
        galvi.Canonical(1.0, potential, potential_gradient, **options), [0.8, 0.1], [0.1, 0.5]
    )


def by_hand():
    """Two rods on hinges that are askew."""
    upper = galvi.Joint("hinge", axis=(0.0, 1.0, 0.0), damping=0.1)
    lower = galvi.Joint("hinge", axis=(1.0, 0.0, 0.0))
    links = (
        galvi.Link(upper, 1.0, (0.0, 0.0, -0.3), (0.1, 0.1, 0.02)),
        galvi.Link(lower, 0.5, (0.0, 0.0, -0.2), (0.05, 0.05, 0.01), parent=0, place=(0, 0, -0.6)),
    )
    return galvi.Problem(galvi.Multibody(links), [0.7, 0.4], [0.1, 0.2])


def bodies():
    return galvi.Problem(
        galvi.NBody([1.0, 1e-3, 1e-4]),
        [[0.0, 0.0], [1.0, 0.0], [0.0, 2.0]],
        [[0.0, 0.0], [0.0, 1.0], [-0.7, 0.0]],
    )


# kind: a problem, the codes that take it, the name of its truth
KINDS = {
    "a potential with its gradient": (
        lambda: of_potential(gradient),
        {"SciPy DOP853", "heyoka, Lagrangians", *TEXTBOOK},
        "heyoka, Lagrangians, quadruple precision",
    ),
    "a potential alone": (
        of_potential,
        {"SciPy DOP853", "heyoka, Lagrangians", *TEXTBOOK},
        "heyoka, Lagrangians, quadruple precision",
    ),
    "a potential and friction": (
        lambda: of_potential(gradient, force=lambda q, v: -0.1 * v),
        {"SciPy DOP853", "heyoka, Lagrangians"},
        "heyoka, Lagrangians, quadruple precision",
    ),
    "point masses": (
        bodies,
        {"SciPy DOP853", "heyoka", "REBOUND WHFast512", *REBOUND_CODES, *TEXTBOOK},
        "heyoka, quadruple precision",
    ),
    "a tree made by hand": (
        by_hand,
        {*MUJOCO_CODES, MUJOCO_ACCELERATIONS.name, "SciPy DOP853 on Pinocchio's accelerations"},
        MUJOCO_ACCELERATIONS.name,
    ),
}


@pytest.mark.parametrize("kind", KINDS)
def test_each_kind_of_problem_goes_to_the_codes_that_take_it(kind):
    make, expected, truth = KINDS[kind]
    problem = make()
    names = [*FIXED, *ADAPTIVE]
    takers = [name for name in names if reference(name).supports(problem)]
    assert set(takers) == expected and len(takers) == len(set(takers))
    assert next(name for name in TRUTHS if reference(name).supports(problem)) == truth
    assert {reference(name).fixed_step for name in FIXED} == {True}
    assert {reference(name).fixed_step for name in (*ADAPTIVE, *TRUTHS)} == {False}
