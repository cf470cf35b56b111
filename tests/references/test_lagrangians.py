"""Lagrangians on R^d: galvi, DOP853, heyoka, closed forms and stored truths agree."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
import sympy
from numba import njit

import galvi
from references.closed_forms.kepler import KEPLER
from references.forces.on_symbols import formulas_of, written
from references.heyoka.lagrangian import HEYOKA_LAGRANGIAN, HEYOKA_LAGRANGIAN_QUADRUPLE
from references.scipy.ivp import DOP853, TIGHT
from references.scipy.lagrangian_ivp import LAGRANGIAN_DOP853, accelerations
from references.stored.lagrangian import STORED_LAGRANGIAN
from references.stored.planets import FOLDER
from references.textbook.lagrange_equations import LagrangeEquations

needs_heyoka = pytest.mark.skipif(
    bool(HEYOKA_LAGRANGIAN.missing), reason=HEYOKA_LAGRANGIAN.missing or "present"
)
x, y, u, w, s, k = sympy.symbols("x y u w s k", real=True)
EIGHT = galvi.Galerkin(galvi.Polynomials(8), galvi.gauss(8))


def from_sympy(L, start, speeds, t0=0.0, **more):
    count = len(start)
    system = galvi.Lagrangian.from_sympy(L, [x, y][:count], [u, w][:count], **more)
    return galvi.Problem(system, start, speeds, t0=t0)


PROBLEMS = {
    "elastic pendulum": galvi.problems.elastic_pendulum(),
    "elastic pendulum, uneven": galvi.problems.elastic_pendulum(0.7, 31.0, 1.1, 5.0, 0.9, -0.4),
    "polar Kepler": galvi.problems.kepler_polar(),
    "coupled and driven": from_sympy(
        (u**2 + w**2) / 3 + u * w * sympy.cos(x - y) / 4 - sympy.cos(s) * x**2 / 3 - k * y**4,
        [0.3, 0.4], [0.1, 0.2], 0.7, t=s, parameters={k: 0.1},
    ),
    "not quadratic in the velocity": from_sympy(
        -sympy.sqrt(1 - u**2) - sympy.exp(x / 3) / 2 + u * sympy.sin(x), [0.2], [0.4]
    ),
}  # fmt: skip
POTENTIALS = {
    "henon-heiles": galvi.problems.henon_heiles(),
    "chain of springs": galvi.problems.fermi_pasta_ulam_tsingou(4, beta=0.3),
    "orbit": galvi.problems.kepler(0.3),
    "pendulum": galvi.problems.planar_pendulum(),
    "two masses": galvi.Problem(
        galvi.Canonical([2.0, 0.3], galvi.LinearSpring(1.5)), [1.0, 2.0], [0.5, 0.0]
    ),
    "coupled masses": galvi.Problem(
        galvi.Canonical([[2.0, 0.3], [0.3, 1.0]], galvi.CosinePotential(1.5)), [1.0, 2.0], [0.5, 0]
    ),
}
DURATION = 2.0


def apart(run, truth) -> float:
    assert run.success, run.status
    return float(max(np.abs(run.q[-1] - truth.q[-1]).max(), np.abs(run.p[-1] - truth.p[-1]).max()))


def tight(problem):
    peer = LAGRANGIAN_DOP853 if LAGRANGIAN_DOP853.supports(problem) else DOP853
    return peer.run(problem, DURATION, {"samples": 1, **TIGHT})


@pytest.mark.parametrize("name", PROBLEMS)
def test_galvi_and_dop853_agree(name):
    problem = PROBLEMS[name]
    run = galvi.integrate(problem, EIGHT, DURATION / 80, 80, save_every=80)
    assert apart(run, tight(problem)) < 2e-13  # 3e-14


@needs_heyoka
@pytest.mark.parametrize("name", [*PROBLEMS, *POTENTIALS])
def test_heyoka_and_dop853_agree(name):
    problem = (PROBLEMS | POTENTIALS)[name]
    setting = {"samples": 1, "compact_mode": True}
    assert apart(HEYOKA_LAGRANGIAN.run(problem, DURATION, setting), tight(problem)) < 5e-13  # 5e-14
    assert HEYOKA_LAGRANGIAN_QUADRUPLE.exact and not HEYOKA_LAGRANGIAN.exact


def test_the_equations_of_a_potential_are_its_force_over_the_mass():
    for problem in POTENTIALS.values():
        equations = LagrangeEquations.of(problem)
        q = np.linspace(0.3, 0.9, problem.q0.size)
        ours = problem.system.acceleration(q, 0.0) if hasattr(problem.system, "acceleration") else (
            DOP853.run(problem.with_initial_state(q, 0.0 * q), 1e-4, {"samples": 1, **TIGHT})
        )  # fmt: skip
        found = accelerations(equations)(q, 0.0 * q, 0.0)
        expected = ours if isinstance(ours, np.ndarray) else (ours.q[-1] - q) * 2e8
        np.testing.assert_allclose(found, expected, rtol=1e-6)
        moving = dict(zip(equations.v, (q + 1.0).tolist(), strict=True))
        momenta = [float(p.subs(moving)) for p in equations.momenta]
        np.testing.assert_allclose(momenta, problem.system.momentum(q + 1.0), rtol=1e-15)


def test_a_wrong_sign_in_lagrange_s_equations_is_caught():
    problem = PROBLEMS["elastic pendulum"]
    equations = LagrangeEquations.of(problem)
    flipped = {v: -v for v in equations.v[:1]}  # the Coriolis term of the angle changes its sign
    wrong = replace(equations, pull=tuple(f.xreplace(flipped) for f in equations.pull))
    q, v = np.array([1.1, 0.4]), np.array([0.3, 0.7])
    right = accelerations(equations)(q, v, 0.0)
    assert abs(accelerations(wrong)(q, v, 0.0) - right).max() > 0.5
    m, k, l, g = (problem.parameters[n] for n in ("mass", "stiffness", "length", "gravity"))
    by_hand = [
        q[0] * v[1] ** 2 - k / m * (q[0] - l) + g * np.cos(q[1]),
        (-2.0 * v[0] * v[1] - g * np.sin(q[1])) / q[0],
    ]
    np.testing.assert_allclose(right, by_hand, rtol=1e-14)


def test_polar_kepler_is_the_orbit_in_other_coordinates():
    e, duration = 0.3, 20.0
    run = LAGRANGIAN_DOP853.run(galvi.problems.kepler_polar(e), duration, {"samples": 4, **TIGHT})
    truth = KEPLER.run(galvi.problems.kepler(e), duration, {"samples": 4})
    r, angle = run.q.T
    plane = np.stack([r * np.cos(angle), r * np.sin(angle)], axis=1)
    assert np.abs(plane - truth.q).max() < 1e-12  # 1e-13
    assert angle[-1] > 6.0 * np.pi  # it counts the turns


@pytest.mark.slow_cases("fermi_pasta_ulam_tsingou")
@pytest.mark.parametrize("case", STORED_LAGRANGIAN.cases)
def test_others_come_to_the_stored_truth(case):
    problem, _ = STORED_LAGRANGIAN.cases[case]
    truth = STORED_LAGRANGIAN.run(problem, 5.0, {"samples": 10})
    peer = LAGRANGIAN_DOP853 if LAGRANGIAN_DOP853.supports(problem) else DOP853
    assert apart(peer.run(problem, 5.0, {"samples": 1, **TIGHT}), truth) < 2e-13  # 2e-14
    ours = galvi.integrate(problem, EIGHT, 0.025, 200)
    assert np.abs(ours.q[::20] - truth.q).max() < 1e-13  # 3e-15
    assert np.ptp(galvi.energy(truth)) < 5e-14  # 1e-14: the states are rounded


def test_the_stored_truth_is_kept_for_its_problem_and_no_other():
    sprung, chain = galvi.problems.elastic_pendulum, galvi.problems.fermi_pasta_ulam_tsingou
    others = (
        sprung(gravity=np.nextafter(9.81, 10.0)),
        sprung(mass=2.0, stiffness=80.0),  # the same motion, with other momenta
        sprung(angle=np.nextafter(1.5, 2.0)),
        chain(14),
        chain(beta=1e-15),
        galvi.problems.henon_heiles(0.11),
        galvi.problems.kepler_polar(),
    )
    assert not any(STORED_LAGRANGIAN.supports(other) for other in others)
    assert all(
        STORED_LAGRANGIAN.supports(problem) for problem, _ in STORED_LAGRANGIAN.cases.values()
    )


@pytest.mark.skipif(
    bool(HEYOKA_LAGRANGIAN_QUADRUPLE.missing),
    reason=HEYOKA_LAGRANGIAN_QUADRUPLE.missing or "present",
)
@pytest.mark.parametrize("case", STORED_LAGRANGIAN.cases)
def test_the_stored_truth_can_be_made_again(case):
    kept = (FOLDER / f"{case}.csv").read_text("ascii").splitlines()
    made = STORED_LAGRANGIAN.table(case).splitlines()
    rows = [i for i, line in enumerate(kept) if not line.startswith("# source")]
    assert [made[i] for i in rows] == [kept[i] for i in rows]


@njit
def branching(q):
    return q if q[0] > 0.0 else 2.0 * q


def test_what_has_no_formula_is_not_taken():
    potential = galvi.LinearSpring(1.0)
    functions = (lambda q: q, branching)
    systems = [
        galvi.Canonical(1.0, lambda q: 0.5 * float(q @ q), f, check=False) for f in functions
    ]
    systems.append(galvi.Canonical(1.0, potential, force=lambda q, v: -v))
    systems.append(galvi.Canonical(1.0, lambda q, t: float(q @ q), explicit_time=True))
    for system in systems:
        assert LagrangeEquations.of(galvi.Problem(system, [1.0, 2.0], [0.0, 0.0])) is None
    kink = from_sympy(u**2 / 2 - sympy.Abs(x) ** 3, [0.2], [0.4])
    assert LAGRANGIAN_DOP853.supports(kink) and not HEYOKA_LAGRANGIAN.supports(kink)
    own = PROBLEMS["polar Kepler"].system
    slopes = replace(own, slopes=lambda q, v: np.concatenate((v, np.zeros(2))), check=False)
    assert LagrangeEquations.of(galvi.Problem(slopes, [1.0, 0.0], [0.0, 1.0])) is None


def test_numbers_of_a_formula_are_not_rounded():
    mean, power = formulas_of(lambda q: [0.1 * q[0] + q[0] / 3.0, np.sqrt(q[0]) ** 3], written([x]))
    assert mean == x * (sympy.Rational(0.1) + sympy.Rational(1, 3))
    assert power == x ** sympy.Rational(3, 2)
    assert LagrangeEquations.of(POTENTIALS["henon-heiles"]).pull == (
        -2 * sympy.Symbol("q0", real=True) * sympy.Symbol("q1", real=True)
        - sympy.Symbol("q0", real=True),
        -(sympy.Symbol("q0", real=True) ** 2)
        + sympy.Symbol("q1", real=True) ** 2
        - sympy.Symbol("q1", real=True),
    )
    assert LagrangeEquations.of(PROBLEMS["coupled and driven"]).timed
    assert not LagrangeEquations.of(PROBLEMS["polar Kepler"]).timed
