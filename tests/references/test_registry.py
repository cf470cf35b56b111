"""The contract that every registered reference keeps."""

from __future__ import annotations

import importlib
import pkgutil
import re
import subprocess
import sys
from dataclasses import replace

import numpy as np
import pytest

import galvi
import references
from references import CODES, REFERENCES, Contender, EngineMissing, Reference, named, reference
from references.textbook.lagrange_equations import LagrangeEquations

ORBIT = galvi.problems.kepler(0.3)
SPRING = galvi.problems.harmonic_oscillator()
PLANETS = galvi.problems.solar_system(pluto=False)
BODY = galvi.problems.free_body_se3()
SWING = galvi.problems.planar_pendulum()
FREE_BODY = galvi.problems.free_rigid_body()
HANGING = galvi.problems.pendulum_3d()
CHAIN = galvi.problems.double_pendulum()
SPRUNG = galvi.problems.elastic_pendulum()
ARM = galvi.problems.skew_arm()
SOLVABLE = (SPRING, ORBIT, PLANETS, BODY, SWING, FREE_BODY, HANGING, CHAIN, SPRUNG, ARM)
UNKNOWN = galvi.Problem(galvi.Canonical(1.0, lambda q: float(q @ q) ** 2), [1.0], [0.0])
ON_GROUPS = (
    FREE_BODY,
    BODY,
    galvi.problems.free_box(),
    galvi.problems.heavy_top(),
    HANGING,
    galvi.problems.spherical_pendulum(),
)


def code(word):
    return named(word, ORBIT)


NAMES = [contender.name for contender in REFERENCES]
every_reference = pytest.mark.parametrize("contender", REFERENCES, ids=NAMES)
PRESENT = [contender for contender in REFERENCES if not contender.missing]
every_present = pytest.mark.parametrize("contender", PRESENT, ids=lambda c: c.name)


STORED_DURATIONS = {  # durations to whose eighths these references have states
    "stored truth": 5844.0,
    "stored truth, rigid bodies": 16.0,
    "stored truth, chains": 8.0,
    "stored truth, Lagrangians": 8.0,
    "JPL DE421": -5844.0,
}


def setting(contender: Contender, duration: float, pieces: int) -> dict[str, float]:
    """The smallest setting for a run with `pieces` states after the start."""
    return {"step": duration / pieces} if contender.fixed_step else {"samples": pieces}


def solvable(contender: Contender) -> galvi.Problem:
    return next(problem for problem in SOLVABLE if contender.supports(problem))


def test_every_contender_of_every_module_is_registered():
    contenders = {}
    for module in pkgutil.walk_packages(references.__path__, "references."):
        for value in vars(importlib.import_module(module.name)).values():
            if isinstance(value, Contender) and not isinstance(value, type):
                contenders[id(value)] = value
    assert {id(contender) for contender in REFERENCES} == set(contenders)


def test_names_are_unique_and_find_their_reference():
    assert len(set(NAMES)) == len(NAMES)
    assert all(reference(contender.name) is contender for contender in REFERENCES)


UNKNOWN_NAMES = [
    *((reference, word, "Did you mean 'REBOUND IAS15'") for word in ("REBOUND IAS14", "ias15")),
    *((reference, word, "Did you mean 'MuJoCo RK4'") for word in ("mujoco rk4", "MuJoCo rk4")),
    (reference, "DOP853", "Did you mean 'SciPy DOP853'"),
    (reference, "dop853, chains", "Did you mean 'SciPy DOP853, chains'"),
    (reference, "whfast", "Did you mean 'REBOUND WHFast'"),
    (reference, "de421", "Did you mean 'JPL DE421'"),
    (reference, "Heyoka", "Did you mean 'heyoka'"),
    (reference, "closed form kepler", "'Kepler, closed form', .*Did you mean 'Kepler, "),
    *((code, word, "Did you mean 'rebound.whfast'") for word in ("rebound.whfst", "WHFast")),
    (code, "mujoco.RK4", "Did you mean 'mujoco.rk4'"),
    (code, "textbook.verlet", "Did you mean 'textbook.stormer_verlet'"),
]


@pytest.mark.parametrize(("lookup", "word", "meant"), UNKNOWN_NAMES)
def test_an_unknown_name_is_answered_with_the_nearest(lookup, word, meant):
    with pytest.raises(ValueError, match=f"received '{word}'") as refusal:
        lookup(word)
    assert re.search(meant, str(refusal.value))


def test_the_truths_are_those_we_know():
    exact = {contender.name for contender in REFERENCES if contender.exact}
    assert exact == {
        "oscillator, closed form",
        "Kepler, closed form",
        "pendulum, closed form",
        "free rigid body, closed form",
        "thrown body, closed form",
        "stored truth",
        "stored truth, rigid bodies",
        "stored truth, chains",
        "stored truth, Lagrangians",
        "REBOUND IAS15",
        "heyoka, quadruple precision",
        "heyoka, rigid bodies, quadruple precision",
        "heyoka, chains, quadruple precision",
        "heyoka, Lagrangians, quadruple precision",
    }


@every_present
def test_a_run_says_when_and_how_it_was_made(contender):
    problem, duration = solvable(contender), STORED_DURATIONS.get(contender.name, -1.0)
    late = galvi.Problem(problem.system, problem.q0, problem.v0, t0=5.0)
    run = contender.run(late, duration, setting(contender, duration, 8))
    assert run.success and run.status.startswith("Completed") and run.failed_step is None
    np.testing.assert_allclose(run.t, 5.0 + duration * np.arange(9) / 8.0, rtol=1e-15)
    assert run.q.shape == (9, *problem.q0.shape) and run.p.shape == (9, *problem.v0.shape)
    assert np.array_equal(run.q[0], problem.q0) and np.array_equal(run.p[0], problem.p0)
    assert not run.q.flags.writeable
    assert contender.name in run.method and run.problem is late
    assert (run.step is not None) == contender.fixed_step
    assert "steps" in run.counts or "force_evaluations" in run.counts


@every_present
def test_a_contender_is_set_by_a_step_or_by_samples_and_refuses_other_settings(contender):
    assert isinstance(contender, Reference) and isinstance(contender.fixed_step, bool)
    problem, valid = solvable(contender), setting(contender, 1.0, 1)
    key, typed, foreign = (
        ("step", "steq", "samples") if contender.fixed_step else ("samples", "sample", "step")
    )
    for duration, settings, message in (
        (1.0, {typed: 1}, f"received '{typed}'. Did you mean '{key}'"),
        (1.0, {foreign: 1}, f"received '{foreign}'"),
        *((duration, valid, "duration must") for duration in (0.0, float("nan"), float("inf"))),
    ):
        with pytest.raises(ValueError, match=message):
            contender.run(problem, duration, settings)


@pytest.mark.parametrize("name", CODES)
def test_a_code_is_the_first_of_its_contenders_that_solves_the_problem(name):
    contenders = CODES[name]
    assert set(contenders) <= set(REFERENCES)
    assert len({contender.fixed_step for contender in contenders}) == 1
    assert {name.partition(".")[0]} == {folder_of(contender) for contender in contenders}
    for problem in (*SOLVABLE, UNKNOWN):
        able = [contender for contender in contenders if contender.supports(problem)]
        if able:
            assert named(name, problem) is able[0]
            continue
        system_name = type(problem.system).__name__
        with pytest.raises(
            ValueError, match=f"^{name} does not solve this .* {system_name} system"
        ):
            named(name, problem)


def folder_of(contender: Contender) -> str:
    """The contender's folder in references/; "scipy" for those whose name begins with SciPy."""
    if contender.name.startswith("SciPy"):
        return "scipy"
    return type(contender).__module__.split(".")[1]


def test_a_code_goes_by_its_full_name_and_heyoka_by_its_own():
    for contender in REFERENCES:
        if contender.name != "heyoka":
            assert named(contender.name, solvable(contender)) is contender
    for name in ("heyoka", "heyoka.taylor"):
        assert named(name, FREE_BODY) is reference("heyoka, rigid bodies")
    assert named("scipy.dop853", UNKNOWN).name == "SciPy DOP853"
    assert named("scipy.dop853", CHAIN).name == "SciPy DOP853, chains"


def test_a_code_that_does_not_solve_a_problem_is_refused_with_the_reason():
    with pytest.raises(TypeError, match="must be a string; received 3"):
        named(3, ORBIT)
    dragged = replace(SPRING, system=replace(SPRING.system, force=lambda q, v: -v))
    with pytest.raises(ValueError, match=r"^textbook\.rk4 does .* Canonical .* external force\.$"):
        named("textbook.rk4", dragged)


def test_a_contender_that_says_the_wrong_kind_of_setting_is_seen():
    mislabelled = replace(reference("RK4"), name="mislabelled")
    object.__setattr__(mislabelled, "fixed_step", False)
    with pytest.raises((AssertionError, pytest.fail.Exception)):
        test_a_contender_is_set_by_a_step_or_by_samples_and_refuses_other_settings(mislabelled)


@every_reference
def test_support_is_decided_by_the_system_not_by_the_name_and_never_raised(contender):
    def height(q, v):
        return 0.5 * v @ v - 0.1 * q[2, 2]

    general = galvi.Problem(galvi.Lagrangian(height, galvi.SO3()), np.eye(3), [1.0, 0.2, 0.3])
    assert contender.supports(general) is False
    turning = {"quaternions", "matrices", "rigid", "body", "MuJoCo"}
    for problem in (SPRING, ORBIT, galvi.problems.solar_system(), SWING, *ON_GROUPS):
        answer = contender.supports(problem)
        assert contender.supports(replace(problem, name="something else")) is answer
        if problem in ON_GROUPS:
            assert not answer or any(word in contender.name for word in turning)


@pytest.mark.parametrize(
    "contender", [c for c in PRESENT if not c.supports(UNKNOWN)], ids=lambda c: c.name
)
def test_a_problem_without_a_solution_here_is_refused(contender):
    with pytest.raises(ValueError, match=f"^{re.escape(contender.name)} does not solve"):
        contender.run(UNKNOWN, 1.0, setting(contender, 1.0, 1))


def test_a_gradient_that_replaces_the_known_force_is_not_taken_for_it():
    for potential, q0, v0 in (
        (galvi.LinearSpring(1.0), [1.0], [0.0]),
        (galvi.CentralForce(1.0), [1.0, 0.0], [0.0, 1.0]),
        (galvi.CosinePotential(1.0), [1.0], [0.0]),
    ):
        system = galvi.Canonical(1.0, potential, gradient=lambda q: q**3, check=False)
        problem = galvi.Problem(system, q0, v0)
        recognised = [c.name for c in REFERENCES if c.exact and c.supports(problem)]
        assert recognised == ["heyoka, Lagrangians, quadruple precision"]  # writes out q**3
        assert [str(x) for x in LagrangeEquations.of(problem).pull] == [
            f"-q{k}**3" for k in range(len(q0))
        ]


def test_a_gradient_that_belongs_to_the_known_potential_keeps_its_references():
    for potential, q0, v0, gradient in (
        (galvi.LinearSpring(1.3), [1.0], [0.0], lambda q: 1.3 * q),
        (galvi.CentralForce(1.0), [1.0, 0.0], [0.0, 1.0], lambda q: q / np.hypot(*q) ** 3),
        (galvi.CosinePotential(1.0), [1.0], [0.0], np.sin),
    ):
        without = galvi.Problem(galvi.Canonical(2.0, potential), q0, v0)
        with_gradient = galvi.Problem(galvi.Canonical(2.0, potential, gradient=gradient), q0, v0)
        assert [c.name for c in REFERENCES if c.supports(with_gradient)] == [
            c.name for c in REFERENCES if c.supports(without)
        ]
    weight = HANGING.system.potential
    same = replace(HANGING.system, gradient=lambda R: weight.gradient(R))
    scaled = replace(HANGING.system, gradient=lambda R: 1.001 * weight.gradient(R), check=False)
    takers = [c for c in REFERENCES if c.supports(replace(HANGING, system=same))]
    assert {"MuJoCo RK4", "RK4 on quaternions, compiled"} <= {c.name for c in takers}
    general = [c for c in REFERENCES if c.supports(replace(HANGING, system=scaled))]
    assert {c.name for c in general} == {
        "explicit Euler, matrices",
        "SciPy RK45 (ode45), matrices",
        "SciPy DOP853, quaternions",
    }


def test_a_refusal_says_which_field_of_the_system_it_is_for():
    spring = galvi.Canonical(1.0, galvi.LinearSpring(1.0))
    cubic = {"gradient": lambda q: q**3, "check": False}
    drag = {"force": lambda q, v: -v}
    closed = reference("oscillator, closed form")
    for fields, reason in (
        (drag, r"The reason is its external force\.$"),
        (cubic, r"The reason is its gradient, which is not that of its potential\.$"),
        ({**drag, **cubic}, r"The reason is its external force and its gradient, which"),
    ):
        problem = galvi.Problem(replace(spring, **fields), [1.0], [0.0])
        with pytest.raises(ValueError, match=reason):
            closed.run(problem, 1.0, {})
    with pytest.raises(ValueError, match=r"The reason is its potential, of which no formula is"):
        closed.run(UNKNOWN, 1.0, {})
    with pytest.raises(ValueError, match=r"Ask supports\(problem\) first\.$"):
        closed.run(CHAIN, 1.0, {})


def test_engines_are_imported_only_when_they_are_used():
    engines = {"rebound", "jplephem", "de421", "heyoka", "mujoco", "pinocchio"}
    engines |= {"pandas", "scipy.integrate", "scipy.optimize", "scipy.spatial", "sympy"}  # 1 s
    program = f"import sys, references; print({engines} & set(sys.modules))"
    completed = subprocess.run(
        [sys.executable, "-c", program], capture_output=True, text=True, check=True
    )
    assert completed.stdout.strip() == "set()"


def test_a_missing_engine_is_a_sentence_and_not_a_crash(monkeypatch):
    monkeypatch.setitem(sys.modules, "rebound", None)
    contender = reference("REBOUND IAS15")
    assert "rebound" in contender.missing and contender.missing.endswith(".")
    with pytest.raises(
        EngineMissing, match=r"REBOUND IAS15 cannot run: .*Install rebound"
    ) as error:
        contender.run(ORBIT, 1.0, {})
    assert error.value.name == "rebound"


def test_every_reference_whose_engine_may_be_missing_names_it():
    optional = [
        reference for reference in REFERENCES if isinstance(type(reference).missing, property)
    ]
    assert {reference.engine for reference in optional} == {
        "rebound",
        "heyoka",
        "mujoco-core",
        "jplephem",
        "pin",
    }
    assert not any(reference.missing for reference in REFERENCES if reference not in optional)


ORDERS = {"DOP853": 8, "RK45": 5, "Radau": 5, r"RK4\b": 4, "Stormer-Verlet": 2, "WHFast": 2}


def test_the_order_is_that_of_the_method_by_which_it_is_called():
    orders = {reference.name: getattr(reference, "order", None) for reference in REFERENCES}
    for pattern, order in ORDERS.items():
        matching = {name: orders[name] for name in orders if re.search(pattern, name)}
        assert matching and set(matching.values()) == {order}, matching
