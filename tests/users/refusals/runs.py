"""Refusals of runs, ensembles, events and quantities of runs: errors and messages."""

from functools import cache

import numba
import numpy as np
from scipy.spatial.transform import Rotation

import galvi
from tests.properties.ensemble_cases import CASES, starts

EIGHT = galvi.Galerkin(galvi.Polynomials(8), galvi.gauss(8))
FOUR = galvi.Galerkin(galvi.Polynomials(4), galvi.gauss(4))
KEPLER = galvi.problems.kepler(0.3)
SPRING = galvi.LinearSpring()
EITHER_ERROR = ValueError, TypeError
STARS = galvi.Problem(galvi.NBody([1.0, 0.1]), np.eye(2), np.eye(2)[::-1])
IN_CLOCK = {
    "method": galvi.Galerkin(galvi.Polynomials(4), galvi.gauss(4), clock=galvi.DynamicalTime()),
    "steps": None,
    "duration": 1.0,
}


def run(**changes):
    arguments = {"problem": KEPLER, "method": EIGHT, "step": 0.1, "steps": 3} | changes
    return lambda: galvi.integrate(**arguments)


def members(problem=KEPLER, **changes):
    arguments = {
        "q0": problem.q0,
        "v0": problem.v0,
        "method": FOUR,
        "step": 0.1,
        "steps": 2,
    } | changes
    return lambda: galvi.integrate_ensemble(problem, **arguments)


def keeping(keep):
    """A call that runs an ensemble with `keep`, whose last member starts from zeros."""
    problem, step = CASES["henon_heiles"]
    q, v = starts(problem, 3)
    q[2] = 0.0
    return members(problem, q0=q, v0=v, step=step, steps=6, keep=keep)


def recommended(**changes):
    arguments = {"problem": KEPLER, "error": 1e-6, "duration": 10.0} | changes
    return lambda: galvi.recommend(**arguments)


def elements(gm, eccentricity):
    ones = np.ones(1)
    return lambda: galvi.OrbitalElements(ones, eccentricity * ones, *(0.0 * ones,) * 4).states(gm)


def planets():
    """The run of a step of the outer planets."""
    return galvi.integrate(galvi.problems.outer_solar_system(), FOUR, 10.0, 1)


SINGLE = (
    (ValueError, "step must not be zero", run(step=0.0)),
    (ValueError, "step must be a finite real number; received nan", run(step=float("nan"))),
    (ValueError, "steps must be a whole number of at least 1; received -3", run(steps=-3)),
    (ValueError, "steps must be a whole number of at least 1; received 2.5", run(steps=2.5)),
    (ValueError, "give either steps or duration; received neither", run(steps=None)),
    (ValueError, "give either steps or duration; received both", run(duration=1.0)),
    ((TypeError, ValueError), r"Call galvi\.integrate\(problem, method, step, steps\)",
     lambda: galvi.integrate(KEPLER, (0, 10), 0.1)),
    ((TypeError, ValueError), "given by steps or duration",
     lambda: galvi.integrate(KEPLER, EIGHT, (0, 10))),
    (ValueError, r"duration must be a whole number of steps; received",
     run(steps=None, duration=1.05)),
    (ValueError, "duration must be positive; received -1.0. For backw",
     run(steps=None, duration=-1.0)),
    (ValueError, r"received 'a{99} \.\.\. b{99}'", run(solver="a" * 5000 + "b" * 5000)),
    (ValueError, "solver must be one of auto, fixed_point, newton; received 'magic'",
     run(solver="magic")),
    (ValueError, "tolerance must be positive", run(tolerance=0.0)),
    (ValueError, "save_every must be a whole number of at least 1", run(save_every=0)),
    (TypeError, r"problem must be a galvi\.Problem; received Galerkin", run(problem=EIGHT)),
    (TypeError, r"method must be a galvi\.Galerkin; received 'gauss'", run(method="gauss")),
    (ValueError, "1000000000000 steps would keep",
     lambda: galvi.resume(galvi.integrate(KEPLER, FOUR, 0.02, 3), 10**12)),
    (ValueError, f"save_every must be .* from 1 to {2**62}; received",  # beyond the counters
     run(steps=10, save_every=10**20)),
    (ValueError, r"from 1 to .*; received 1e\+300", run(steps=1e300)),
    (ValueError, "from 1 to .*; received inf", run(steps=np.inf)),
    (ValueError, "from 1 to .*; received a number of 16610 bits", run(steps=10**5000)),
    (ValueError, "of at least 1; received -1", run(steps=-(10**25))),
    (ValueError, "duration over step must be .* from 1 to",
     run(step=1e-10, steps=None, duration=1e25)),
    (TypeError, "system must be a system such as", galvi.Problem, 5, [1.0], [0.0]),
    (TypeError, "parameters must be a dict",
     lambda: galvi.Problem(KEPLER.system, KEPLER.q0, KEPLER.v0, parameters=3)),
    (ValueError, "q0 must be an array of real numbers",
     galvi.Problem, KEPLER.system, np.array([1 + 2j, 0]), [0.0, 1.0]),
    (ValueError, "step must be a finite real", galvi.integrate, KEPLER, EIGHT, True, 3),
    (ValueError, "steps would keep", galvi.integrate, KEPLER, EIGHT, 0.1, 10**13),
    (ValueError, "only a run of galvi", galvi.resume, 5, 3),
    (ValueError, "only a run of galvi", galvi.save, 5, "x"),
    (TypeError, r"run must be a galvi\.Trajectory", galvi.energy, 5),
    (ValueError, "received bodies 0 and 1 at the same point",
     galvi.Problem, galvi.NBody([1, 1]), [[0, 0], [1e-200, 0]], np.zeros((2, 2))),
    (ValueError, "step must change the time",
     galvi.integrate, galvi.Problem(KEPLER.system, KEPLER.q0, KEPLER.v0, t0=1e17), EIGHT,
      0.1, 3),
    (ValueError, r"explicit_time means functions of \(q, t\)",
     lambda: galvi.Canonical(1.0, galvi.LinearSpring(), explicit_time=True)),
    (ValueError, "potential must return a number; received an array of shape",
     galvi.integrate, galvi.Problem(galvi.Canonical(1.0, lambda q: q), [1.0], [0.0]), EIGHT,
      0.1, 3),
    (ValueError, r"hessian must return an array of shape \(1, 1\)",
     galvi.integrate, galvi.Problem(galvi.Canonical(1.0, galvi.LinearSpring(), lambda q: q,
      numba.njit(lambda q: q)), [1.0], [0.0]), EIGHT, 0.1, 3),
    (TypeError, "links must be galvi.Link values; received Rotation",
     lambda: galvi.Multibody(links=Rotation.identity(), gravity=np.zeros(3))),
    (ValueError, "exact_weights of a rule must be finite numbers in one row",
     galvi.Rule, "mine", 1, (0.5,), [10**400]),
    (TypeError, "curves must be True or False; received array",
     lambda: galvi.integrate(KEPLER, EIGHT, 0.1, 3, curves=np.eye(3))),
    (TypeError, "curves must be True or False; received 'yes'",
     lambda: galvi.resume(galvi.integrate(galvi.problems.kepler(), EIGHT, 0.1, 3), steps=5,
      curves="yes")),
    (ValueError, "must end at a finite time; received 8 steps",
     galvi.integrate, KEPLER, EIGHT, -1e308, 8),
    (ValueError, "must end at a finite time",
     galvi.integrate_ensemble, KEPLER, KEPLER.q0, KEPLER.v0, EIGHT, [0.1, -1e308], 8),
    (TypeError, "even must be True or False; received nan",
     lambda: galvi.KeplerFrame(even=float("nan"))),
    (ValueError, "mass must have entries",
     galvi.Canonical, np.zeros((0, 0)), galvi.LinearSpring()),
    (ValueError, "the stage equations are singular at step 2147483648.0|the step has no derivative",
     galvi.step_derivative, galvi.problems.harmonic_oscillator().with_initial_state([1e-9],
      [1.0]), galvi.Galerkin(galvi.Polynomials(1), galvi.gauss(2)), 2**31),
    (ValueError, "exact_nodes of a rule must be finite numbers",
     galvi.Rule, "mine", 1, [np.datetime64("2000-01-01"), 1.0], [0.5, 0.5]),
)  # fmt: skip
MANY = (
    (TypeError, "For one problem, call", galvi.integrate_many, KEPLER, EIGHT, 0.1, 3),
    (TypeError, r"problem must be a galvi\.Problem; received 5",
     galvi.integrate_many, [KEPLER, 5], EIGHT, 0.1, 3),
    (ValueError, "threads must be a whole number of at least 1; received 0",
     lambda: galvi.integrate_many([KEPLER], EIGHT, 0.1, 3, threads=0)),
    (ValueError, "must not be zero", galvi.integrate_many, [KEPLER], EIGHT, 0.0, 3),
    (ValueError, "1000 runs of 100000000 steps would keep",
     galvi.integrate_many, [KEPLER] * 1000, EIGHT, 0.1, 10**8),
    (ValueError, "v0 must have shape", KEPLER.with_initial_state, [1.0], [0.0, 1.0]),
)  # fmt: skip
ENSEMBLES = (
    (EITHER_ERROR, "q0 must have shape", members(q0=np.zeros((3, 5)))),
    (EITHER_ERROR, "must have the same number of members",
     members(q0=np.ones((3, 2)), v0=np.ones((4, 2)))),
    (EITHER_ERROR, "finite", members(q0=np.full((3, 2), np.nan))),
    (EITHER_ERROR, "step must not be zero", members(step=[0.1, 0.0])),
    (EITHER_ERROR, "steps must be", members(steps=0)),
    (EITHER_ERROR, "parameters must be named", members(parameters={"m": [1.0]})),
    (EITHER_ERROR, "one value for each", members(parameters={"mu": 1.0})),
    (EITHER_ERROR, "mu must be positive", members(parameters={"mu": [-1.0]})),
    (EITHER_ERROR, "whole numbers of steps", members(keep=galvi.StatesAt([0.15]))),
    (EITHER_ERROR, "keep must be", members(keep=galvi.FinalStates)),
    (EITHER_ERROR, "executor must have", members(executor=3)),
    (EITHER_ERROR, "parameters must be a dict", members(parameters=3)),
    (EITHER_ERROR, "must be an array of real numbers", members(parameters={"mu": "abc"})),
    (EITHER_ERROR, "must be an array of real numbers",
     members(parameters={"mu": [[1.0], [1.0, 2.0]]})),
    (EITHER_ERROR, "folder must be the path", members(folder=3)),
    (EITHER_ERROR, "where a file is", members(folder=__file__)),
    (TypeError, "version must be a text, or None; received 3", members(version=3)),
    (EITHER_ERROR, "progress must be True or False", members(progress="x")),
    (EITHER_ERROR, "shape \\(1, ...\\)", members(keep=galvi.Extrema(lambda t, q, p: 1.0))),
    (EITHER_ERROR, "a number for each member",
     members(keep=galvi.Histogram(lambda t, q, p: q, [0.0, 1.0]))),
    (EITHER_ERROR, "Return one array", members(keep=numba.njit(lambda t, q, p: (1.0, 2.0)))),
    (TypeError, "quantity must be a function", lambda: galvi.Extrema(quantity=3)),
    (TypeError, "quantity must be a function", galvi.Histogram, 3, [0.0, 1.0]),
    (ValueError, r"times must have shape \(times,\)", galvi.StatesAt, [[0.1], [0.2]]),
    (TypeError, "given as keep must return numbers; it returned", keeping(lambda run: run)),
    (ValueError, r"received shapes \(7,\) and, of member 2, \(3,\)\.",
     keeping(lambda run: run.q[: 7 if run.q[0].any() else 3, 0])),
    (ValueError, r"'masses' must have shape \(20, 3\)",
     members(CASES["three_bodies"][0], parameters={"masses": np.ones((20, 2))})),
)  # fmt: skip
QUANTITIES = (
    (ValueError, "error must be positive; received 0.0. Give it in the problem's unit",
     recommended(error=0.0)),
    (ValueError, "duration must be positive; received -1.0", recommended(duration=-1.0)),
    (ValueError, "recommend scans clocks on vector spaces; this problem is on a group.",
     recommended(problem=galvi.problems.free_rigid_body(), clock=galvi.Clock(lambda q: 1.0))),
    (ValueError, "a clock must return a positive, finite number; received -1",
     recommended(clock=galvi.Clock(lambda q: -1.0))),
    (TypeError, "clock must be a clock such as galvi.DynamicalTime()", recommended(clock=1.5)),
    (ValueError, "by must be one of time, evaluations; received 'luck'", recommended(by="luck")),
    (ValueError, "degrees must be a tuple or list of whole numbers", recommended(degrees=())),
    (ValueError, "degrees must be a tuple or list of whole numbers, as",
     recommended(degrees={6, 8})),
    (ValueError, "each of degrees must be a whole number from 1 to 60; received 61",
     recommended(degrees=(4, 61))),
    (ValueError, "budget must be positive", recommended(budget=0)),
    (ValueError, "measured must be positive", recommended(measured=-2.0)),
    (TypeError, r"problem must be a galvi\.Problem; received 'kepler'",
     recommended(problem="kepler")),
    (ValueError, "needs bodies in the plane or in space", lambda: galvi.momentum_map(
        galvi.integrate(galvi.problems.fermi_pasta_ulam_tsingou(5), EIGHT, 0.1, 2))),
    (ValueError, "massless bodies is always 0",
     galvi.symplecticity_defect, CASES["three_bodies"][0], EIGHT, 0.1),
    (ValueError, "an eccentricity must be", elements(1.0, 1.5)),
    (ValueError, "gm must be positive", elements(0.0, 0.5)),
    *(
        (ValueError, rf"say where the body is; .* and e = 1{where}\. Leave",
         lambda a=a, e=e: galvi.OrbitalElements(np.array(a), np.array(e), *np.zeros(4)).states(1.0))
        for a, e, where in (
            (1.0, 1.0, ""), ([2.0, -1.0], [0.5, 1.0], r" at \[1\]"), (np.inf, 1.0, ""),
            ([[2.0, np.inf]], [[0.5, 1.0 + 1e-15]], r" at \[0, 1\]"),
        )
    ),
    *(
        (ValueError, "centre must be a whole number from 0 to 5; received",
         lambda wrong=wrong: galvi.orbital_elements(planets(), centre=wrong))
        for wrong in (6, -1, 0.5)
    ),
    (ValueError, r"need N bodies.*received a Canonical", lambda: galvi.orbital_elements(run()())),
    (ValueError, "must lie inside the run", lambda: run()()(0.31)),
    (ValueError, "inside the run", lambda: galvi.states_at(run()(), 0.31)),
    (ValueError, "same number of steps",
     members(q0=np.ones((2, 2)), step=[0.1, 0.2], steps=None, duration=2.0)),
    (ValueError, "folder", members(STARS, **IN_CLOCK, folder="x")),
    (ValueError, "StatesAt", members(STARS, **IN_CLOCK, keep=galvi.Extrema())),
    (TypeError, r"end must be a galvi.End; received 'done'. Use galvi.End",
     lambda: galvi.Outcome("done")),
)  # fmt: skip

# ---------------------------------------------------------------- events

BALL = galvi.Problem(galvi.Canonical(1.0, galvi.UniformField([-1.0])), [1.0], [0.0])


@cache
def pair(*names):
    """A run of two bodies with these names."""
    q, v = [[0.0, 0.0], [1.0, 0.0]], [[0.0, 0.0], [0.0, 1.0]]
    bodies = galvi.Problem(galvi.NBody([0.9, 0.1]), q, v, parameters={"bodies": names})
    return galvi.integrate(bodies, EIGHT, 0.2, 5)


@cache
def rods(*names):
    """A run of two rods at joints with these names."""
    upper, lower = (galvi.Joint("hinge", (0, 1, 0), name=name) for name in names)
    links = galvi.Link(upper, 1.0, (0, 0, -1), 0.1), galvi.Link(lower, 1.0, (0, 0, -2), 0.1, 0)
    return galvi.integrate(galvi.Problem(galvi.Multibody(links), [1.0, 0.5], [0, 0]), EIGHT, 0.1, 2)


@cache
def leg():
    """A run of a thigh on a ball joint and a shin on a hinge."""
    hip = galvi.Link(galvi.Joint("ball", name="hip"), 1.0, (0, 0, -0.5), 0.01)
    knee = galvi.Joint("hinge", axis=(0, 1, 0), name="knee")
    tree = galvi.Multibody([hip, galvi.Link(knee, 1.0, (0, 0, -0.5), 0.01, 0, place=(0, 0, -1))])
    start = tree.group.join(np.eye(3), np.zeros(1))
    return galvi.integrate(galvi.Problem(tree, start, [1.0, 0.0, 0.0, 2.0]), EIGHT, 0.02, 2)


def sought_in(event, run=pair, names=("star", "planet")):
    return lambda: galvi.find_events(run(*names), event)


def in_run(*event, **options):
    return lambda: galvi.integrate(BALL, EIGHT, 0.3, 20, events=galvi.Event(*event, **options))


def raising(q, v, t):
    raise ZeroDivisionError("of the user.")


def wall(action):
    return in_run(lambda q, v, t: q[0], -1, action=action, name="wall")


EVENTS = (
    (TypeError, "must be a function", lambda: galvi.Event(3)),
    (ValueError, "direction", lambda: galvi.Event(lambda q, v, t: 0.0, 2)),
    (TypeError, "galvi.Event values", sought_in([3])),
    (ValueError, "a body must be one of", sought_in(galvi.events.apsis("moon", 0))),
    (ValueError, "two bodies", sought_in(galvi.events.apsis(1, 1))),
    (ValueError, "coordinate of a vector", sought_in(galvi.events.angle(0, 1.0))),
    (ValueError, "finite number", sought_in(galvi.Event(lambda q, v, t: np.nan))),
    (ValueError, "runs of galvi.integrate",
     lambda: galvi.find_events(3, galvi.events.apsis(1, 0))),
    (ValueError, "distance", lambda: galvi.events.within(0, 1, -1.0)),
    (ValueError, "vector other than 0", lambda: galvi.events.plane_crossing((0.0, 0.0))),
    (ValueError, "either distance or hill_radii", lambda: galvi.events.within(0, 1)),
    (ValueError, "hill_radii", lambda: galvi.events.within("any", "any", hill_radii=-1.0)),
    (ValueError, "a body must be", sought_in(galvi.events.within("any", 9, 1.0))),
    (ValueError, "heaviest body has no Hill", sought_in(galvi.events.within(0, 1, hill_radii=1.0))),
    (ValueError, "no such pair", sought_in(galvi.events.within("any", 0, hill_radii=1.0))),
    (ValueError, "a body must have a name of its own; received 'star'",
     sought_in(galvi.events.apsis("star", 0), names=("star", "star"))),
    (ValueError, r"a joint must be one of \['shoulder', 'elbow'\], or",
     sought_in(galvi.events.angle("wrist", 0.2), rods, ("shoulder", "elbow"))),
    (ValueError, "must be a number below 2; received 'elbow'",
     sought_in(galvi.events.angle("elbow", 0.2), rods, ("", ""))),
    (ValueError, r"received 'bend', the name of numbers \[0, 1\]",
     sought_in(galvi.events.angle("bend", 0.2), rods, ("bend", "bend"))),
    (ValueError, "one angle or length; received 'hip', a ball joint",
     sought_in(galvi.events.angle("hip", 0.0), leg, ())),
    (ValueError, r"must be one of \['knee'\], or its number; received 'ankle'",
     sought_in(galvi.events.angle("ankle", 0.0), leg, ())),
    (ValueError, "received 1, an entry of the rotation matrix of a ball joint",
     sought_in(galvi.events.angle(1, 0.0), leg, ())),
    (ValueError, "the event odd must be a finite number",
     in_run(lambda q, v, t: float("nan"), name="odd")),
    (EITHER_ERROR, "the event odd must return a real number",
     in_run(lambda q, v, t: 1j, name="odd")),
    (EITHER_ERROR, "the event odd must return a number; received an array",
     in_run(lambda q, v, t: q, name="odd")),
    (ZeroDivisionError, "of the user", in_run(raising)),
    *(
        (ValueError, r"the action of the event wall must return \(q, v\); received",
         wall(lambda q, v, t, end=end: end))
        for end in (3, "qv", [1.0], [1.0, 2.0, 3.0])
    ),
    (ValueError, "v of the action of the event wall must have",
     wall(lambda q, v, t: (q, [1.0, 2.0]))),
    (ValueError, "finite numbers", wall(lambda q, v, t: (q, v * np.inf))),
    (ValueError, "must lead to a finite energy", wall(lambda q, v, t: (q, v * 1e200))),
    (TypeError, "action must be a function", lambda: galvi.Event(len, action=3)),
    (ValueError, "ends the run or acts on it", lambda: galvi.Event(len, 0, True, len)),
)  # fmt: skip
CLOCKED = galvi.Galerkin(galvi.Polynomials(4), galvi.gauss(4), clock=galvi.Sundman())
FRAMED = galvi.Galerkin(galvi.Polynomials(4), galvi.gauss(4), galvi.KeplerFrame())
BODY = galvi.problems.free_rigid_body()
HALF_TURN = np.diag([1.0, -1.0, -1.0])


def between(q0=KEPLER.q0, q1=KEPLER.q0, h=0.1, problem=KEPLER, method=EIGHT):
    """A call for a discrete Lagrangian."""
    return lambda: galvi.discrete_lagrangian(problem, method, q0, q1, h)


def acting(**changes):
    """A call for the action of a run."""
    return lambda: galvi.action(run(**changes)())


def past_half(q, v, t):
    return q[1] - 0.5


ACTIONS = (
    (ValueError, "the discrete Lagrangian needs .*; received a method in a clock. Leave it out",
     between(method=CLOCKED)),
    (ValueError, "needs steps of equal length in the inertial frame; .* a moving frame",
     between(method=FRAMED)),
    (ValueError, "h must not be zero", between(h=0)),
    (ValueError, "h must be a finite real number; received nan", between(h=float("nan"))),
    (ValueError, r"q1 must have shape \(2,\); received shape \(3,\)", between(q1=[1, 2, 3])),
    (ValueError, "q0 must hold finite numbers", between(q0=[1, float("nan")])),
    (ValueError, r"\(q1 - q0\) / h must be finite; .* Use a larger h",
     between(q1=[1e300, 0.0], h=1e-10)),
    (ValueError, "q1 must be a rotation", between(np.eye(3), np.ones((3, 3)), problem=BODY)),
    (ValueError, "q0 must be a rotation", between(-np.eye(3), np.eye(3), problem=BODY)),
    (ValueError, "bodies must start at different places",
     between(0.0 * STARS.q0, STARS.q0, problem=STARS)),
    (RuntimeError, "no curve from q0 to q1 in the time h = 3.14.* conjugate points.* smaller h",
     between([1.0], [0.5], np.pi, galvi.problems.harmonic_oscillator(),
             galvi.Galerkin(galvi.Polynomials(12), galvi.gauss(12)))),
    *((RuntimeError, "no curve from q0 to q1 .* conjugate points",  # every velocity arrives
       between([1.0], [sign], half_periods * np.pi, galvi.problems.harmonic_oscillator(),
               galvi.Galerkin(galvi.Polynomials(16), galvi.gauss(16))))
      for half_periods, sign in ((1, -1.0), (2, 1.0))),
    (RuntimeError, "no curve from q0 to q1", between(np.eye(3), HALF_TURN, problem=BODY)),  # Cayley
    (RuntimeError, "the action of the curve .* is inf",
     between([0.0], [1e200], 1.0, galvi.Problem(galvi.Canonical(1.0, lambda q: 0.0 * q[0]), [0.0],
                                                [0.0]))),
    (TypeError, r"problem must be .* Call galvi.discrete_legendre_transforms\(problem, method, q0",
     galvi.discrete_legendre_transforms, 3, EIGHT, KEPLER.q0, KEPLER.q0, 0.1),
    (TypeError, "run must be a galvi.Trajectory; received 3", galvi.action, 3),
    (ValueError, "the action of a run needs .* a clock", acting(method=CLOCKED)),
    (ValueError, "the action of a run needs .* a moving frame",
     acting(problem=galvi.problems.outer_solar_system(), method=FRAMED, step=10.0)),
    (ValueError, "of whole steps; received one that an event ended at t = 0.39.*, within a step",
     acting(steps=9, events=galvi.Event(past_half, terminal=True))),
    (ValueError, "an event ended at t = 0.50000001.*, within a step",
     acting(steps=9, events=galvi.Event(lambda q, v, t: t - 0.50000001, terminal=True))),
    *((ValueError, message, acting(
        steps=9, save_every=save_every,
        events=galvi.Event(past_half, action=lambda q, v, t: (q, -v)),
    )) for save_every, message in (
        (1, "that actions of events changed"), (2, "with actions of events"),
    )),
)  # fmt: skip
TABLE = {
    "runs": SINGLE,
    "actions": ACTIONS,
    "many runs": MANY,
    "ensembles": ENSEMBLES,
    "asked of runs": QUANTITIES,
    "events": EVENTS,
}
