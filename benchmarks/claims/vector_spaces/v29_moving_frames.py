"""V29: Gauss collocation in a moving frame keeps the order, the form and the momenta."""

from __future__ import annotations

from benchmarks.claims.kit import *
from benchmarks.measures.symplectic_form import canonical_defect, map_derivative
from references.scipy.ivp import DOP853
from references.stored.planets import STORED_TRUTH

ORDER, DEFECT = "order of the error at the end", "defect of DF^T J DF = J"
FROM_EXACT = "defect, from the step's exact derivative"
APART = "DF against central differences"
LINEAR, ANGULAR = "change of the linear momentum", "change of the angular momentum"
ENERGY, PLACE = "error of the energy", "error of the place at the end"
PLANETS = (LINEAR, ANGULAR, ENERGY, PLACE)
NOISE = "root mean square of the energy's error"
EXACT = "error after 50 steps of h omega = 100"
TWICE = f"{ENERGY}, over that of converged passes, two passes"
CHAIN = galvi.problems.fermi_pasta_ulam_tsingou(masses=4, alpha=0.4, beta=0.3)
STARS = Problem(
    galvi.NBody([1.0, 1.0, 1.0]),
    [[-0.05, 0.0], [0.95, 0.0], [-0.45, 3.5]],
    [[0.0, -0.7], [0.0, 0.7], [-0.9, 0.0]],
    name="three equal masses, two of them close",
)
FRAMES: Mapping[str, tuple[Problem, Any, float, float]] = {  # problem, frame, longest step, T
    "harmonic frame": (CHAIN, galvi.HarmonicFrame(), 0.4, 4.8),
    "Kepler frame": (STARS, galvi.KeplerFrame(even=True), 0.3, 3.0),
    "Kepler frame, moved nodes": (STARS, galvi.KeplerFrame(), 0.15, 3.0),
}
DEGREES = (2, 3)
REFINED = (1.0, 0.8, 0.625, 0.5)
YEARS, PARTS = 3_652_500.0, 10  # 10,000 years in days
STEP = 400.0
SHORT, MANY, FEW = 300.0, 8, 2  # days; starts over 100,000 years, and when quick over 10,000
CLOSE = 0.3  # of an order: 0.1 was measured
LIMIT = 1e-11  # 1e-13 was measured, by differences
AGREES = 1e-10  # 2e-13 was measured


def measure(make_method: MakeMethod, quick: bool, report: Report) -> dict[str, float]:
    """Orders and defects in each frame; momenta and energies of the outer planets."""
    found: dict[str, float] = {}
    for name, (problem, chart, longest, duration) in FRAMES.items():
        report(name)
        truth = DOP853.run(problem, duration, {"samples": 1, "tolerance": 1e-13}).q[-1]
        for degree in DEGREES:
            method = collocation(make_method, degree, chart)
            slope = _slope(problem, method, longest, duration, truth)
            found[f"{ORDER}, {name}, {degree} stages"] = slope
        method = collocation(make_method, 3, chart)
        exact = galvi.step_derivative(problem, method, longest)
        DF = map_derivative(problem, method, longest)
        found[f"{FROM_EXACT}, {name}"] = canonical_defect(exact)
        found[f"{DEFECT}, {name}"] = canonical_defect(DF)
        found[f"{APART}, {name}"] = float(np.max(np.abs(exact - DF)))
    report("oscillator")
    found[EXACT] = _oscillation(collocation(make_method, 1, galvi.HarmonicFrame()))
    report("planets")
    found |= _planets(collocation(make_method, 8, galvi.KeplerFrame()), quick)
    few = _planets(collocation(make_method, 8, galvi.KeplerFrame(passes=2)), quick)
    found[TWICE] = few[ENERGY] / found[ENERGY] if found[ENERGY] else math.nan
    report("planets, nearby starts")
    found[NOISE] = _noise(collocation(make_method, 8, galvi.KeplerFrame()), quick)
    return found


def _slope(problem: Problem, method: Any, longest: float, duration: float, truth: Array) -> float:
    """The slope of the errors' logarithms."""
    counts = [round(duration / (longest * share)) for share in REFINED]
    errors = [
        float(np.max(np.abs(galvi.integrate(problem, method, duration / k, k).q[-1] - truth)))
        for k in counts
    ]
    return -convergence_fits.slope(counts, errors)


def _oscillation(method: Any) -> float:
    system = galvi.Canonical(1.0, galvi.LinearSpring(1e4))
    run = galvi.integrate(Problem(system, [1.0], [0.0]), method, 1.0, 50)
    return float(np.max(np.abs(run.q[:, 0] - np.cos(100.0 * run.t))))


def _planets(method: Any, quick: bool) -> dict[str, float]:
    """Relative changes over 10,000 years of the outer planets, or a tenth of that when quick."""
    problem = galvi.problems.outer_solar_system()
    duration = YEARS / 10 if quick else YEARS
    parts = round(duration / STEP / PARTS)
    run = galvi.integrate(
        problem, method, duration / (parts * PARTS), parts * PARTS, save_every=parts
    )
    truth = STORED_TRUTH.run(problem, duration, {"samples": 1}).q[-1]
    energies, size = galvi.energy(run), float(np.max(np.abs(run.p)))
    linear, angular = galvi.linear_momentum(run), galvi.momentum_map(run)
    turning = float(np.max(np.linalg.norm(angular, axis=-1)))
    return {
        ENERGY: float(np.max(np.abs(energies / energies[0] - 1.0))),
        LINEAR: float(np.max(np.abs(linear - linear[0]))) / size,
        ANGULAR: float(np.max(np.abs(angular - angular[0]))) / turning,
        PLACE: float(np.max(np.abs(run.q[-1] - truth))),
    }


def _noise(method: Any, quick: bool) -> float:
    """The energy's relative error at the end, root mean square over starts that differ by 1e-9."""
    problem, random = galvi.problems.outer_solar_system(), np.random.default_rng(5)
    steps = round((YEARS if quick else 10.0 * YEARS) / SHORT)
    errors = []
    for _ in range(FEW if quick else MANY):
        nearby = problem.q0 * (1.0 + 1e-9 * random.normal(size=problem.q0.shape))
        start = Problem(problem.system, nearby, problem.v0)
        first, last = galvi.energy(galvi.integrate(start, method, SHORT, steps, save_every=steps))
        errors.append(float(last / first - 1.0))
    return float(np.sqrt(np.mean(np.square(errors))))


def _moved(name: str) -> bool:
    """Whether the frame's nodes follow the start, so that the map is not that of held nodes."""
    return bool(FRAMES[name][1] == galvi.KeplerFrame())


def _of_frame(name: str) -> Iterator[Check]:
    """Orders from both sides, and the symplectic form."""
    problem, _, longest, duration = FRAMES[name]
    step, moved = f"{problem.name}, a step of {longest:g}, 3 stages", _moved(name)
    for degree in DEGREES:
        yield check(
            f"{ORDER}, {name}, {degree} stages",
            Within(2 * degree - CLOSE, 2 * degree + CLOSE),
            setup=f"{problem.name}, T = {duration:g}, h from {longest:g} to half of it",
            claimed=f"the order is that of Gauss collocation, {2 * degree}",
            reason="The frame's map is analytic in h, and its nodes are moved in proportion to h.",
            reference=DOP853.name,
        )
    yield check(
        f"{DEFECT}, {name}",
        Finding() if moved else AtMost(LIMIT),
        setup=f"{step}; DF by central differences of order eight over starts; relative to |DF|^2",
        claimed="none: nodes that follow the start" if moved else "a step is symplectic",
        reason="As a map of its start the step is not symplectic: the nodes follow the start, and "
        "their derivative adds to DF, by the order of the step's own error."
        if moved
        else "Collocation at Gauss nodes is symplectic whatever their weights in time are.",
        reference="J",
    )
    yield check(
        f"{FROM_EXACT}, {name}",
        AtMost(1e-14),
        setup=f"{step}, with its nodes held; relative to |DF|^2",
        claimed="with its nodes held a step is symplectic, wherever they are",
        reason="The derivatives of slopes are J times symmetric matrices, and M = 0.",
        reference="J",
    )
    if not moved:
        yield check(
            f"{APART}, {name}",
            AtMost(AGREES),
            setup=f"{step}; largest entry",
            claimed="DF is the derivative of the step",
            reason="The same map, whose nodes are the same for all starts, differenced to order "
            "eight.",
            reference="central differences of the run's states",
        )


SETUP = f"outer planets, 10,000 years (1,000 when quick), h = {STEP:g} d, 8 stages"
CHECKS = (
    *(one for name in FRAMES for one in _of_frame(name)),
    check(
        EXACT,
        AtMost(1e-11),
        setup="x'' = -1e4 x from (1, 0), h = 1, one stage; against cos(100 t)",
        claimed="what the frame holds is exact at any step",
        reason="Nothing is left to collocate; t omega is known to 1e-12.",
        reference="cos(100 t)",
    ),
    *(
        check(
            quantity,
            AtMost(1e-13),
            setup=f"{SETUP}; relative, at the largest",
            claimed="the Kepler frame keeps the linear and the angular momentum",
            reason="Each orbit keeps its own, and collocation keeps what is quadratic.",
            reference="the momenta at the start",
        )
        for quantity in (LINEAR, ANGULAR)
    ),
    check(
        ENERGY,
        AtMost(2e-14),
        setup=f"{SETUP}; relative, at the largest",
        claimed="converged passes leave no drift",
        reason="Rounding errors are a random walk, and the step's own error is less.",
        reference="the energy at the start",
    ),
    check(
        NOISE,
        AtMost(2e-14),
        setup=f"outer planets, h = {SHORT:g} d, 8 stages; {MANY} starts that differ by 1e-9, "
        f"after 100,000 years ({FEW} after 10,000 when quick); relative",
        claimed="rounding errors of the energy are a random walk of less than an ulp a step",
        reason="What rounding changes in an orbit's energy is taken from its speed.",
        reference="the energy at the start",
    ),
    check(
        TWICE,
        AtLeast(10.0),
        setup=f"{SETUP}; the largest error with two passes over that with as many as needed",
        claimed="two passes are not symplectic: their energy drifts",
        reason="Two passes leave the square of the contraction, 1e-6, of what is left.",
        reference="converged passes",
    ),
    check(
        PLACE,
        AtMost(1e-9),
        setup=f"{SETUP}; au",
        claimed="steps of a tenth of the shortest period are accurate",
        reason="What the frame leaves is a thousandth of the attraction, and slow.",
        reference=STORED_TRUTH.name,
    ),
)


def _sheared(sound: Callable[..., Array]) -> Callable[..., Array]:
    """DF of a step after a shear of the state."""

    def derivative(*given: Any) -> Array:
        DF = sound(*given)
        d = len(DF) // 2
        shear = np.eye(2 * d)
        shear[:d, d:] = 1e-8 * np.eye(d)
        return DF @ shear

    return derivative


V29 = scalars(
    "V29",
    "Moving frames keep the order, the form and the momenta",
    measure,
    CHECKS,
    source="ours; docs/frames.md",
    statement="Ours, see docs/frames.md: in moving frames a method keeps its order, the "
    "symplectic form and the momenta.",
    caught=(
        of_table(
            *(ANGULAR, ENERGY, PLACE),
            *(f"{DEFECT}, {name}" for name in ("harmonic frame", "Kepler frame")),
            *(f"{FROM_EXACT}, {name}" for name in FRAMES),
            *(f"{ORDER}, {name}, {k} stages" for name in FRAMES for k in DEGREES),
            integral=1.5,
        ),
        Fault(
            "a state sheared before the step: symplectic, so that only differences tell",
            {f"{APART}, {name}" for name in FRAMES if not _moved(name)}.__eq__,
            wrong={
                "galvi.step_derivative": _sheared,
                f"{__name__}._planets": always(lambda *given: dict.fromkeys(PLANETS, 0.0)),
                f"{__name__}._noise": always(lambda *given: 0.0),
            },
        ),
    ),
)
