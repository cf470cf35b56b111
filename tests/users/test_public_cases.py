"""Public cases: from papers, test sets, and forums and trackers of other projects.

Each row is the smallest input that shows the case, with its public source (issues as
owner/repository#number). The expected value, end of a run or refusal comes from outside galvi.
"""

from __future__ import annotations

import re
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from scipy.special import ellipk

import galvi
from galvi import End

ROWS: list[Any] = []


def row(source: str, value: Any = None, within: float = 0.0, **expected: Any) -> Any:
    """A decorator that adds a function to ROWS. The function returns `value`, to the absolute
    tolerance `within`, or a run with the outcome `end`, or raises the error `refused`; the status
    of the run or the message of the error matches the pattern `words`."""

    def enter(function: Callable[[], Any]) -> None:
        ROWS.append(
            pytest.param(function, value, within, expected, id=f"{function.__name__}, {source}")
        )

    return enter


def gauss(points: int, **options: Any) -> galvi.Galerkin:
    return galvi.Galerkin(galvi.Polynomials(points), galvi.gauss(points), **options)


CLOCK = gauss(8, clock=galvi.DynamicalTime())
FRAME = gauss(8, chart=galvi.KeplerFrame())


def asserted_complete(run: Any) -> Any:
    assert run.outcome.end is End.COMPLETED, run.status
    return run


def completed(*arguments: Any, **options: Any) -> Any:
    return asserted_complete(galvi.integrate(*arguments, **options))


def final_state(run: Any) -> Any:
    """Configuration and velocity at the end of a run."""
    return np.append(run.q[-1], run.v[-1])


def read(model: str, **options: Any) -> Any:
    pytest.importorskip("mujoco")
    return galvi.from_mujoco(f"<mujoco>{model}</mujoco>", **options)


# ---------------------------------------------------------------- test sets


@row(
    "Test Set for IVP Solvers, Pleiades: x of the seven stars at t = 3, then y",
    (0.3706139143970502, 3.237284092057233, -3.222559032418324, 0.6597091455775310,
     0.3425581707156584, 1.562172101400631, -0.7003092922212495,
     -3.943437585517392, -3.271380973972550, 5.225081843456543, -2.590612434977470,
     1.198213693392275, -0.2429682344935824, 1.091449240428980),
    1e-12,
)  # fmt: skip
def pleiades() -> Any:
    q = [[3, 3], [3, -3], [-1, 2], [-3, 0], [2, 0], [-2, -4], [2, 4]]
    v = [[0, 0], [0, 0], [0, 0], [0, -1.25], [0, 1], [1.75, 0], [-1.5, 0]]
    stars = galvi.Problem(galvi.NBody(np.arange(1.0, 8.0)), q, v)
    return completed(stars, CLOCK, 0.2, duration=3.0).q[-1].T.ravel()


@row("Hull et al. 1972, DETEST D5", (-1.295266250987574, 0.4003938963792321), 1e-13)
def two_bodies_of_eccentricity_nine_tenths() -> Any:
    clock = gauss(8, clock=galvi.Sundman())
    return completed(galvi.problems.kepler(0.9), clock, 0.3, duration=20.0).q[-1]


@row("Hull et al. 1972, DETEST E2", (2.008149762174948, -0.04250887527320057), 1e-13)
def van_der_pols_oscillator() -> Any:
    system = galvi.Canonical(1.0, galvi.LinearSpring(), force=lambda q, v: (1.0 - q * q) * v)
    return final_state(completed(galvi.Problem(system, [2.0], [0.0]), gauss(8), 0.1, 200))


@row("Hull et al. 1972, DETEST E3", (-0.1004178858647128, 0.2411400132095954), 1e-12)
def duffings_driven_oscillator() -> Any:
    def potential(q: Any, t: Any) -> Any:
        return q[0] ** 2 / 2.0 - q[0] ** 4 / 24.0 - 2.0 * np.sin(2.78535 * t) * q[0]

    system = galvi.Canonical(1.0, potential, explicit_time=True)
    return final_state(completed(galvi.Problem(system, [0.0], [0.0]), gauss(8), 0.2, 100))


@row("Hull et al. 1972, DETEST E5", (14.11797390542629, 2.400000000000002), 1e-12)
def a_pursuit() -> Any:
    free = galvi.UniformField([0.0])
    system = galvi.Canonical(
        1.0, free, force=lambda q, v, t: np.sqrt(1.0 + v * v) / (25.0 - t), timed_force=True
    )
    return final_state(completed(galvi.Problem(system, [0.0], [0.0]), gauss(8), 0.5, 40))


@row(
    "Hull et al. 1972, DETEST B5: sn, cn and dn at 20 for m = 0.51",
    (-0.9396570798729192, -0.3421177754000779, 0.7414126596199957),
    1e-13,
)
def eulers_equations() -> Any:
    """For moments 2, 3, 1.5 in units of the velocity in which the equations have no factors."""
    units = np.sqrt([4.59, 1.02, 8.0])
    body = galvi.Problem(galvi.RigidBody((2.0, 3.0, 1.5)), np.eye(3), units * [0.0, 1.0, 1.0])
    return completed(body, gauss(8), 0.1, 200).v[-1] / units


@row("SciMLBenchmarks, single pendulum: 2 arcsin(k sn) by mpmath", -3.108969708223564, 1e-11)
def a_pendulum_that_nearly_turns_over() -> Any:
    system = galvi.Canonical(1.0, lambda q: 1.0 - np.cos(q[0]))
    start = galvi.Problem(system, [0.99 * np.pi], [0.0])
    return completed(start, gauss(8), 0.5, 200).q[-1, 0]


# ---------------------------------------------------------------- point masses


def turning(mu: float, q: Any, v: Any, duration: float) -> Any:
    """Final position of a massless body in the frame that rotates with two circling bodies."""
    inertial = [v[0] - q[1], v[1] + q[0], v[2]]
    positions = [[-mu, 0.0, 0.0], [1.0 - mu, 0.0, 0.0], q]
    velocities = [[0.0, -mu, 0.0], [0.0, 1.0 - mu, 0.0], inertial]
    start = galvi.Problem(galvi.NBody([1.0 - mu, mu, 0.0]), positions, velocities)
    x, y, z = completed(start, CLOCK, 0.1, duration=duration).q[-1, 2]
    c, s = np.cos(duration), np.sin(duration)
    return c * x + s * y, c * y - s * x, z


@row("Hairer, Norsett and Wanner I, II.0: Arenstorf's orbit", (0.994, 0.0, 0.0), 1e-11)
def arenstorfs_orbit() -> Any:
    v = [0.0, -2.00158510637908252240537862224, 0.0]
    return turning(0.012277471, [0.994, 0.0, 0.0], v, 17.0652165601579625588917206249)


@row("Hairer, Norsett and Wanner I, II.0: the one with two loops", (0.994, 0.0, 0.0), 1e-11)
def arenstorfs_other_orbit() -> Any:
    v = [0.0, -2.0317326295573368357302057924, 0.0]
    return turning(0.012277471, [0.994, 0.0, 0.0], v, 11.124340337266085134999734047)


@row("Howell 1984, table 1, mu = 0.04", 0.0, 1e-5)
def a_halo_orbit_crosses_its_plane_after_half_a_period() -> Any:
    return turning(0.04, [0.723268, 0.0, 0.04], [0.0, 0.198019, 0.0], 1.300177)[1]


EIGHT = [[0.97000436, -0.24308753], [-0.97000436, 0.24308753], [0.0, 0.0]]


@row("Chenciner and Montgomery 2000: the figure eight, in eight digits", EIGHT, 1e-7)
def three_bodies_on_one_curve() -> Any:
    v = [[0.466203685, 0.43236573], [0.466203685, 0.43236573], [-0.93240737, -0.86473146]]
    bodies = galvi.Problem(galvi.NBody([1.0, 1.0, 1.0]), EIGHT, v)
    return completed(bodies, gauss(8), 0.0632591398, 100).q[-1]


@row("Szebehely and Peters 1967; SciML's Burrau: time, distance", (15.830, 4e-4), 1e-4)
def burraus_bodies_are_closest() -> Any:
    positions = [[1.0, 3.0], [-2.0, -1.0], [1.0, -1.0]]
    bodies = galvi.Problem(galvi.NBody([3.0, 4.0, 5.0]), positions, np.zeros((3, 2)))
    run = completed(bodies, CLOCK, 0.3, duration=17.0)
    approaches = galvi.find_events(run, galvi.events.closest_approach(1, 2))
    nearest = np.argmin(approaches.value)
    return approaches.t[nearest], approaches.value[nearest]


MOON = (0.5208229189877062, 0.8396958299645672, 0.0)


@row(
    "dtamayo/reboundx#136: by IAS15, and no momentum is lost",
    (*MOON, 0.0, 0.0, 0.0),
    1e-13,
)
def a_massless_moon_in_a_clock() -> Any:
    """For five revolutions with e = 0.9 about a planet of a star."""
    rebound = pytest.importorskip("rebound")
    sim = rebound.Simulation()
    sim.add(m=1.0)
    sim.add(m=1e-3, a=1.0)
    sim.add(m=0.0, a=0.01, e=0.9, f=np.pi, primary=sim.particles[1])
    sim.move_to_com()
    run = completed(galvi.from_rebound(sim), CLOCK, 0.3, duration=1.0)
    return np.append(run.q[-1, 2], np.ptp(galvi.linear_momentum(run), axis=0))


def two_planets(step: float) -> Any:
    """A run in which two planets of mass 1e-5 pass each other at t = 3."""
    q = [[7.2283e-06, -1.89857e-05], [0.6974469761, 0.5594905041], [-1.42027244, 1.3390793551]]
    v = [[7.0939e-06, 2.6277e-06], [-0.7732756731, 0.4940799962], [0.06388694, -0.7568476381]]
    start = galvi.Problem(galvi.NBody([1.0, 1e-5, 1e-5]), q, v)
    return galvi.integrate(start, CLOCK, step, duration=6.0)


@row("hannorein/rebound#855, #793", end=End.DOUBTFUL, words="bodies 1 and 2 passed at a distance")
def a_clock_steps_over_a_passage() -> Any:
    return two_planets(0.3)


@row("hannorein/rebound#855, #793: IAS15", (-0.9599434139409329, 0.23201791499947325), 1e-7)
def a_clock_in_steps_that_resolve_the_passage() -> Any:
    return asserted_complete(two_planets(0.05)).q[-1, 1]


def meteoroid(method: Any, step: float) -> Any:
    """A run and its approaches: a meteoroid 25,200 km from the Earth on day 24.5, at 10.2 km/s."""
    position = [1.054739257525, -0.018119104481, 0.104431693901]
    velocity = [-0.00248197063638, 0.01785420576982, -0.00402509261234]
    q = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], position]
    v = [[0.0, 0.0, 0.0], [0.0, 0.01720212477893, 0.0], velocity]
    system = galvi.NBody([1.0, 3.003e-6, 0.0], 0.01720209895**2)
    run = galvi.integrate(galvi.Problem(system, q, v), method, step, duration=60.0)
    passages = galvi.find_events(run, galvi.events.closest_approach(1, 2))
    assert np.isfinite(galvi.states_at(run, np.linspace(0.0, 60.0, 121))[0]).all()
    return run, passages


@row("wmpg/WesternMeteorPyLib#92", end=End.DOUBTFUL, words="bodies 1 and 2 passed at a distance")
def a_frame_steps_over_a_passage() -> Any:
    return meteoroid(FRAME, 10.0)[0]


@row("wmpg/WesternMeteorPyLib#99: IAS15, in au", 1.6845844e-4, 1e-10)
def a_clock_resolves_the_passage() -> Any:
    run, passages = meteoroid(CLOCK, 0.1)
    asserted_complete(run)
    return passages.value.item()


@row("Noether; Kepler's problem of Hairer, Lubich and Wanner I.2", 0.0, 1e-13)
def angular_momentum_in_long_steps() -> Any:
    run = completed(galvi.problems.kepler(0.6), gauss(22), 1.1, 200)
    return np.ptp(run.q[:, 0] * run.p[:, 1] - run.q[:, 1] * run.p[:, 0])


def craft(step: float) -> Any:
    """A run of ten revolutions of a satellite, in kilometres and seconds."""
    GM = 398600.4418
    system = galvi.Canonical(1.0, galvi.CentralForce(GM))
    speed = np.sqrt(1.2 * GM / 7000.0)  # e = 0.2, a = 8750 km
    start = galvi.Problem(system, [7000.0, 0.0], [0.0, speed])
    sundman = gauss(8, clock=galvi.Sundman())
    return galvi.integrate(start, sundman, step, duration=20.0 * np.pi * 8750.0**1.5 / GM**0.5)


@row(
    "poliastro, perturbations in kilometres and seconds",
    end=End.STEP_FAILED,
    words="steps are in units of the clock",
)
def a_step_in_other_units_than_the_clocks() -> Any:
    return craft(0.4)


@row("Kepler's third law: ten revolutions", (7000.0, 0.0), 1e-8)
def a_step_in_units_of_the_clock() -> Any:
    return asserted_complete(craft(0.4 / np.sqrt(398600.4418))).q[-1]


@row(
    "Curtis, Orbital Mechanics, 12.2; poliastro's tests of perturbations: deg/h",
    (-0.172, 0.282),
    1e-3,
)
def oblateness_turns_the_node_and_the_pericentre() -> Any:
    earth = galvi.Oblateness(0, 0.00108263, 6378.0)
    system = galvi.NBody([398600.0, 0.0], forces=(earth,))
    q = [[0.0, 0.0, 0.0], [-2384.46, 5729.01, 3050.46]]
    v = [[0.0, 0.0, 0.0], [-7.36138, -2.98997, 1.64354]]
    run = completed(galvi.Problem(system, q, v), gauss(8), 240.0, 720)
    elements = galvi.orbital_elements(run, 0)
    angles = [np.unwrap(np.ravel(x)) for x in (elements.node, elements.pericentre)]
    return [np.degrees(x[-1] - x[0]) / 48.0 for x in angles]


@row("galpy and gala, isochrone potential: a period of the radius", (1.0, 0.0), 1e-12)
def an_isochrone_orbit() -> Any:
    """In the frame that has turned by the angle of the closed form."""
    system = galvi.Canonical(1.0, lambda q: -1.0 / (1.0 + np.sqrt(1.0 + q @ q)))
    energy, rotation_angle = 0.125 - 1.0 / (1.0 + 2.0**0.5), np.pi * (1.0 + 0.5 / np.sqrt(4.25))
    step = 2.0 * np.pi * (-2.0 * energy) ** -1.5 / 100.0
    x, y = completed(galvi.Problem(system, [1.0, 0.0], [0.0, 0.5]), gauss(8), step, 100).q[-1]
    return np.cos(rotation_angle) * x + np.sin(rotation_angle) * y, np.cos(
        rotation_angle
    ) * y - np.sin(rotation_angle) * x


@row("Boris 1970, a uniform magnetic field: half a circle", (0.0, -1.0), 1e-13)
def a_charged_particle() -> Any:
    system = galvi.Lagrangian(lambda q, v: 0.5 * v @ v + q[0] * v[1] - q[1] * v[0], galvi.Rn(2))
    start = galvi.Problem(system, [0.0, 0.0], [1.0, 0.0])
    return completed(start, gauss(8), np.pi / 20.0, 10).q[-1]


@row("Hairer, Lubich and Wanner VI.3: the trapezoidal rule", 1.0950278923, 1e-10)
def the_trapezoidal_rule_is_not_verlets_where_mass_depends_on_place() -> Any:
    def lagrangian(q: Any, v: Any) -> Any:
        return 0.5 * (1.0 + q[0] ** 2) * v[0] ** 2 - 0.5 * q[0] ** 2

    start = galvi.Problem(galvi.Lagrangian(lagrangian, galvi.Rn(1)), [1.0], [1.0])
    return completed(start, galvi.Galerkin(galvi.Polynomials(1), galvi.lobatto(2)), 0.1, 1).q[-1, 0]


@row("Kraus 2017: point vortices", refused=ValueError, words=r"along v\[0\] and v\[1\], or does")
def a_degenerate_lagrangian() -> Any:
    system = galvi.Lagrangian(lambda q, v: q[1] * v[0] - 0.5 * (q @ q), galvi.Rn(2))
    return galvi.Problem(system, [1.0, 0.0], [0.0, 0.0])


@row("hannorein/rebound#445", refused=ValueError, words="collision")
def a_simulation_with_collisions() -> Any:
    rebound = pytest.importorskip("rebound")
    sim = rebound.Simulation()
    sim.add(m=1.0)
    sim.add(m=1e-3, a=1.0)
    sim.collision = "direct"
    return galvi.from_rebound(sim)


@row(
    "stefano-meschiari/Systemic2#7", refused=ValueError, words="on a parabola they do not say where"
)
def elements_of_a_parabola() -> Any:
    ones, zero = np.ones(1), np.zeros(1)
    return galvi.OrbitalElements(ones, ones, zero, zero, zero, zero).states(1.0)


# ---------------------------------------------------------------- bodies


BODY = '<inertial pos="0 0 {}" mass="1" diaginertia=".1 .1 .1"/>'


def hinge(joint: str, elements: str, height: float = -0.4, **options: Any) -> Any:
    """A pendulum of mass 1 without gravity."""
    body = f'<body><joint name="h" axis="0 1 0" {joint}/>{BODY.format(height)}</body>'
    world = f'<option gravity="0 0 0"/><worldbody>{body}</worldbody>'
    return read(world + elements, **options)


@row("newton-physics/newton#3698, a damping ratio of 1", 0.3 * (1.0 - 11.0 * np.exp(-10.0)), 1e-12)
def a_critically_damped_servo() -> Any:
    servo = '<actuator><position joint="h" kp="10" dampratio="1"/></actuator>'
    problem = hinge("", servo, 0.0, ctrl=[0.3])
    return completed(problem, gauss(8), 0.02, 50).q[-1, 0]


@row("newton-physics/newton#3749: -kv u v / I", -60.0, 1e-12)
def a_damper_that_is_controlled() -> Any:
    damper = '<actuator><damper joint="h" kv="4" ctrlrange="0 1"/></actuator>'
    return hinge("", damper, 0.0, ctrl=[0.5]).system.acceleration([0.0], [3.0])


@row(
    "google-deepmind/dm_control#320: an oscillator",
    0.1 * np.cos(0.2 * np.sqrt(10 / 0.26)),
    1e-13,
)
def members_with_a_limit_of_force() -> Any:
    servo = '<actuator><position joint="h" kp="10" forcerange="-400 400"/></actuator>'
    start = np.full((2, 1), 0.1)
    ends = galvi.integrate_ensemble(hinge("", servo), start, 0.0 * start, gauss(8), 0.02, 10)
    assert ends.success.all()
    return ends[0][:, 0]


@row("mujocolab/mjlab#38: MuJoCo 4.0.1", -19.810951067320374, 1e-11)
def other_masses_in_a_medium() -> Any:
    body = '<inertial pos="0 0 -.4" mass="1" diaginertia=".02 .03 .01"/>'
    world = f'<worldbody><body><joint axis="0 1 0"/>{body}</body></worldbody>'
    problem = read(f'<option density="100" viscosity=".1"/>{world}')
    return problem.system.with_numbers(masses=[4.0]).acceleration([1.0], [3.0])


@row(
    "google-deepmind/mujoco_menagerie#232, a light wrist",
    end=End.DOUBTFUL,
    words="forces have damped a velocity in 1/1,000 of a step",
)
def a_servo_too_stiff_for_the_step() -> Any:
    servo = '<actuator><position joint="h" kp="50000" kv="5000"/></actuator>'
    problem = hinge("", servo, 0.0, ctrl=[0.1]).with_initial_state([0.0], [2.0])
    return galvi.integrate(problem, gauss(8), 0.02, 10)


@row("a damper takes energy", end=End.RUINED)
def radaus_rule_with_a_strong_damper() -> Any:
    link = galvi.Link(galvi.Joint("hinge", axis=(0, 0, 1), damping=10.0), 1.0, (0, 0, 0), 1.0)
    start = galvi.Problem(galvi.Multibody(link, gravity=(0, 0, 0)), [0.0], [1.0])
    return galvi.integrate(start, galvi.Galerkin(galvi.Polynomials(2), galvi.radau(2)), 1.0, 40)


@row("RBDL and MuJoCo, three hinges for a shoulder", end=End.DOUBTFUL, words="Use a ball joint")
def hinges_through_gimbal_lock() -> Any:
    joints = "".join(f'<joint axis="{a}" damping="1e-12"/>' for a in ("1 0 0", "0 1 0", "0 0 1"))
    body = '<inertial pos="0 0 .1" mass=".5" diaginertia=".004 .005 .002"/>'
    problem = read(f"<worldbody><body>{joints}{body}</body></worldbody>")
    start = problem.with_initial_state([0.0, 0.0, 0.0], [1e-3, 3.0, 0.0])
    return galvi.integrate(start, gauss(8), 0.01, 100)


ARM = """<worldbody><site name="top" pos="0 0 .3"/><body><joint axis="0 1 0"/>
<inertial pos="0 0 .5" mass="1" diaginertia=".1 .1 .1"/><site name="arm" pos="0 0 .4"/></body>
</worldbody><tendon><spatial stiffness="40.875" springlength="0"><site site="top"/>
<site site="arm"/></spatial></tendon>"""


@row("google-deepmind/mujoco#618, a lamp: k a b = m g l, so it turns uniformly", 6.0, 1e-12)
def an_arm_balanced_by_a_spring_of_no_length() -> Any:
    start = read(ARM).with_initial_state([1.0], [2.5])
    return completed(start, gauss(8), 0.02, 100).q[-1, 0]


@row("google-deepmind/mujoco#618: conservation", 0.0, 1e-11)
def the_energy_of_a_tendon() -> Any:
    fixed = '<tendon><fixed stiffness="200"><joint joint="h" coef="1"/></fixed></tendon>'
    start = hinge("", fixed).with_initial_state([1.0], [0.0])
    return np.ptp(galvi.energy(completed(start, gauss(8), 0.01, 100)))


@row("google-deepmind/mujoco#1348: free fall", 9.81, 1e-12)
def a_cord_whose_ends_meet() -> Any:
    slide = '<joint type="slide" axis="0 0 -1"/>' + BODY.format(0) + '<site name="m"/>'
    world = f'<worldbody><site name="top"/><body>{slide}</body></worldbody>'
    ends = '<site site="top"/><site site="m"/>'
    cord = f'<tendon><spatial stiffness="100" springlength="0 1">{ends}</spatial></tendon>'
    return read(world + cord).system.acceleration([0.0], [0.0])


@row("google-deepmind/mujoco#520, a bungee: after one closed period", (0.0, 0.0), 1e-11)
def a_cord_with_an_event_where_it_tightens() -> Any:
    g, w = 9.81, 10.0

    def potential(q: Any) -> Any:
        return -g * q[0] + 0.5 * w * w * np.maximum(q[0] - 1.0, 0.0) ** 2

    problem = galvi.Problem(galvi.Canonical(1.0, potential), [0.0], [0.0])
    taut = galvi.Event(lambda q, v, t: q[0] - 1.0, action=lambda q, v, t: (q, v))
    half = np.sqrt(2.0 / g) + (np.pi - np.arctan(w * np.sqrt(2.0 / g))) / w
    return final_state(completed(problem, gauss(8), half / 10.0, 20, events=taut))


@row("google-deepmind/mujoco#1668, Zeno's ball", end=End.STEP_FAILED, words="an event chatters")
def a_ball_that_comes_to_rest() -> Any:
    ball = galvi.Problem(galvi.Canonical(1.0, galvi.UniformField([-9.81])), [1.0], [0.0])
    floor = galvi.Event(lambda q, v, t: q[0], -1, action=lambda q, v, t: (q, -0.5 * v))
    return galvi.integrate(ball, gauss(2), 0.1, 100, events=floor)


@row("mockingbirdnest/Principia#2251: a period of Dzhanibekov's nut", (0.1, 1.0, 0.2), 1e-13)
def a_nut_that_turns_over() -> Any:
    moments, w = np.array([1.0, 2.0, 3.0]), np.array([0.1, 1.0, 0.2])
    energy, momentum = moments @ w**2, moments**2 @ w**2
    rate_squared = (momentum - energy) / 6.0
    m = (3.0 * energy - momentum) / (momentum - energy)
    body = galvi.Problem(galvi.RigidBody(moments), np.eye(3), w)
    return completed(body, gauss(8), 4.0 * ellipk(m) / np.sqrt(rate_squared) / 200.0, 200).v[-1]


@row("mockingbirdnest/Principia#2251", refused=ValueError, words="no body has the inertia")
def an_impossible_inertia() -> Any:
    return galvi.RigidBody((3.0, 5.0, 9.0))


@row("stack-of-tasks/pinocchio#2753, mimic", refused=ValueError, words="1 equality constraint")
def a_joint_that_mimics_another() -> Any:
    return hinge("", '<equality><joint joint1="h"/></equality>')


@row("google-deepmind/mujoco_warp#239", refused=ValueError, words="wrap")
def a_tendon_around_a_cylinder() -> Any:
    world = ARM.replace('<site site="top"/>', '<site site="top"/><geom geom="drum"/>')
    drum = '<geom name="drum" type="cylinder" size=".01 .1" contype="0" conaffinity="0"/>'
    return read(world.replace("<worldbody>", f"<worldbody>{drum}"))


@row("isaac-sim/IsaacLab#5276", refused=ValueError, words="gravity compensation")
def held_weight_through_a_limited_actuator() -> Any:
    joint = '<joint axis="0 1 0" actuatorgravcomp="true" actuatorfrcrange="-1 1"/>'
    return read(f'<worldbody><body gravcomp="1">{joint}{BODY.format(-0.4)}</body></worldbody>')


@pytest.mark.parametrize(("function", "value", "within", "expected"), ROWS)
def test_a_public_case_is_as_its_source_has_it(
    function: Callable[[], Any], value: Any, within: float, expected: dict[str, Any]
) -> None:
    if "refused" in expected:
        with pytest.raises(expected["refused"], match=expected["words"]):
            function()
    elif "end" in expected:
        run = function()
        assert run.outcome.end is expected["end"], run.status
        assert re.search(expected.get("words", ""), run.status), run.status
    else:
        np.testing.assert_allclose(function(), value, rtol=0.0, atol=within)
