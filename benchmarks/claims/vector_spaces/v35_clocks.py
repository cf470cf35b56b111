"""V35: constant steps in a clock keep order, form, momenta and the direction of time."""

from __future__ import annotations

from copy import copy

from benchmarks.claims.kit import *
from galvi.run.clocked.transformed import LagrangianInTau
from references.closed_forms.kepler import KEPLER
from references.scipy.ivp import DOP853
from references.scipy.lagrangian_ivp import LAGRANGIAN_DOP853
from references.stored.encounters import kozai_triple

ORDER, DEFECT = "order of the error at the end", "defect of DF^T J DF = J, in (q, t; p, -E)"
LINEAR, ANGULAR = "change of the linear momentum", "change of the angular momentum"
BACK = "distance from the start after as many steps back"
ENERGY, FIRST = "largest error of the energy", "largest error of the energy in a hundredth"
CURVE = "order of the curve between steps"
STARS = Problem(
    galvi.NBody([1.0, 0.5, 0.7]),
    [[-0.05, 0.0, 0.0], [0.95, 0.0, 0.1], [-0.45, 3.5, 0.0]],
    [[0.0, -0.3, 0.0], [0.0, 0.7, 0.0], [-0.6, 0.0, 0.1]],
    name="three stars, two of them close",
)


def _facing(q: Any) -> Any:
    return 1.0 / (2.0 + np.cos(q[1]))


@cache
def clocks() -> Mapping[str, tuple[Problem, Any, float, float]]:
    """Problem, clock, longest step, T; made when needed, since one of them loads SymPy."""
    swing = galvi.problems.elastic_pendulum()
    return {
        "DynamicalTime": (STARS, galvi.DynamicalTime(), 0.5, 4.0),
        "Sundman": (galvi.problems.kepler(0.5), galvi.Sundman(), 0.5, 6.0),
        "Clock of a function": (swing, galvi.Clock(_facing), 0.3, 2.0),
    }


DEGREES = (2, 3)
REFINED = (1.0, 0.8, 0.625, 0.5)
SAMPLES = 200  # of a curve
MANY, FEW = 1_000_000.0, 100_000.0  # of tau; when quick
STEP = 0.4
CLOSE = 0.25  # of an order: 0.09 was measured
LIMIT = 1e-12  # 8e-14 was measured, by differences
ROUND_OFF = 2e-14  # of momenta and places of size 1: 2e-15 was measured
KEPT = 1e-11  # of the energy over MANY: 3e-13 was measured


def measure(make_method: MakeMethod, quick: bool, report: Report) -> dict[str, float]:
    """Orders, defects, momenta and ways back in each clock; the energy in a long run."""
    found: dict[str, float] = {}
    times = np.linspace(0.0, 1.0, SAMPLES + 1)
    for name, (problem, clock, longest, duration) in clocks().items():
        report(name)
        truth, sizes = _truth(problem, duration), [longest * share for share in REFINED]

        def runs(degree: int, of: tuple[Any, ...] = (problem, clock, duration, sizes)) -> Any:
            problem, clock, duration, sizes = of
            method = _method(make_method, degree, clock)
            return [galvi.integrate(problem, method, h, duration=duration) for h in sizes]

        for degree in DEGREES:
            errors = [np.max(np.abs(run.q[-1] - truth[-1])) for run in runs(degree)]
            found[f"{ORDER}, {name}, {degree} stages"] = convergence_fits.slope(sizes, errors)
        errors = [np.max(np.abs(run(duration * times) - truth)) for run in runs(4)]
        found[f"{CURVE}, {name}, 4 stages"] = convergence_fits.slope(sizes, errors)
        method = _method(make_method, 2, clock)
        found[f"{DEFECT}, {name}"] = galvi.symplecticity_defect(problem, method, longest)
        found[f"{BACK}, {name}"] = galvi.round_trip_error(problem, method, longest, 20)
    report("momenta")
    method = _method(make_method, 2, galvi.DynamicalTime())
    run = galvi.integrate(STARS, method, 0.5, 200)
    linear, angular = run.p.sum(axis=1), np.cross(run.q, run.p).sum(axis=1)
    found[LINEAR] = float(np.max(np.abs(linear - linear[0])))
    found[ANGULAR] = float(np.max(np.abs(angular - angular[0])))
    report("a long run")
    steps = round((FEW if quick else MANY) / STEP)
    run = galvi.integrate(
        kozai_triple(), _method(make_method, 8, galvi.DynamicalTime()), STEP, steps,
        save_every=steps // 400,
    )  # fmt: skip
    change = np.abs(galvi.energy(run) / galvi.energy(run)[0] - 1.0)
    found[ENERGY], found[FIRST] = float(np.max(change)), float(np.max(change[:5]))
    return found


def _method(make_method: MakeMethod, degree: int, clock: Any) -> Any:
    method = make_method(galvi.Polynomials(degree), galvi.gauss(degree))
    changed = copy(method)
    vars(changed)["clock"] = clock
    return changed


def _truth(problem: Problem, duration: float) -> Array:
    if KEPLER.supports(problem):
        return KEPLER.run(problem, duration, {"samples": SAMPLES}).q
    known = LAGRANGIAN_DOP853 if isinstance(problem.system, galvi.Lagrangian) else DOP853
    return known.run(problem, duration, {"samples": SAMPLES, "tolerance": 1e-13}).q


def _checks() -> Iterator[Check]:
    for name, (problem, _, longest, duration) in clocks().items():
        setup = f"{problem.name}, T = {duration:g}, h from {longest:g} to half of it, in tau"
        for degree in DEGREES:
            yield check(
                f"{ORDER}, {name}, {degree} stages",
                Within(2 * degree - CLOSE, 2 * degree + CLOSE),
                setup=setup,
                claimed=f"the order is that of the method without a clock, {2 * degree}",
                reason="L_tau is a Lagrangian like any other, t its quadrature, and the last, "
                "shortened step has the order of the others.",
            )
        yield check(
            f"{CURVE}, {name}, 4 stages",
            Within(5.0 - CLOSE, 5.0 + CLOSE),
            setup=f"{setup}; {SAMPLES} times",
            claimed="the curve q(t) has order s + 1",
            reason="q and t are collocation polynomials in tau, of degree s.",
        )
        yield check(
            f"{DEFECT}, {name}",
            AtMost(LIMIT),
            setup=f"{problem.name}, one step of {longest:g}, 2 stages; DF by central differences "
            "of order eight over starts and energies; relative to |DF|^2",
            claimed="a step of constant length in tau is symplectic",
            reason="The discrete action is that of L_tau.",
            reference="J",
        )
        yield check(
            f"{BACK}, {name}",
            AtMost(ROUND_OFF),
            setup=f"{problem.name}, 20 steps of {longest:g} and back, 2 stages",
            claimed="a symmetric method stays symmetric",
            reason="g depends on the configuration alone.",
            reference="the start",
        )
    for quantity, what in ((LINEAR, "translations"), (ANGULAR, "rotations")):
        yield check(
            quantity,
            AtMost(ROUND_OFF),
            setup=f"{STARS.name}, 200 steps of 0.5, 2 stages",
            claimed="momenta are kept to round-off where g is invariant",
            reason=f"DynamicalTime is invariant under {what}, and so is L_tau.",
            reference="the start",
        )
    yield check(
        ENERGY,
        AtMost(KEPT),
        setup=f"{kozai_triple().name}, {MANY:g} of tau in steps of {STEP:g}, 8 stages",
        claimed="the energy's error stays bounded",
        reason="The method keeps K = g (H - E) up to its error, so that H errs by that over g, "
        "most where g is least; above that, by the rounding of K.",
        reference="the start",
    )
    yield check(
        "growth of the energy's error",
        Finding(),
        lambda found: found[ENERGY] / found[FIRST] if found[FIRST] else math.nan,
        setup="the largest error of the whole run over that of its first hundredth",
        claimed="no claim: a random walk of K would give 10",
        reason="What rounding leaves of K adds up.",
        reference="the start",
    )


def _without_slope(sound: Callable[..., Any]) -> Callable[..., Any]:
    """L_tau with g held where it is differentiated: an adaptive step chosen from outside."""

    def wrong(in_tau: LagrangianInTau, driven: bool, t0: float) -> Problem:
        inner = sound(in_tau, driven, t0)
        base, rate = in_tau.base, in_tau.rate
        value, d = base.function, base.group.dimension

        def slopes(q: Array, u: Array) -> Array:
            g, found = rate(q), np.empty(2 * d)
            for k, unit in enumerate(np.eye(d)):
                found[k] = _slope_of(lambda x, unit=unit: value(q, u / g + x * unit))
                found[d + k] = g * _slope_of(lambda x, unit=unit: value(q + x * unit, u / g))
            return found

        system = galvi.Lagrangian(inner.system.function, base.group, slopes, check=False)
        return Problem(system, inner.q0, inner.v0, inner.t0)

    return wrong


def _slope_of(function: Callable[[float], float], far: float = 1e-3) -> float:
    ends = [8.0 * (function(far) - function(-far)), function(2 * far) - function(-2 * far)]
    return float(ends[0] - ends[1]) / (12.0 * far)


TRANSFORMED = "galvi.run.clocked.transformed"
V35 = scalars(
    "V35",
    "Constant steps in a clock keep order, form, momenta and the direction of time",
    measure,
    _checks,
    source="Sundman, Poincare; no claim of H or M",
    setup="Polynomials(s) with Gauss s",
    reference=f"{DOP853.name}, tolerance 1e-13; {KEPLER.name}",
    statement="Ours: with dt = g(q) dtau the action of g (L(q, q'/g) + E) is discretised with "
    "constant steps of tau. Neither paper has it; it is checked as their statements are.",
    caught=(
        Fault(
            "g without its slope",
            {f"{DEFECT}, Sundman"},
            wrong={
                f"{TRANSFORMED}.in_clock": _without_slope,
                **fewer(__name__, FEW=400.0 * STEP),
                f"{__name__}.clocks": lambda sound: lambda: {"Sundman": sound()["Sundman"]},
            },
        ),
        Fault(
            "the energy off by 1e-6",
            {f"{ORDER}, {name}, 3 stages" for name in ("DynamicalTime", "Sundman")},
            wrong={
                "galvi.run.clocked.in_lanes.energy_of": scaled(1.0 + 1e-6),
                "galvi.run.clocked.run.motion_in_transformed_time": given(
                    lambda problem, method, energy, *more: (
                        problem, method, energy * (1.0 + 1e-6), *more,
                    )
                ),
                **fewer(__name__, FEW=400.0 * STEP),
            },
        ),
    ),
)  # fmt: skip
