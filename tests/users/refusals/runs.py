"""Runs, ensembles and what is asked of them: what is refused, and in which words."""

import sys
from dataclasses import replace

import numba
import numpy as np
from scipy.spatial.transform import Rotation

import galvi
from tests.properties.ensemble_cases import CASES, starts

EIGHT = galvi.Galerkin(galvi.Polynomials(8), galvi.gauss(8))
FOUR = galvi.Galerkin(galvi.Polynomials(4), galvi.gauss(4))
KEPLER = galvi.problems.kepler(0.3)
SPRING = galvi.LinearSpring()
WRONG = ValueError, TypeError


def run(**changes):
    given = {"problem": KEPLER, "method": EIGHT, "step": 0.1, "steps": 3} | changes
    return lambda: galvi.integrate(**given)


def long(**settings):
    return lambda: galvi.integrate(KEPLER, EIGHT, 1e-10, **settings)


def several(**settings):
    return lambda: galvi.integrate_many([KEPLER], EIGHT, 1e-10, **settings)


def members(problem=KEPLER, **changes):
    given = {"q0": problem.q0, "v0": problem.v0, "method": FOUR, "step": 0.1, "steps": 2} | changes
    return lambda: galvi.integrate_ensemble(problem, **given)


def kept(keep):
    """An ensemble whose last member has another shape."""
    problem, step = CASES["henon_heiles"]
    q, v = starts(problem, 3)
    q[2] = 0.0
    return members(problem, q0=q, v0=v, step=step, steps=6, keep=keep)


def recommended(**changes):
    given = {"problem": KEPLER, "error": 1e-6, "duration": 10.0} | changes
    return lambda: galvi.recommend(**given)


def elements(gm, eccentricity):
    one = np.ones(1)
    return lambda: galvi.OrbitalElements(one, eccentricity * one, *(0.0 * one,) * 4).states(gm)


def counted(runs):
    """Numbers beyond the counters."""
    return (
        (ValueError, f"save_every must be .* from 1 to {2**62}; received",
         runs(steps=10, save_every=10**20)),
        (ValueError, f"must be a whole number from 1 to {2**62}",
         runs(steps=10**25, save_every=10**25)),
        (ValueError, r"from 1 to .*; received 1e\+300", runs(steps=1e300)),
        (ValueError, "from 1 to .*; received inf", runs(steps=np.inf)),
        (ValueError, "from 1 to .*; received a number of 16610 bits", runs(steps=10**5000)),
        (ValueError, "of at least 1; received -1", runs(steps=-(10**25))),
        (ValueError, "duration over step must be .* from 1 to", runs(duration=1e300)),
        (ValueError, "duration over step must be .* from 1 to", runs(duration=1e25)),
    )  # fmt: skip


SINGLE = (
    (ValueError, "step must not be zero", run(step=0.0)),
    (ValueError, "step must be a finite real number; received nan", run(step=float("nan"))),
    (ValueError, "step must be a finite real number; received inf", run(step=float("inf"))),
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
    (ValueError, "solver must be one of auto, fixed_point, newton; received 'magic'",
     run(solver="magic")),
    (ValueError, "tolerance must be positive", run(tolerance=0.0)),
    (ValueError, "save_every must be a whole number of at least 1", run(save_every=0)),
    (TypeError, r"problem must be a galvi\.Problem; received Galerkin", run(problem=EIGHT)),
    (TypeError, r"method must be a galvi\.Galerkin; received 'gauss'", run(method="gauss")),
    (ValueError, "1000000000000 steps would keep",
     lambda: galvi.resume(galvi.integrate(KEPLER, FOUR, 0.02, 3), 10**12)),
    *counted(long),
    (TypeError, "system must be a system such as", lambda: galvi.Problem(5, [1.0], [0.0])),
    (TypeError, "system must be a system such as",
     lambda: galvi.Problem(galvi.Canonical, [1.0], [0.0])),
    (TypeError, "parameters must be a dict",
     lambda: galvi.Problem(KEPLER.system, KEPLER.q0, KEPLER.v0, parameters=3)),
    (ValueError, "q0 must be an array of real numbers",
     lambda: galvi.Problem(KEPLER.system, np.array([1 + 2j, 0]), [0.0, 1.0])),
    (ValueError, "q0 must be an array of real numbers",
     lambda: galvi.Problem(KEPLER.system, ["1", "0"], [0.0, 1.0])),
    (ValueError, "step must be a finite real", lambda: galvi.integrate(KEPLER, EIGHT, True, 3)),
    (ValueError, "step must be a finite real", lambda: galvi.integrate(KEPLER, EIGHT, "1", 3)),
    (ValueError, "solver must be", lambda: galvi.integrate(KEPLER, EIGHT, 0.1, 3, solver=["a"])),
    (ValueError, "steps would keep", lambda: galvi.integrate(KEPLER, EIGHT, 0.1, 10**13)),
    (ValueError, "only a run of galvi", lambda: galvi.resume(5, 3)),
    (ValueError, "only a run of galvi", lambda: galvi.save(5, "x")),
    (TypeError, r"run must be a galvi\.Trajectory", lambda: galvi.energy(5)),
    (ValueError, "factors must be groups", lambda: galvi.Product(Rotation.identity())),
    (ValueError, "received bodies 0 and 1 at the same point",
     lambda: galvi.Problem(galvi.NBody([1, 1]), [[0, 0], [1e-200, 0]], np.zeros((2, 2)))),
    (ValueError, "step must change the time",
     lambda: galvi.integrate(galvi.Problem(KEPLER.system, KEPLER.q0, KEPLER.v0, t0=1e17), EIGHT,
      0.1, 3)),
    (ValueError, r"explicit_time means functions of \(q, t\)",
     lambda: galvi.Canonical(1.0, galvi.LinearSpring(), explicit_time=True)),
    (ValueError, "potential must return a number; received an array of shape",
     lambda: galvi.integrate(galvi.Problem(galvi.Canonical(1.0, lambda q: q), [1.0], [0.0]), EIGHT,
      0.1, 3)),
    (ValueError, r"hessian must return an array of shape \(1, 1\)",
     lambda: galvi.integrate(galvi.Problem(galvi.Canonical(1.0, galvi.LinearSpring(), lambda q: q,
      numba.njit(lambda q: q)), [1.0], [0.0]), EIGHT, 0.1, 3)),
    (TypeError, "links must be galvi.Link values; received Rotation",
     lambda: galvi.Multibody(links=Rotation.identity(), gravity=np.zeros(3))),
    (ValueError, "exact_weights of a rule must be finite numbers in one row",
     lambda: galvi.Rule("mine", 1, (0.5,), [10**400])),
    (TypeError, "curves must be True or False; received array",
     lambda: galvi.integrate(KEPLER, EIGHT, 0.1, 3, curves=np.eye(3))),
    (TypeError, "curves must be True or False; received 'yes'",
     lambda: galvi.resume(galvi.integrate(galvi.problems.kepler(), EIGHT, 0.1, 3), steps=5,
      curves="yes")),
    (ValueError, "must be a whole number of at least 1; received",
     lambda: galvi.ComponentPolynomials(np.zeros(3, dtype=np.float16))),
    (ValueError, "must end at a finite time; received 8 steps",
     lambda: galvi.integrate(KEPLER, EIGHT, -1e308, 8)),
    (ValueError, "must end at a finite time",
     lambda: galvi.integrate_ensemble(KEPLER, KEPLER.q0, KEPLER.v0, EIGHT, [0.1, -1e308], 8)),
    (TypeError, "even must be True or False; received nan",
     lambda: galvi.KeplerFrame(even=float("nan"))),
    (ValueError, "mass must have entries",
     lambda: galvi.Canonical(np.zeros((0, 0)), galvi.LinearSpring())),
    (ValueError, "the stage equations are singular at step 2147483648.0|the step has no derivative",
     lambda: galvi.step_derivative(galvi.problems.harmonic_oscillator().with_initial_state([1e-9],
      [1.0]), galvi.Galerkin(galvi.Polynomials(1), galvi.gauss(2)), 2**31)),
    (ValueError, "exact_nodes of a rule must be finite numbers",
     lambda: galvi.Rule("mine", 1, [np.datetime64("2000-01-01"), 1.0], [0.5, 0.5])),
    (ValueError, "step must change the time",
     lambda: galvi.integrate(replace(KEPLER, t0=sys.float_info.max), EIGHT, 0.01, 5)),
)  # fmt: skip
MANY = (
    (TypeError, "For one problem, call", lambda: galvi.integrate_many(KEPLER, EIGHT, 0.1, 3)),
    (TypeError, "problems must be several", lambda: galvi.integrate_many(5, EIGHT, 0.1, 3)),
    (TypeError, r"problem must be a galvi\.Problem; received 5",
     lambda: galvi.integrate_many([KEPLER, 5], EIGHT, 0.1, 3)),
    (ValueError, "threads must be a whole number of at least 1; received 0",
     lambda: galvi.integrate_many([KEPLER], EIGHT, 0.1, 3, threads=0)),
    (ValueError, "must not be zero", lambda: galvi.integrate_many([KEPLER], EIGHT, 0.0, 3)),
    (ValueError, "1000 runs of 100000000 steps would keep",
     lambda: galvi.integrate_many([KEPLER] * 1000, EIGHT, 0.1, 10**8)),
    (ValueError, "v0 must have shape", lambda: KEPLER.with_initial_state([1.0], [0.0, 1.0])),
    *counted(several),
)  # fmt: skip
ENSEMBLES = (
    (WRONG, "q0 must have shape", members(q0=np.zeros((3, 5)))),
    (WRONG, "must have the same number of members",
     members(q0=np.ones((3, 2)), v0=np.ones((4, 2)))),
    (WRONG, "finite", members(q0=np.full((3, 2), np.nan))),
    (WRONG, "step must not be zero", members(step=[0.1, 0.0])),
    (WRONG, "steps must be", members(steps=0)),
    (WRONG, "parameters must be named", members(parameters={"m": [1.0]})),
    (WRONG, "one value for each", members(parameters={"mu": 1.0})),
    (WRONG, "mu must be positive", members(parameters={"mu": [-1.0]})),
    (WRONG, "whole numbers of steps", members(keep=galvi.StatesAt([0.15]))),
    (WRONG, "keep must be", members(keep=galvi.FinalStates)),
    (WRONG, "executor must have", members(executor=3)),
    (WRONG, "parameters must be a dict", members(parameters=3)),
    (WRONG, "parameters must be a dict", members(parameters=np.ones(3))),
    (WRONG, "must be an array of real numbers", members(parameters={"mu": "abc"})),
    (WRONG, "must be an array of real numbers", members(parameters={"mu": ["a"] * 5})),
    (WRONG, "must be an array of real numbers", members(parameters={"mu": [1.0 + 2.0j]})),
    (WRONG, "must be an array of real numbers", members(parameters={"mu": [[1.0], [1.0, 2.0]]})),
    (WRONG, "folder must be the path", members(folder=3)),
    (WRONG, "where a file is", members(folder=__file__)),
    (WRONG, "progress must be True or False", members(progress="x")),
    (WRONG, "whole numbers of steps", members(keep=galvi.StatesAt([1e300]))),
    (WRONG, "shape \\(1, ...\\)", members(keep=galvi.Extrema(lambda t, q, p: 1.0))),
    (WRONG, "shape \\(1, ...\\)", members(keep=galvi.Extrema(lambda t, q, p: np.ones(7)))),
    (WRONG, "a number for each member",
     members(keep=galvi.Histogram(lambda t, q, p: q, [0.0, 1.0]))),
    (WRONG, "Return one array", members(keep=numba.njit(lambda t, q, p: (1.0, 2.0)))),
    (TypeError, "must", lambda: galvi.Extrema(quantity=3)),
    (TypeError, "must", lambda: galvi.Histogram(3, [0.0, 1.0])),
    (ValueError, "must", lambda: galvi.StatesAt([[0.1], [0.2]])),
    (TypeError, "given as keep must return numbers; it returned", kept(lambda run: run)),
    (TypeError, "given as keep must return numbers; it returned",
     kept(lambda run: [[1.0], [1.0, 2.0]])),
    (ValueError, r"received shapes \(7,\) and, of member 2, \(3,\)\.",
     kept(lambda run: run.q[: 7 if run.q[0].any() else 3, 0])),
    (ValueError, r"'masses' must have shape \(20, 3\)",
     members(CASES["three_bodies"][0], parameters={"masses": np.ones((20, 2))})),
    (ValueError, r"'k' must have shape \(4,\)",
     members(CASES["sympy"][0], parameters={"k": np.ones((4, 2))})),
)  # fmt: skip
ASKED = (
    (ValueError, "error must be positive; received 0.0. Give it in the problem's unit",
     recommended(error=0.0)),
    (ValueError, "error must be a finite real number; received nan",
     recommended(error=float("nan"))),
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
    (ValueError, "degrees must be a tuple or list of whole numbers, as",
     recommended(degrees=np.array([6, 8]))),
    (ValueError, "each of degrees must be a whole number from 1 to 60; received 61",
     recommended(degrees=(4, 61))),
    (ValueError, "budget must be positive", recommended(budget=0)),
    (ValueError, "measured must be positive", recommended(measured=-2.0)),
    (TypeError, r"problem must be a galvi\.Problem; received 'kepler'",
     recommended(problem="kepler")),
    (ValueError, "needs bodies in the plane or in space", lambda: galvi.momentum_map(
        galvi.integrate(galvi.problems.fermi_pasta_ulam_tsingou(5), EIGHT, 0.1, 2))),
    (ValueError, "massless bodies is always 0",
     lambda: galvi.symplecticity_defect(CASES["three_bodies"][0], EIGHT, 0.1)),
    (ValueError, "an eccentricity must be", elements(1.0, 1.5)),
    (ValueError, "gm must be positive", elements(0.0, 0.5)),
)  # fmt: skip
TABLE = {"runs": SINGLE, "many runs": MANY, "ensembles": ENSEMBLES, "asked of runs": ASKED}
