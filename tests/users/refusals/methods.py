"""Refusals of rules, spaces, methods, frames, clocks and theory: errors and their messages."""

from dataclasses import replace
from functools import partial
from itertools import product

import numpy as np

import galvi
from galvi.rules import RULES as FAMILIES
from galvi.spaces.piecewise import PiecewisePolynomials
from tests.properties.own_spaces import Bernstein, Even, Sines, Unhashable, WithoutDegree
from tests.properties.theory_pairs import KEPLER, method

EITHER_ERROR = ValueError, TypeError
HENON = galvi.problems.henon_heiles()
PIECES = galvi.PiecewisePolynomials(2, 3)
ON_PIECES = r".*galvi.composite\(rule, 3\)"
theory = partial(partial, galvi.theory)
rule = partial(partial, galvi.Rule, "mine")


def pair(space, points=5):
    """A call that makes a method of the space and a rule, or Gauss's of that number of points."""
    quadrature = galvi.gauss(points) if isinstance(points, int) else points
    return lambda: galvi.Galerkin(space, quadrature)


def broken_space(**fields):
    """A call that makes a method of a user's space which breaks a promise."""
    return pair(replace(Bernstein(), **fields))


def by_component(*degrees, problem=HENON):
    """A call that runs a step with a degree for each component."""
    space = galvi.ComponentPolynomials(degrees)
    component_method = galvi.Galerkin(space, galvi.gauss(max(degrees)))
    return lambda: galvi.integrate(problem, component_method, 0.1, 1)


OUTER = galvi.problems.outer_solar_system()
DEGREE_THREE = galvi.Polynomials(3), galvi.gauss(3)
ALONE = galvi.Problem(galvi.NBody([1.0]), [[0.0, 0.0, 1.0]], [[0.0, 1.0, 0.0]])
RULES = (
    (ValueError, "sum to 1", rule(1, (0.2, 0.8), (0.5, 0.6))),
    (ValueError, "must be positive", rule(1, (0.2, 0.8), (1.0, 0.0))),
    (ValueError, "must increase", rule(1, (0.8, 0.2), (0.5, 0.5))),
    (ValueError, r"inside \[0, 1\]", rule(1, (0.2, 1.8), (0.5, 0.5))),
    (ValueError, "one weight for each node", rule(1, (0.2,), (0.5, 0.5))),
    (ValueError, "at least one", rule(1, (), ())),
    (ValueError, "finite", rule(1, (0.2, float("nan")), (0.5, 0.5))),
    (ValueError, "finite numbers in one row; received", rule(1, (0.2, "a"), (0.5, 0.5))),
    (ValueError, "finite numbers in one row; received", rule(1, 0.5, 1.0)),
    (ValueError, "misses one of degree 2 by .* Say degree = 1", rule(2, (0.2, 0.8), (0.5, 0.5))),
    (ValueError, "must be at most 3, which Gauss's rule has; received 4",
     rule(4, (0.2, 0.8), (0.5, 0.5))),
    (ValueError, "degree of a rule must be a whole number of at least 0",
     rule(-1, (0.2, 0.8), (0.5, 0.5))),
    *(
        (ValueError, r"points must be a whole number of at least .; received", partial(*call))
        for call in zip(FAMILIES, (True, 2.5, float("nan"), "3", 0), strict=True)
    ),
    *(
        (ValueError, "from 2 to 8, since .* 9 points is the first with a negative weight; received",
         partial(galvi.newton_cotes, points))
        for points in (9, 10)
    ),
    (TypeError, "left must be True or False; received 'yes'", lambda: galvi.radau(3, left="yes")),
    (TypeError, r"rule must be a rule such as galvi.gauss\(8\); received",
     galvi.composite, galvi.gauss, 3),
    (ValueError, "pieces must be a whole number from 1 to 64; received 65",
     lambda: galvi.PiecewiseHermite(65)),
    (ValueError, "pieces must be a whole number from 1 to 64; received nan",
     lambda: galvi.PiecewisePolynomials(2, float("nan"))),
    (ValueError, "pieces must be a whole number from 1 to 10000; received 0",
     galvi.composite, galvi.gauss(2), 0),
)  # fmt: skip
SPACES = (
    (
        EITHER_ERROR,
        "first basis function of a space must be the constant 1; that of",
        broken_space(broken="constant"),
    ),
    (
        EITHER_ERROR,
        "basis of Bernstein must be finite .* received nan for function 2",
        broken_space(broken="nan"),
    ),
    (
        EITHER_ERROR,
        "basis of Bernstein must return real numbers of shape",
        broken_space(broken="complex"),
    ),
    (
        EITHER_ERROR,
        r"return .*\(1, 4\) for t of shape \(1,\); received .*\(4, 1\)",
        broken_space(broken="turned"),
    ),
    (
        EITHER_ERROR,
        r"derivative of Bernstein must return .* received shape \(1,\)",
        broken_space(broken="flat"),
    ),
    (
        EITHER_ERROR,
        "must be that of its basis; function 2 differs from its difference",
        broken_space(broken="sign"),
    ),
    (
        EITHER_ERROR,
        "degree of Bernstein must be a whole number from 0 to 3; received 4",
        broken_space(degree=4),
    ),
    (
        EITHER_ERROR,
        "dimension of Bernstein must be a whole number of at least 2",
        broken_space(dimension=1),
    ),
    (
        EITHER_ERROR,
        "exact of Bernstein must be True or False; received 'yes'",
        broken_space(exact="yes"),
    ),
    (
        EITHER_ERROR,
        "exact of Bernstein must be False unless its functions .*decimal",
        broken_space(exact=True),
    ),
    (ValueError, r"it lacks one of degree 1, by .* Say degree = 0", pair(Even())),
    (TypeError, r"a space must have dimension, .* lacks degree", pair(WithoutDegree())),
    (TypeError, r"a space must be hashable, .* Make it a frozen dataclass", pair(Unhashable())),
    (ValueError, "is inconsistent" + ON_PIECES, pair(PIECES, galvi.gauss(8))),
    (ValueError, "is ill-posed" + ON_PIECES, pair(PIECES, galvi.composite(galvi.gauss(1), 3))),
    (ValueError, "a degree for each of the 2 components; received 3", by_component(4, 4, 4)),
    (
        ValueError,
        "for Canonical and Lagrangian systems",
        by_component(*(3,) * OUTER.v0.size, problem=OUTER),
    ),
    *(
        (ValueError, "degrees", partial(galvi.ComponentPolynomials, degrees))
        for degrees in ((), (4, 0), "44")
    ),
    *(
        (ValueError, r"frequency must be .*; received .* radians a step", partial(space, value))
        for value in (0.0, float("nan"))
        for space in (partial(galvi.Fourier, 2), partial(galvi.PolynomialFourier, 2, 2))
    ),
    *(
        (ValueError, "harmonics must be a whole number from 1 to 64; received", partial(*call))
        for call in product((galvi.Fourier, partial(galvi.PolynomialFourier, 2)), (0, 65))
    ),
    (ValueError, "must be at most 512 radians a step; received 10 times", galvi.Fourier, 10, 60.0),
    (
        ValueError,
        "must differ from polynomials and from each other",
        galvi.PolynomialFourier,
        4,
        8,
        1e-3,
    ),
)
PAIRS = (
    *(
        (ValueError, "is ill-posed: a free particle has no unique motion",
         pair(galvi.Polynomials(degree), degree - 1))
        for degree in (2, 12)
    ),
    (ValueError, "is inconsistent: a free particle does not move in a str", pair(Sines(), 6)),
    *(
        (ValueError, r"is inconsistent.* Use a space that contains linear functions, e.g. g",
         pair(galvi.Fourier(1, frequency), points))
        for frequency, points in ((0.3, 2), (20.0, 30))
    ),
    (ValueError, r"on each piece, galvi.composite\(rule, 2\), with a rule",
     pair(PiecewisePolynomials(1, 2), 3)),
    (ValueError, r"on each piece, galvi.composite\(rule, 4\), with enou",
     pair(PiecewisePolynomials(1, 4), 3)),
    (TypeError, r"space must be a space such as galvi.Polynomials", pair(5)),
    (TypeError, r"rule must be a rule such as galvi.gauss", pair(galvi.Polynomials(3), None)),
    (TypeError, r"theory is of a method such as galvi.Galerkin\(.* received 5\.", theory(5)),
    (TypeError, "a space must have dimension", theory(WithoutDegree(), galvi.gauss(3))),
    (TypeError, r"needs a rule such as galvi.gauss\(8\); received None", theory(DEGREE_THREE[0])),
    (TypeError, "a method has its own rule", theory(method(), galvi.gauss(3))),
    (TypeError, r"problem must be a galvi.Problem .* received 7", theory(*DEGREE_THREE, 7)),
    (ValueError, "step means nothing without a problem", theory(*DEGREE_THREE, None, 0.1)),
    (ValueError, "lipschitz means nothing without", theory(*DEGREE_THREE, None, None, 1.0)),
    (ValueError, "step must not be zero; received 0.0", theory(*DEGREE_THREE, KEPLER, 0.0)),
    (ValueError, "step must be a finite real number", theory(*DEGREE_THREE, KEPLER, np.nan)),
    (ValueError, "lipschitz must not be negative", theory(*DEGREE_THREE, KEPLER, 0.1, -1.0)),
    (ValueError, "lipschitz must be a finite", theory(*DEGREE_THREE, KEPLER, 0.1, np.inf)),
    (ValueError, "a degree for each of the 2 components; received 3",
     theory(galvi.ComponentPolynomials((8, 4, 3)), galvi.gauss(8), KEPLER)),
)  # fmt: skip


def framed(problem, frame, **options):
    """A call that runs a step in a frame."""
    within = galvi.Galerkin(galvi.Polynomials(4), galvi.gauss(4), chart=frame)
    return lambda: galvi.integrate(problem, within, 0.1, 1, **options)


def in_frame(space, rule):
    return lambda: galvi.Galerkin(space, rule, chart=HARMONIC)


HARMONIC, IN_KEPLERS = galvi.HarmonicFrame(), galvi.KeplerFrame()
CHAIN = galvi.problems.fermi_pasta_ulam_tsingou(masses=4, alpha=0.4, beta=0.3)
SPRING = galvi.Problem(galvi.Canonical(1.0, galvi.LinearSpring(2.0)), [1.0, 0.0], [0.0, 1.0])
PAIR = galvi.Problem(galvi.NBody([1.0, 0.02]), [[0.0, 0.0], [1.0, 0.1]], [[0.0, 0.0], [0.1, 1.0]])
FAST = galvi.Problem(PAIR.system, PAIR.q0, 3.0 * PAIR.v0, parameters={"bodies": ("star", "comet")})


def on_a_barycentre(mass):
    """A call that runs a step with a third body at the centre of mass of two."""
    q, v = np.zeros((3, 3)), np.zeros((3, 3))
    q[:2, 0], v[:2, 1] = (-1.0, 1.0), (-0.5, 0.5)
    frame = galvi.KeplerFrame(hierarchy=((0, 1), 2))
    return framed(galvi.Problem(galvi.NBody([1.0, 1.0, mass]), q, v), frame)


def nested(tree, problem=OUTER):
    """A call that runs a step in the frame of a hierarchy."""
    return framed(problem, galvi.KeplerFrame(hierarchy=tree))


def eccentric(e):
    """A call that runs a step from the pericentre of a comet."""
    q, v = np.zeros((2, 2, 2))
    q[1, 0], v[1, 1] = 1.0 - e, np.sqrt((1.0 + e) / (1.0 - e))
    system, names = galvi.NBody([1.0, 0.0]), {"bodies": ("Sun", "comet")}
    return framed(galvi.Problem(system, q, v, parameters=names), IN_KEPLERS)


def pulled(*forces):
    """A call that runs a step in the frame with forces beside gravity."""
    system = galvi.NBody(PAIR.system.masses, forces=forces)
    return framed(galvi.Problem(system, PAIR.q0, PAIR.v0), IN_KEPLERS)


BLIND = galvi.Problem(
    galvi.Canonical(1.0, lambda q: q @ q if q[0] > 0.0 else 0.0, check=False), [1.0], [0.0]
)
PLANETS = OUTER.parameters["bodies"]
LIGHT = galvi.Problem(galvi.NBody([1.0, 0.0, 0.0]), np.eye(3), np.zeros((3, 3)))
DRAG, TIDES = galvi.Drag([0.0, 0.1]), galvi.Tides(0, 0.3, 0.3, 0.01)
ONCE = "must name every body that has a mass once; received one with"
CONSERVE = r"forces that have an energy \(Obl.*"
FRAMES = (
    *(
        (ValueError, r"a frame needs galvi\.Polynomials\(s\)", in_frame(space, rule))
        for space, rule in (
            (galvi.Polynomials(4), galvi.gauss(5)),
            (galvi.PolynomialFourier(1, 2), galvi.gauss(16)),
        )
    ),
    (ValueError, "in a moving frame the solver must be one of auto",
     framed(CHAIN, HARMONIC, solver="newton")),
    (ValueError, "passes must be", lambda: galvi.KeplerFrame(passes=0)),
    (ValueError, "stiffness must be a symmetric matrix",
     lambda: galvi.HarmonicFrame(stiffness=[[1.0, 2.0], [0.0, 1.0]])),
    (ValueError, r"must be \(4, 4\)", framed(CHAIN, galvi.HarmonicFrame([[1.0]]))),
    (ValueError, "needs a Canonical system without an external force", framed(PAIR, HARMONIC)),
    (ValueError, "at least two bodies; received a Canonical system", framed(CHAIN, IN_KEPLERS)),
    (ValueError, "at least two bodies; received one body", framed(ALONE, IN_KEPLERS)),
    (ValueError, "needs an NBody system", framed(galvi.problems.free_rigid_body(), IN_KEPLERS)),
    (ValueError, "moving frame",
     lambda: galvi.momentum_balance(framed(SPRING, HARMONIC)())),
    (ValueError, "received one of body comet that is not", framed(FAST, IN_KEPLERS)),
    (ValueError, "needs bound orbits", on_a_barycentre(1e-3)),
    (ValueError, "needs bound orbits", on_a_barycentre(0.0)),
    (ValueError, "needs a gradient that is built in or could be traced", framed(BLIND, HARMONIC)),
    (ValueError, r"needs a finite d2V/dq2 at q = 0", framed(KEPLER, HARMONIC)),
    *(
        (ValueError, "hierarchy must be nested tuples",
         partial(galvi.KeplerFrame, hierarchy=wrong))
        for wrong in ("Sun", (), ("Sun",), ("Sun", ("Earth",)), (0, 1.5), (0, True), ((0, 1), None))
    ),
    (ValueError, ONCE + "out Pluto", nested(PLANETS[:-1])),
    (ValueError, ONCE + " Pluto twice", nested((*PLANETS, "Pluto"))),
    (ValueError, ONCE + r" 'Mars', which is none of \['Sun and", nested((*PLANETS, "Mars"))),
    (ValueError, ONCE + " 7, which is none of", nested((0, 1, (2, 3), 4, 7))),
    (ValueError, ONCE + " -1", nested((0, 1, (2, -1), 4, 5))),
    (ValueError, "one that joins 1 and others, all of them massless", nested((0, (1, 2)), LIGHT)),
    (ValueError, "about what its hierarchy names; received one of body",
     nested(((0, 1, 2), (3, 4, 5)))),
    *(
        (ValueError, rf"up to 0\.9,.*received {e} of body comet, at the .*Use clock=galvi\.Dy",
         eccentric(e))
        for e in (0.9001, 0.999)
    ),
    (ValueError, CONSERVE + "with Drag, Tides. Use another", pulled(DRAG, TIDES)),
    (ValueError, CONSERVE + "with Relativity. Use", pulled(galvi.Relativity(9.0))),
    (ValueError, CONSERVE + "with Force. Use", pulled(galvi.Force(lambda q: 0.0 * q))),
    (ValueError, "exclude each other",
     lambda: galvi.Galerkin(*DEGREE_THREE, chart=IN_KEPLERS, clock=galvi.DynamicalTime())),
)  # fmt: skip
MANY_POINTS = tuple(
    (ValueError, r"from . to 1000; received 100000\. .*galvi\.composite", partial(family, 100000))
    for family in (galvi.gauss, galvi.lobatto, galvi.radau, galvi.clenshaw_curtis)
)


def timed(problem, clock, step=0.1, steps=3, points=4, **options):
    """A call that runs steps in a clock."""
    rule = galvi.gauss(points) if isinstance(points, int) else points
    within = galvi.Galerkin(galvi.Polynomials(4), rule, clock=clock)
    return lambda: galvi.integrate(problem, within, step, steps, **options)


def in_clock(clock):
    return lambda: galvi.Galerkin(*DEGREE_THREE, clock=clock)


def dragged(force, *masses):
    """A problem of three bodies with a force."""
    return galvi.Problem(galvi.NBody(masses, forces=force), np.eye(3), np.eye(3)[::-1])


DYNAMICAL, SUNDMAN = galvi.DynamicalTime(), galvi.Sundman()
SLOWED = galvi.Problem(
    galvi.Canonical(1.0, galvi.CentralForce(1.0), force=lambda q, v: -0.1 * v), KEPLER.q0, KEPLER.v0
)
WRONG_SLOPE = galvi.Clock(lambda q: (q @ q) ** 0.75, lambda q: np.ones(2))
OWN_CLOCK = galvi.Clock(lambda q: 1.0 + q @ q)
CLOCKS = (
    (ValueError, "at least two bodies", timed(KEPLER, DYNAMICAL)),
    (ValueError, "one particle", timed(OUTER, SUNDMAN)),
    (ValueError, "a revolution is 2 pi", timed(OUTER, DYNAMICAL, 7.0)),
    (ValueError, "received neither", timed(OUTER, DYNAMICAL, steps=None)),
    (ValueError, "positive", timed(KEPLER, galvi.Clock(lambda q: -1.0))),
    (ValueError, "finite", timed(KEPLER, galvi.Clock(lambda q: np.inf))),
    (ValueError, "gradient must be dg/dq", timed(KEPLER, WRONG_SLOPE)),
    (ValueError, "collocate t", timed(SLOWED, SUNDMAN, points=5)),
    (ValueError, r"solver fixed_point needs a constant mass and gauss",
     timed(dragged(galvi.Drag([0.0, 0.1, 0.1]), 1.0, 0.1, 0.1), DYNAMICAL, points=galvi.lobatto(5),
           solver="fixed_point")),
    (ValueError, "massless bodies have no Lagrangian",
     timed(dragged(galvi.Force(lambda q: 0.0 * q), 1.0, 0.1, 0.0), DYNAMICAL)),
    (ValueError, "symplecticity_defect",
     lambda: galvi.step_derivative(KEPLER, in_clock(SUNDMAN)(), 0.1)),
    (ValueError, "constant in time",
     lambda: galvi.theory(in_clock(SUNDMAN)(), problem=KEPLER, step=0.1)),
    (TypeError, "must be a function", lambda: galvi.Clock(3)),
    (ValueError, "power", lambda: galvi.Sundman(0.0)),
    (ValueError, "gm must be positive", lambda: galvi.Sundman(gm=0.0)),
    (TypeError, "clock must be a clock", in_clock(3)),
    (TypeError, "clock must be a clock", in_clock(galvi.DynamicalTime)),
    (ValueError, "until", lambda: galvi.resume(timed(KEPLER, SUNDMAN)(), until=0.0)),
    (ValueError, "point masses", lambda: timed(KEPLER, SUNDMAN)().to_rebound()),
    (ValueError, r"clock are galvi's own; received .*Clock\(",
     lambda: galvi.save(timed(KEPLER, OWN_CLOCK)(), "run.npz")),
)  # fmt: skip
TABLE = {
    "rules": (*RULES, *MANY_POINTS),
    "spaces": SPACES,
    "pairs": PAIRS,
    "frames": FRAMES,
    "clocks": CLOCKS,
}
