"""L9: the 3D pendulum from upside down, in steps that near the chart's limit (H 3.8 and 3.9)."""

from __future__ import annotations

from benchmarks.claims.kit import *
from benchmarks.claims.lie_groups.pendulum_motion import BODY, TRUTH
from benchmarks.claims.lie_groups.steps_near_the_limit import (
    CHANGE,
    COUNT,
    LOOSE,
    STEP,
    TURN,
    N,
    largest_change,
    law,
    least_growth,
    least_unsolved,
    single_steps,
    upside_down,
)
from benchmarks.measures.errors import PER_STEP, curve_times, energy_errors
from benchmarks.measures.rigid_invariants import turns
from galvi.charts import CHARTS
from references.scipy.ivp import TIGHT
from references.scipy.rigid_ivp import RIGID_DOP853

STEPS = 200  # H gives no number
WIDE = tuple(chart for chart in CHARTS if chart.limit > CAYLEY.limit)
HELD, LIGHT, HEAVY = (21.0, 22.0, 23.0), 9.81, 29.43
DRAWN = 22.0  # in the figures
WEIGHTS = (5.0, 8.0, LIGHT, 12.0, 15.0, 18.0, 20.0, *HELD, *(float(w) for w in range(24, 31)))
QUICK_WEIGHTS = (LIGHT, 20.0, *HELD, 24.0, 26.0, 30.0)
ENERGY, DONE = "energy error", "steps done"
CURVE, ENDS = "centre of mass on the curve", "centre of mass at step ends"
SHOWN = 50  # steps whose curve is kept
NEAR = 0.9 * np.pi  # "almost through an angle of pi": within a tenth of it
SMALL = 1e-3  # of the energy: 1 pixel in a picture of 1,000 that shows the energy from 0
ROUND_OFF = 1e-12
METHOD = (
    f"Polynomials(n - 1), gauss(n) (H states no number of points), n = {N}, %s chart; h = {STEP:g}"
)
START = f"{BODY}; R0 = diag(-1, 1, -1), body velocity (0.5, -0.5, 0.4)"
SCAN = f"m g from {min(WEIGHTS):g} to {max(WEIGHTS):g} (H gives none)"
ITERATED = f"iterated to changes of {LOOSE['tolerance']:g} (H states no tolerance)"
SINGLE = (
    f"{START}; {METHOD % '%s'}; {COUNT} single steps each from states of DOP853, m g from 20 to 30"
)
NEAR_PI = "some of the steps are almost through an angle of length pi"
JUMPS = "the large jumps in error are associated with steps that almost exceed the conditioning"
SECOND = "DOP853 on quaternions, compiled; SciPy's agrees to 1e-8"
HOLDS_FOR = (
    "H gives no m g. Of those scanned, 21 to 24 do all steps and have some within a tenth of pi; "
    "below, steps turn by less; from 26 on a step leaves the chart. Ten starts 1e-14 away, "
    "tolerances of 1e-8 and 1e-10, and 24 or 40 Gauss points give the same for 21 to 23."
)


def named(weight: float, chart: str) -> str:
    """The study of a run."""
    return f"m g = {weight:g}, {chart} chart"


def study(make_method: MakeMethod, quick: bool, report: Report) -> DataFrame:
    """Series of `named` runs, up to where each ends:

    'energy error'    relative, in time
    'turn in a step'  angle between the step's two ends, rad, in time
    'steps done'      with the status
    'centre of mass on the curve', '... at step ends'  its place, in time, of the first 50 steps

    and the single steps of `steps_near_the_limit`.
    """
    found = []
    for weight in QUICK_WEIGHTS if quick else WEIGHTS:
        report(named(weight, CAYLEY.name))
        found += _run(make_method, weight, CAYLEY)
    for chart in CHARTS:
        report(named(HEAVY, chart.name))
        found += _run(make_method, HEAVY, chart)
    report("single steps")
    found += single_steps(make_method, quick)
    report(ORACLES)
    start, duration, samples = upside_down(DRAWN), STEP * COUNT, {"samples": COUNT}
    second = RIGID_DOP853.run(start, duration, {**samples, **TIGHT})
    away = float(np.max(np.abs(TRUTH.run(start, duration, samples).q - second.q)))
    return frame([*found, row(study=ORACLES, quantity=ORACLES, value=away)])


def _run(make_method: MakeMethod, weight: float, chart: Any) -> list[dict[str, Any]]:
    loose = LOOSE if chart == CAYLEY and weight != LIGHT else {}
    run: Trajectory = galvi.integrate(
        upside_down(weight), method_on_group(make_method, N, chart), STEP, STEPS, **loose
    )
    done = int(np.sum(np.isfinite(run.p[:, 0]))) - 1
    where = {"study": named(weight, chart.name), "label": chart.name, "n": N, "step": STEP,
             "status": failure(run)}  # fmt: skip
    t, q, shown = run.t[: done + 1], run.q[: done + 1], min(done, SHOWN)
    fine = curve_times(run)[: shown * PER_STEP + 1]
    return [
        row(quantity=DONE, value=float(done), **where),
        *history(ENERGY, t, energy_errors(run)[: done + 1], **where),
        *history(TURN, t[1:], turns(q[:-1], q[1:]), **where),
        *history(ENDS, t[: shown + 1], q[: shown + 1, :, 2], **where),
        *(history(CURVE, fine, run(fine)[:, :, 2], **where) if shown else ()),
    ]


def judge(table: DataFrame) -> list[Row]:
    """H's statements for the weights for which they hold; the scan; what nearing the limit costs;
    other charts."""
    return [
        *(row for weight in HELD for row in _held(table, weight)),
        *_scan(table),
        *_single(table),
        *(row for chart in WIDE for row in _beyond(table, chart.name)),
        L9.row(
            ORACLES,
            Finding(AtMost(1e-7)),
            number(table, quantity=ORACLES),
            setup=f"{START}, m g = {DRAWN:g}; to t = {STEP * COUNT:g}",
            claimed="no claim: check of the reference",
            reason="A tenth of the least distance of polynomials, 1e-6, on which a row rests.",
            reference=SECOND,
        ),
    ]


def _held(table: DataFrame, weight: float) -> list[Row]:
    """What H says of figures 3.8 and 3.9, for one m g."""
    run = (weight, CAYLEY.name)
    return [
        _row(table, run, DONE, AtLeast(STEPS), claimed="a run with very aggressive time steps"),
        _row(table, run, f"largest {TURN} [rad]", Within(NEAR, np.pi), claimed=NEAR_PI),
        _row(table, run, f"largest {ENERGY}", AtMost(SMALL)),
        L9.row(
            f"share of the energy's jumps in steps beyond {NEAR:.3g} rad, {named(*run)}",
            Above(0.5),
            _share(table, run),
            source="H fig. 3.9",
            setup=_setup(run),
            claimed=JUMPS,
            reason=f"{HOLDS_FOR} The few such steps have most of the sum of all jumps: the nearer "
            "to pi, the worse polynomials approximate 2 tan(angle / 2).",
        ),
    ]


def _scan(table: DataFrame) -> list[Row]:
    """Where H's statements hold in m g, and two values for which they do not."""
    light, heavy = (LIGHT, CAYLEY.name), (HEAVY, CAYLEY.name)
    range_ = {"setup": _setup((float("nan"), CAYLEY.name)), "claimed": "not in H: it gives no m g"}
    lightest, heaviest = _range(table)
    return [
        L9.row(
            f"least m g of the scan with a step beyond {NEAR:.3g} rad",
            Finding(),
            lightest,
            **{**range_, "reason": "Steps of a lighter body turn by less: H's figure is of one as "
               "heavy as this or heavier."},
        ),
        L9.row(
            f"largest m g of the scan whose run does {STEPS} steps",
            Finding(),
            heaviest,
            **{**range_, "reason": "A heavier body soon makes a step of pi or more, which Cayley's "
               "chart cannot hold: H's figure is of one no heavier, or of fewer steps."},
        ),
        _row(
            table, light, f"largest {ENERGY}", Finding(AtMost(ROUND_OFF)),
            reason="No step comes near the limit: 20 basis functions resolve it to round-off.",
        ),
        _row(
            table, light, f"largest {TURN} [rad]", Finding(Below(NEAR)),
            claimed="not in H: it gives no m g",
            reason="This weight turns the body by little more than 2 in a step: H's figure is of a "
            "larger m g.",
        ),
        _row(
            table, heavy, DONE, Finding(Below(STEPS)),
            claimed="not in H: it gives no m g",
            reason="Three times 9.81: the exact motion turns by more than pi in a step, which has "
            "no coordinates in Cayley's chart.",
        ),
    ]  # fmt: skip


def _single(table: DataFrame) -> list[Row]:
    """How the energy's change grows with the turn of a step."""
    texts = {"source": "H fig. 3.9", "setup": SINGLE % CAYLEY.name}
    name = CAYLEY.name
    return [
        L9.row(
            f"least growth of the median {CHANGE} from 0.1 rad to the next, 2.6 to 3.1, {name}",
            Above(1.0),
            least_growth(table, name),
            claimed=JUMPS,
            reason="xi = 2 tan(angle / 2) has its pole at pi. In a steady turn by the angle a it "
            "is x = 2 pi / a - 1 half steps from the middle of the step, and the step's error is "
            "of size r^(-2 (n - 1)), r = x + sqrt(x^2 - 1) (Bernstein's ellipse): 40 to 400 times "
            "larger 0.1 rad on. Turns that are not steady scatter about it.",
            reference=SECOND,
            **texts,
        ),
        L9.row(
            f"power of the distance of polynomials with which the {CHANGE} grows, {name}",
            Finding(Near(2.0, 0.25, uncertainty=0.0)),
            law(table, name),
            claimed="not in H",
            reason="The step makes the action stationary, so its error is of the square of that "
            "of the best polynomial, as in the theory of both papers' step ends.",
            reference=SECOND,
            **texts,
        ),
        L9.row(
            f"least turn of a single step that is not solved [rad], {name}",
            Finding(Within(NEAR, np.pi)),
            least_unsolved(table, name),
            claimed="pi is the limit of the conditioning of the natural chart",
            reason="At 3.1 rad the pole is 1.03 half steps from the middle, and the best "
            "polynomial of degree 19 is off by 1.2 %: Newton's method finds no solution near the "
            "motion.",
            reference=SECOND,
            **texts,
        ),
    ]


def _beyond(table: DataFrame, chart: str) -> list[Row]:
    """A chart whose limit is a whole turn."""
    wide = (HEAVY, chart)
    return [
        _row(table, wide, DONE, Finding(AtLeast(STEPS)), claimed="not in H",
             reason=f"The {chart} chart goes on where Cayley's ends."),
        _row(table, wide, f"largest {ENERGY}", Finding(AtMost(ROUND_OFF)), claimed="not in H",
             reason="For this chart half a turn is far from the limit, 2 pi: no jumps."),
        L9.row(
            f"largest {CHANGE} that turns by more than {NEAR:.3g} rad, {chart}",
            Finding(AtMost(ROUND_OFF)),
            largest_change(table, chart, NEAR),
            setup=SINGLE % chart,
            claimed="not in H",
            reason=f"Nothing happens to the {chart} chart at half a turn: round-off alone.",
        ),
    ]  # fmt: skip


def _setup(run: tuple[float, str]) -> str:
    weight, chart = run
    tight = weight == LIGHT or chart != CAYLEY.name
    scanned = SCAN if np.isnan(weight) else f"m g = {weight:g}, of {SCAN}"
    solved = "iterated to round-off" if tight else ITERATED
    return f"{START}; {scanned}; {METHOD % chart}, {STEPS} steps, {solved}"


def _row(table: DataFrame, run: tuple[float, str], quantity: str, bound: Bound, **own: str) -> Row:
    """Of the run with this weight and chart."""
    measured: Measurement
    if quantity == DONE:
        measured = number(table, study=named(*run), quantity=DONE)
    else:
        name = TURN if TURN in quantity else ENERGY
        measured = readings.largest(abs(readings.values(table, study=named(*run), quantity=name)))
    texts = {
        "setup": _setup(run),
        "claimed": "the energy of the system is nearly conserved",
        "reason": HOLDS_FOR,
        **own,
    }
    if ENERGY not in quantity:
        texts = {"source": "H fig. 3.8", "reference": "angle between the ends of a step", **texts}
    return L9.row(f"{quantity}, {named(*run)}", bound, measured, **texts)


def _share(table: DataFrame, run: tuple[float, str]) -> float:
    """The share of sum |change of energy| of steps that turn by more than NEAR."""
    where = {"study": named(*run)}
    changes = abs(np.diff(readings.values(table, "t", quantity=ENERGY, **where)))
    turned = readings.values(table, "t", quantity=TURN, **where)
    total = float(np.sum(changes))
    return float(np.sum(changes[turned > NEAR])) / total if total > 0.0 else float("nan")


def _range(table: DataFrame) -> tuple[float, float]:
    """The least m g with a step beyond NEAR, and the largest whose run does all steps."""
    lightest, heaviest = float("nan"), float("nan")
    for weight in sorted(WEIGHTS):
        where = {"study": named(weight, CAYLEY.name)}
        if number(table, quantity=DONE, **where) == STEPS:
            heaviest = weight
        turned = readings.values(table, quantity=TURN, **where)
        if np.isnan(lightest) and len(turned) and np.max(turned) > NEAR:
            lightest = weight
    return lightest, heaviest


L9 = Claim(
    "L9",
    "3D pendulum from upside down: energy, and steps near the chart's limit",
    study,
    judge,
    ("H fig. 3.8", "H fig. 3.9"),
    source="H fig. 3.9",
    reference="initial energy, exact",
    statement="H fig. 3.8, 3.9: in steps that nearly turn by pi the energy is nearly conserved, "
    "and its jumps come with these steps. H prints no m g; a scan finds this for 21 to 23.",
    caught=(
        of_table(
            "largest energy error, m g = 9.81, Cayley chart",
            b=1.0 + 1e-9,
            wrong={
                f"{__name__}.QUICK_WEIGHTS": always((LIGHT,)),
                f"{__name__}.CHARTS": always(()),
                f"{__name__}.single_steps": always(lambda *given: []),
            },
        ),
        Fault(
            "steps in the other chart, which do not jump",
            some("growth of the median change of energy"),
            lambda space, rule, chart=None: galvi.Galerkin(space, rule, galvi.Exponential()),
            wrong={f"{__name__}.{name}": always(()) for name in ("QUICK_WEIGHTS", "CHARTS")},
        ),
    ),
)
