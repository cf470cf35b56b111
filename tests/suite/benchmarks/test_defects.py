"""Symplecticity defects and conserved components, measured without galvi's derivatives."""

import numpy as np
import pytest

import galvi
from benchmarks.measures.defects import kept_components, largest_changes, map_symplecticity_defect
from benchmarks.work_precision.galvi_methods import gauss_collocation
from references import reference

BODY = galvi.problems.free_rigid_body()


def step_of(name, problem, step):
    contender = reference(name) if isinstance(name, str) else gauss_collocation(name)

    def advance(start):
        run = contender.run(start, step, {"step": step})
        return run.q[-1], run.p[-1]

    return map_symplecticity_defect(problem, advance)


@pytest.mark.parametrize(
    ("problem", "step"),
    [
        (galvi.problems.kepler(0.3), 0.2),
        (galvi.problems.outer_solar_system(), 100.0),
        (galvi.problems.double_pendulum(), 0.05),
        (BODY, 0.3),
    ],
    ids=["kepler", "planets", "double pendulum", "body"],
)
def test_galvi_is_symplectic_and_its_own_measure_agrees(problem, step):
    defect = step_of(3, problem, step)
    galvi_defect = galvi.symplecticity_defect(problem, gauss_collocation(3).method, step)
    assert defect < 1e-10 and galvi_defect < 1e-10


@pytest.mark.parametrize(
    ("name", "problem", "step", "symplectic"),
    [
        ("Stormer-Verlet", galvi.problems.kepler(0.3), 0.2, True),
        ("symplectic Euler", galvi.problems.kepler(0.3), 0.2, True),
        ("explicit Euler", galvi.problems.kepler(0.3), 0.2, False),
        ("REBOUND leapfrog", galvi.problems.outer_solar_system(), 100.0, True),
        ("RK4", galvi.problems.outer_solar_system(), 100.0, False),
        ("RK4 on quaternions, compiled", BODY, 0.3, False),
    ],
)
def test_which_textbook_steps_are_symplectic(name, problem, step, symplectic):
    assert (step_of(name, problem, step) < 1e-10) == symplectic


def test_massless_bodies_have_no_defect():
    three = galvi.Problem(
        galvi.NBody([1.0, 0.0]), [[0.0, 0.0], [1.0, 0.0]], [[0.0, 0.0], [0.0, 1.0]]
    )
    assert np.isnan(step_of("REBOUND leapfrog", three, 0.1))


def run_of(problem, steps=200, duration=10.0):
    return gauss_collocation(8).run(problem, duration, {"step": duration / steps})


def test_what_the_motion_does_not_keep_is_no_error():
    drag = galvi.Canonical(1.0, galvi.LinearSpring(1.0), force=lambda q, v: -0.1 * v)
    motions = {
        "kepler": galvi.problems.kepler(0.3),
        "one-sided": galvi.problems.henon_heiles(),
        "damped": galvi.Problem(drag, [1.0, 0.0], [0.0, 0.5]),
        "top": galvi.problems.heavy_top(),
    }
    changes = {}
    for name, problem in motions.items():
        run = run_of(problem)
        changes[name] = largest_changes(run, kept_components(run))
    assert max(changes["kepler"]) < 1e-12
    assert changes["one-sided"][0] < 1e-10 and np.isnan(changes["one-sided"][1])
    assert np.isnan(changes["damped"]).all()
    assert max(changes["top"]) < 1e-9  # the conserved momentum is that about the vertical


def test_a_method_that_loses_momentum_is_seen():
    problem = galvi.problems.kepler(0.3)
    components = kept_components(run_of(problem))
    run = reference("explicit Euler").run(problem, 10.0, {"step": 0.01})
    energy, momentum = largest_changes(run, components)
    assert energy > 1e-3 and momentum > 1e-3
