"""Simulations with REBOUNDx's forces, read by name and compared by accelerations and by runs."""

import numpy as np
import pytest

import galvi

rebound = pytest.importorskip("rebound")
reboundx = pytest.importorskip("reboundx", reason="REBOUNDx is an extra")
METHOD = galvi.Galerkin(galvi.Polynomials(8), galvi.gauss(8))
SPEED_OF_LIGHT = 100.0
PARAMETERS = {
    "gr": {},
    "gr_full": {},
    "gr_potential": {},
    "gravitational_harmonics": {"J2": 1e-2, "J4": -1e-3, "R_eq": 0.2},
    "central_force": {"Acentral": 1e-3, "gammacentral": -2.5},
    "radiation_forces": {},
    "tides_constant_time_lag": {"tctl_k2": 0.3, "tctl_tau": 1e-2, "OmegaMag": 0.7},
}


def simulation(name, mass=1e-6):
    """A star with two planets and one of REBOUNDx's forces."""
    sim = rebound.Simulation()
    sim.add(m=1.0, r=0.2)
    sim.add(m=mass, a=1.0, e=0.2, inc=0.3, r=0.01)
    sim.add(m=mass, a=2.3, e=0.1, inc=0.1, f=2.0)
    sim.move_to_com()
    rebx = reboundx.Extras(sim)
    force = rebx.load_force(name)
    rebx.add_force(force)
    if (name.startswith("gr") and "harmonics" not in name) or name == "radiation_forces":
        force.params["c"] = SPEED_OF_LIGHT
    for key, value in PARAMETERS[name].items():
        sim.particles[0].params[key] = value
    if name == "radiation_forces":
        sim.particles[2].params["beta"] = 0.05
    if name == "tides_constant_time_lag":
        sim.particles[1].params["tctl_k2"] = 0.2
        sim.particles[1].params["tctl_tau"] = 0.1
    return sim, rebx


@pytest.mark.parametrize("name", PARAMETERS)
def test_a_force_is_read_and_runs_as_in_rebound(name):
    sim, rebx = simulation(name)
    problem = galvi.from_rebound(sim, extras=rebx)
    assert problem.system.forces
    run = galvi.integrate(problem, METHOD, 0.05, 100)
    bare = galvi.integrate(
        galvi.Problem(galvi.NBody(problem.system.masses), problem.q0, problem.v0), METHOD, 0.05, 100
    )
    sim.integrator = "ias15"
    sim.integrate(5.0)
    by_rebound = np.array([p.xyz for p in sim.particles])
    effect = np.max(np.abs(run.q[-1] - bare.q[-1]))
    relative_tolerance = (
        1e-2 if name in ("gr", "gr_full") else 1e-6
    )  # terms of c^-4 and of the planets' masses differ
    assert effect > 1e-7
    assert np.max(np.abs(run.q[-1] - by_rebound)) < max(relative_tolerance * effect, 1e-11)


def test_what_is_not_known_is_refused_by_name():
    sim, rebx = simulation("gr_potential")
    rebx.add_force(rebx.load_force("modify_orbits_forces"))
    with pytest.raises(ValueError, match="received modify_orbits_forces"):
        galvi.from_rebound(sim, extras=rebx)
    with pytest.raises(ValueError, match="additional forces"):
        galvi.from_rebound(sim)
    with pytest.raises(TypeError, match="extras must be a reboundx"):
        galvi.from_rebound(sim, extras=3)
    with pytest.raises(ValueError, match="another one's"):
        galvi.from_rebound(simulation("gr")[0], extras=rebx)


def test_a_wrong_sign_is_seen(monkeypatch):
    from galvi.interop import rebound_forces

    sim, rebx = simulation("gravitational_harmonics")
    read = rebound_forces.READERS["gravitational_harmonics"]

    def wrong(*arguments):
        return [galvi.Oblateness(0, -force.J2, force.radius) for force in read(*arguments)]

    monkeypatch.setitem(rebound_forces.READERS, "gravitational_harmonics", wrong)
    with pytest.raises(ValueError, match="misreads REBOUNDx's gravitational_harmonics"):
        galvi.from_rebound(sim, extras=rebx)
