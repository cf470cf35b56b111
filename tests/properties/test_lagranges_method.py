"""Lagrangians from SymPy's LagrangesMethod."""

from __future__ import annotations

import numpy as np
import pytest

import galvi

sympy = pytest.importorskip("sympy")
me = pytest.importorskip("sympy.physics.mechanics")

m, g, l, c = sympy.symbols("m g l c")
PARAMETERS = {m: 2.0, g: 9.81, l: 0.5, c: 0.3}


def swinging_mass(loads: bool):
    """A pendulum on a sliding mass with a spring; with ``loads`` both motions are damped."""
    x, a = me.dynamicsymbols("x a")
    frame, origin = me.ReferenceFrame("N"), me.Point("O")
    origin.set_vel(frame, 0)
    rod = frame.orientnew("A", "Axis", [a, frame.z])
    slider, bob = origin.locatenew("S", x * frame.x), me.Point("B")
    bob.set_pos(slider, l * rod.x)
    for point in (slider, bob):
        point.set_vel(frame, point.pos_from(origin).dt(frame))
    speed = sum(point.vel(frame).dot(point.vel(frame)) for point in (slider, bob))
    L = m * speed / 2 + m * g * l * sympy.cos(a) - x**2 / 2
    forces = [(slider, -c * x.diff() * frame.x), (rod, -c * a.diff() * frame.z)]
    return me.LagrangesMethod(L, [x, a], forcelist=forces if loads else None, frame=frame)


@pytest.mark.slow_cases("True")
@pytest.mark.parametrize("loads", [False, True])
def test_it_moves_as_its_own_equations_say(loads):
    method = swinging_mass(loads)
    system = galvi.Lagrangian.from_sympy(method, parameters=PARAMETERS)
    problem = galvi.Problem(system, [0.1, 1.0], [0.0, 0.5])
    run = galvi.integrate(problem, galvi.Galerkin(galvi.Polynomials(8), galvi.gauss(8)), 0.02, 50)
    assert run.success
    method.form_lagranges_equations()
    right_sides = method.rhs().subs(PARAMETERS)
    symbols = [*method.q, *[x.diff() for x in method.q]]
    right_side = sympy.lambdify(symbols, list(right_sides), "numpy")
    from scipy.integrate import solve_ivp

    start = [*problem.q0, *problem.v0]
    by_scipy = solve_ivp(
        lambda t, y: right_side(*y), (0.0, 1.0), start, "DOP853", rtol=1e-12, atol=1e-12
    )
    assert np.allclose(run.q[-1], by_scipy.y[:2, -1], rtol=0, atol=1e-9)
    energy = galvi.energy(run)
    assert (abs(energy[-1] / energy[0] - 1.0) > 1e-3) == loads
