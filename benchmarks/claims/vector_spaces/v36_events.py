"""V36: events are all found, once each, at times of the steps' order."""

from __future__ import annotations

from decimal import Decimal, localcontext

from benchmarks.claims.kit import *
from references.closed_forms.double_double import DIGITS
from references.closed_forms.pendulum import Modulus

ORDER, CURVE = "order of the times of events", "order of the curve's distance from them"
MISSING, EXTRA = "crossings of the pendulum that are not found", "crossings that are none"
LATE = "largest error of a crossing's time, in periods"
ENDS = "crossings at ends of steps, found minus true"
PAIRS = "crossings in nearly double pairs, found minus true"
CROSSINGS, FEW = 10_000, 200  # of the pendulum; when quick
SWING = math.pi * 0.75  # its amplitude
STAGES = (3, 4)
ECCENTRICITY, PARTS = 0.3, (40.3, 50.8, 63.9, 80.6)  # steps a revolution
ANGLES = np.linspace(0.1, 3.1, 16)  # of lines
GAPS = (1e-2, 1e-3, 1e-4, 1e-5)  # of a pair of crossings, in steps
PER_PERIOD = 16
STEP = 0.25  # of uniform motion
CLOSE = 0.3  # of an order: 0.15 was measured
LATEST = 2e-13  # of a period: 2e-14 was measured


def measure(make_method: MakeMethod, quick: bool, report: Report) -> dict[str, float]:
    """Orders of times; crossings of a pendulum, at ends of steps and in pairs."""
    found: dict[str, float] = {}
    report("orders")
    for stages in STAGES:
        method, late, early = collocation(make_method, stages), [], []
        sizes = [2.0 * math.pi / parts for parts in PARTS]
        for step in sizes:
            on_step, on_curve = _passages(method, step)
            late.append(on_step)
            early.append(on_curve)
        found[f"{ORDER}, {stages} stages"] = convergence_fits.slope(sizes, late)
        found[f"{CURVE}, {stages} stages"] = convergence_fits.slope(sizes, early)
    report("pendulum")
    found |= _crossings(make_method, FEW if quick else CROSSINGS)
    report("ends of steps and pairs")
    found[ENDS], found[PAIRS] = _at_ends(make_method), _in_pairs(make_method)
    return found


def _passages(method: Any, step: float) -> tuple[float, float]:
    """Where a Kepler orbit crosses lines: the largest error of the times of events, and the
    root mean square of the distances of roots on the curve of the run from these."""
    run = galvi.integrate(
        galvi.problems.kepler(ECCENTRICITY), method, step, math.ceil(2.0 * math.pi / step)
    )
    late, squares = 0.0, []
    for angle in ANGLES:
        normal = np.array([math.cos(angle), math.sin(angle)])
        times = galvi.find_events(run, galvi.events.plane_crossing(normal)).t
        true = _true_crossings(angle, float(run.t[-1]))
        if len(times) != len(true):
            return math.nan, math.nan
        late = max(late, float(np.max(np.abs(times - true))))
        squares.append(np.mean((_on_curve(run, normal, times) - times) ** 2))
    return late, float(np.sqrt(np.mean(squares)))


def _true_crossings(angle: float, end: float) -> Array:
    """By Kepler's equation from true anomalies; the orbit starts at its pericentre."""
    e, f = ECCENTRICITY, angle + 0.5 * math.pi + math.pi * np.arange(-2, 4)
    turns = np.round(f / (2.0 * math.pi))
    half = 0.5 * f - math.pi * turns
    u = 2.0 * np.arctan2(math.sqrt(1.0 - e) * np.sin(half), math.sqrt(1.0 + e) * np.cos(half))
    t: Array = u - e * np.sin(u) + 2.0 * math.pi * turns
    return t[(t > 0.0) & (t < end)]


def _on_curve(run: Trajectory, normal: Array, times: Array) -> Array:
    """The roots of normal . q on the curve, each near one of these times, by secants."""
    a, b = times, times + 1e-3 * float(run.t[1])
    fa, fb = run(a) @ normal, run(b) @ normal
    for _ in range(8):
        with np.errstate(all="ignore"):
            new = np.where(fb == fa, b, b - fb * (b - a) / (fb - fa))
        a, fa, b, fb = b, fb, new, run(new) @ normal
    return b


def _crossings(make_method: MakeMethod, wanted: int) -> dict[str, float]:
    """A pendulum let go passes the lowest place at odd quarters of its period 4 K(k)."""
    k = math.sin(0.5 * SWING)
    with localcontext(DIGITS):
        square = Decimal(k) ** 2
        quarter = float(Modulus(square, 1 - square).quarter)
    problem = galvi.problems.planar_pendulum(2.0 * math.asin(k))
    run = galvi.integrate(
        problem, collocation(make_method, 8), 4.0 * quarter / PER_PERIOD,
        math.ceil((0.5 * wanted + 0.1) * PER_PERIOD),
    )  # fmt: skip
    times = galvi.find_events(run, galvi.events.angle(0, 0.0)).t
    true = quarter * (1.0 + 2.0 * np.arange(wanted))
    nearest = np.clip(np.round((times / quarter - 1.0) / 2.0).astype(int), 0, wanted - 1)
    off = np.abs(times - true[nearest])
    good = off < quarter
    return {
        MISSING: float(wanted - len(np.unique(nearest[good]))),
        EXTRA: float(len(times) - len(np.unique(nearest[good]))),
        LATE: float(np.max(off[good], initial=0.0) / (4.0 * quarter)),
    }


def _at_ends(make_method: MakeMethod) -> float:
    """A point in uniform motion crosses planes at the ends of its steps, at t0 too."""
    run = _uniform(make_method)
    planes = [
        galvi.events.plane_crossing((1.0, 0.0, 0.0), x, body=0) for x in run.q[:, 0, 0].tolist()
    ]
    return float(len(galvi.find_events(run, planes)) - (len(run.t) - 1))


def _in_pairs(make_method: MakeMethod) -> float:
    """x(t) = t passes two roots of (x - a)^2 - b^2, a gap of 2 b apart, within one step."""
    run = _uniform(make_method)
    events = [
        galvi.Event(partial(_pair, middle=(3.37 + k) * STEP, half=0.5 * gap * STEP))
        for k, gap in enumerate(GAPS)
    ]
    return float(len(galvi.find_events(run, events)) - 2 * len(GAPS))


def _pair(q: Array, v: Array, t: float, middle: float, half: float) -> Any:
    return (q[0, 0] - middle) ** 2 - half**2


def _uniform(make_method: MakeMethod) -> Trajectory:
    """A free body in steps of a binary fraction: its places are exact."""
    problem = Problem(galvi.NBody([1.0]), [[0.0, 1.0, 0.0]], [[1.0, 0.0, 0.0]], name="free")
    return galvi.integrate(problem, collocation(make_method, 3), STEP, 16)


def _checks() -> Iterator[Check]:
    setup = (
        f"Kepler, e = {ECCENTRICITY:g}, a revolution in {PARTS} steps, {len(ANGLES)} lines crossed"
    )
    for stages in STAGES:
        yield check(
            f"{ORDER}, {stages} stages",
            Within(2 * stages - CLOSE, 2 * stages + CLOSE),
            setup=setup,
            claimed=f"times of events have the order of the steps, {2 * stages}",
            reason="A root is refined by a shortened step from the grid, of the steps' order.",
            reference="Kepler's equation",
        )
        yield check(
            f"{CURVE}, {stages} stages",
            Within(stages + 0.5, stages + 2.0),
            setup=setup,
            claimed=f"roots on the curve are off by its order, {stages + 1}; none is reported",
            reason="Between steps a collocation polynomial of degree s has order s + 1.",
            reference="Kepler's equation",
        )
    swing = f"planar pendulum, amplitude {SWING:.4g}, {PER_PERIOD} steps a period, 8 stages"
    for quantity in (MISSING, EXTRA):
        yield check(
            quantity,
            Exactly(0.0),
            setup=f"{swing}; {CROSSINGS} crossings of the lowest place",
            claimed="every crossing is found, once",
            reason="Roots of a step's interpolant are isolated by bounds.",
        )
    yield check(
        LATE,
        AtMost(LATEST),
        setup=f"{swing}; {CROSSINGS} crossings of the lowest place",
        claimed="their times are those of the motion",
        reason="The period's error and what rounding adds; the times are those of the steps.",
    )
    for quantity, what in ((ENDS, "the ends of 16 steps, but not at t0"), (PAIRS, "pairs")):
        yield check(
            quantity,
            Exactly(0.0),
            setup=f"uniform motion; {what}" + (f", {GAPS} of a step apart" * (what == "pairs")),
            claimed="no event is lost or counted twice",
            reason="Steps share the value where they meet; halves are searched until bounds tell.",
            reference="the motion",
        )


def _changed(change: Callable[[Trajectory, Any], Any]) -> dict[str, Callable[[Any], Any]]:
    """What is found, changed: the rows that are kept, and their times."""

    def wrong(sound: Callable[..., Any]) -> Callable[..., Any]:
        def find(run: Trajectory, events: Any) -> Any:
            found = sound(run, events)
            rows, times = change(run, found)
            return replace(found, t=times[rows], index=found.index[rows])

        return find

    return {"galvi.find_events": wrong, **fewer(__name__, FEW=20)}


def _without_ends(run: Trajectory, found: Any) -> tuple[Any, Array]:
    nearest = run.t[np.argmin(np.abs(found.t[:, None] - run.t), axis=1)]
    return np.abs(found.t - nearest) > 1e-9, found.t


def _without_pairs(run: Trajectory, found: Any) -> tuple[Any, Array]:
    both = found.index * 1e6 + found.step
    kinds, counts = np.unique(both, return_counts=True)
    return np.isin(both, kinds[counts == 1]), found.t


def _on_curves(run: Trajectory, found: Any) -> tuple[Any, Array]:
    if run.problem.q0.size != 2 or not len(found):
        return slice(None), found.t
    across = np.array([-found.q[0, 1], found.q[0, 0]])
    return slice(None), _on_curve(run, across, found.t)


V36 = scalars(
    "V36",
    "Events are all found, once each, at times of the steps' order",
    measure,
    _checks,
    source="no claim of H or M",
    setup="Polynomials(s) with Gauss s, equal steps",
    reference="elliptic integral K, in 80 digits",
    statement="Ours: every root of a function on the curves of a run is found, and refined by one "
    "shortened step, so that its time has the order 2 s of the steps, not s + 1 of the curves.",
    caught=(
        Fault("a root lost at a step's end", {ENDS}, wrong=_changed(_without_ends)),
        Fault("nearly double roots lost", {PAIRS}, wrong=_changed(_without_pairs)),
        Fault(
            "times of the curve's order only",
            {f"{ORDER}, {stages} stages" for stages in STAGES},
            wrong=_changed(_on_curves),
        ),
    ),
)  # fmt: skip
