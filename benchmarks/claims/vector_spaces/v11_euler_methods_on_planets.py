"""V11: the solar system by explicit, implicit and symplectic Euler (H figure 1.1)."""

from __future__ import annotations

from benchmarks.claims.kit import *
from benchmarks.claims.vector_spaces.euler_energy import explicit_slope
from benchmarks.claims.vector_spaces.euler_readings import (
    BEYOND,
    DAYS,
    ESCAPES,
    HALVED,
    INNER,
    LARGER,
    LARGEST,
    PRINTED,
    READ,
    READ_IN_DAYS,
    RISES,
    SCANNED,
    SMALLER,
    SOLVED,
    STOPPED,
    YEARS,
    bodies,
    energy_of,
    explicit_rows,
    implicit_rows,
    two_body_rows,
)
from benchmarks.measures.errors import energy_errors
from references.contender import Contender
from references.rebound.ias15 import IAS15
from references.scipy.ivp import DOP853, TIGHT
from references.textbook.euler import EXPLICIT_EULER, SYMPLECTIC_EULER
from references.textbook.implicit_euler import IMPLICIT_EULER

STEP = PRINTED  # H gives h without a unit: read as years, other readings are scanned
EVERY = 2  # steps between saved states
ESCAPING = INNER[:3]  # H's caption
REFINED, HALVINGS = 0.02, 7  # years; h = 0.005 / 2^k
SAMPLES = 400  # of the true motion, for an integral over it
ORDER, SECOND = "position error", "energy change beyond first order in h"
ENERGY = "energy error"
EXPLICIT, IMPLICIT, SYMPLECTIC = "explicit Euler", "implicit Euler", "symplectic Euler"
BLIND = "implicit Euler, unconverged steps accepted"
FAR, LATER = "distance to the Sun after 3 years", 3.0
GONE = 10.0  # au
FLOOR = 1e-13
START = "Sun and 8 planets; JPL DE421 states of 2000-01-01 (JD 2451544.5 TDB)"
SETUP = f"{START}; h = {STEP:g} years (H gives no unit), {YEARS:g} years"
READINGS = (
    f"{START}; h = {HALVED[0]:g} to {HALVED[-1]:g} years, which includes {PRINTED:g} years and "
    f"{PRINTED:g} of the unit in which G = 1; {YEARS:g} years"
)
WITH_DAYS = f"{READINGS}; and h = {PRINTED:g} days, 1 year"
UNTIL_STOP = f"{READINGS.removesuffix(f'; {YEARS:g} years')}; to where it stops, within 0.5 years"
TWO_BODIES = (
    "each inner planet about the Sun alone, every step solved in closed form; h = "
    f"{SCANNED[0]:g} to {SCANNED[1]:g} years, {PRINTED:g} years and {PRINTED:g} of the unit in "
    f"which G = 1; {YEARS:g} years"
)
TRUTH = f"{IAS15.name}; {DOP853.name} agrees to 1e-15 au"


def problem() -> Problem:
    """The Sun and eight planets without Pluto, as in H."""
    return galvi.problems.solar_system(pluto=False)


def methods() -> dict[str, tuple[Contender, dict[str, Any]]]:
    """Label -> contender and its setting without the step."""
    return {
        EXPLICIT: (EXPLICIT_EULER, {}),
        IMPLICIT: (IMPLICIT_EULER, {}),
        SYMPLECTIC: (SYMPLECTIC_EULER, {}),
        BLIND: (IMPLICIT_EULER, {"accept_unconverged": True}),
    }


def study(make_method: MakeMethod, quick: bool, report: Report) -> DataFrame:
    """Series, with the method in `study` (au, days, relative for the energy):

    'energy error'     in time, at every completed step
    'position'         from the Sun, the inner planets in `label`, at every second step
    'distance to the Sun after 3 years'  of the inner planets, unconverged steps accepted
    'position error', 'energy change beyond first order in h'
                       after 0.02 years, the step halved, against IAS15's motion
    and those of `explicit_rows`, `implicit_rows` and `two_body_rows` over readings of h.
    """
    system, found = problem(), []
    used = methods()
    for label, (contender, options) in used.items():
        report(label)
        run = contender.run(system, YEARS * DAYS, {"step": STEP * DAYS, **options})
        found += _run(label, run)
        if label != BLIND:
            found += _refined(label, contender, system)
    for label in (EXPLICIT, SYMPLECTIC):
        report(f"{label}, readings of h")
        found += explicit_rows(label, used[label][0], system)
    report(f"{IMPLICIT}, readings of h")
    found += implicit_rows(IMPLICIT, used[IMPLICIT][0], system)
    return frame(found + two_body_rows(system, 20 if quick else 200))


def _run(label: str, run: Trajectory) -> list[dict[str, Any]]:
    done = np.isfinite(run.q).all(axis=(1, 2))
    found = history(ENERGY, run.t[done], energy_errors(run)[done], study=label)
    found[-1]["status"] = failure(run)
    place = (run.q - run.q[:, :1])[done]
    for body in INNER:
        seen = place[:, bodies(run.problem).index(body)]
        found += history("position", run.t[done][::EVERY], seen[::EVERY], study=label, label=body)
        if label == BLIND:  # or at the end of a run that ended before
            far = float(np.linalg.norm(seen[: round(LATER / STEP) + 1][-1]))
            found.append(row(study=label, quantity=FAR, label=body, value=far))
    return found


def _refined(label: str, contender: Contender, system: Problem) -> list[dict[str, Any]]:
    duration, sign = REFINED * DAYS, {EXPLICIT: 1.0, IMPLICIT: -1.0}.get(label)
    truth = IAS15.run(system, duration, {"samples": SAMPLES})
    other = DOP853.run(system, duration, {"samples": 1, **TIGHT})
    apart = float(np.max(np.linalg.norm(truth.q[-1] - other.q[-1], axis=-1)))
    slope = explicit_slope(truth) / abs(energy_of(system))
    found = [row(study=label, quantity=ORACLES, value=apart)]
    for k in range(HALVINGS):
        steps = round(REFINED / STEP) * 2**k
        h = duration / steps
        run = contender.run(system, duration, {"step": h})
        values = {ORDER: np.max(np.linalg.norm(run.q[-1] - truth.q[-1], axis=-1))}
        if sign is not None:
            values[SECOND] = abs(energy_errors(run)[-1] - sign * h * slope)
        where = {"study": label, "step": REFINED / steps, "steps": steps, "status": failure(run)}
        found += [row(quantity=name, value=float(x), **where) for name, x in values.items()]
    return found


def judge(table: DataFrame) -> list[Row]:
    """Energy of each method, the end of the implicit one, its escapes, and the orders."""
    implicit = IMPLICIT + READ
    drifts, rising = (_by_step(table, EXPLICIT, quantity) for quantity in (LARGEST, RISES))
    falling = readings.values(table, study=implicit, quantity=RISES)
    growth = (
        "By its modified equation dE/dt = h/2 sum m (|a|^2 - v.a'v), for a circular orbit h mu^2 / "
        "r^4 > 0, so that r^3 = r0^3 + 6 h mu t"
    )
    decay = f"{growth}; for implicit Euler with the other sign."
    return [
        V11.row(
            "share of steps in which the energy rises, least over h, explicit Euler",
            Exactly(1.0),
            readings.least(rising),
            setup=WITH_DAYS,
            claimed="dramatic energy drift",
            reason=f"{growth}.",
        ),
        V11.row(
            "share of steps in which the energy rises, largest over h, implicit Euler",
            Exactly(0.0),
            readings.largest(falling),
            setup=UNTIL_STOP,
            claimed="dramatic energy drift, decaying orbits",
            reason=decay,
        ),
        *(
            V11.row(
                f"order of the {SECOND}, {label}",
                Finding(Order(2.0)),
                readings.order(table, FLOOR, study=label, quantity=SECOND),
                setup=f"{START}; after {REFINED:g} years, h = {STEP:g} / 2^k years",
                claimed="dramatic energy drift; H gives no rate",
                reason=f"{decay} Were that first-order term another, what is left would be of "
                "order 1.",
                reference=TRUTH,
            )
            for label in (EXPLICIT, IMPLICIT)
        ),
        *_symplectic(table, drifts),
        *_end_of_implicit(table, implicit),
        *(
            V11.row(
                f"order of the position error after {REFINED:g} years, {label}",
                Order(1.0),
                readings.order(table, FLOOR, study=label, quantity=ORDER),
                claimed="all three are O(h)",
                reason="What is compared are the methods, not mistakes in them.",
                reference=TRUTH,
            )
            for label in (EXPLICIT, IMPLICIT, SYMPLECTIC)
        ),
        V11.row(
            f"{ORACLES} after {REFINED:g} years, over the smallest position error",
            Finding(AtMost(0.1)),
            _apart(table),
            claimed="no claim: check of the reference",
            reason="IAS15 and DOP853 are both at round-off.",
            reference=TRUTH,
        ),
    ]


def _symplectic(table: DataFrame, drifts: Array) -> list[Row]:
    """How its energy changes, also beside the changes by explicit Euler, `drifts`."""
    symplectic, stays = SYMPLECTIC + READ, _by_step(table, SYMPLECTIC, LARGEST)
    over = stays / drifts if stays.size == drifts.size else np.array([])
    bounded = "It conserves a modified energy, H + h/2 sum m v.a + O(h^2)."
    stays_text = {"claimed": "approximately conserves energy", "reason": bounded}
    return [
        V11.row(
            f"order of the {LARGEST}, symplectic Euler",
            Order(1.0),
            readings.order(table, FLOOR, study=symplectic, quantity=LARGEST),
            setup=READINGS,
            **stays_text,
        ),
        V11.row(
            f"order of the {BEYOND}, symplectic Euler",
            Finding(Order(2.0)),
            readings.order(table, FLOOR, study=symplectic, quantity=BEYOND),
            setup=READINGS,
            **stays_text,
        ),
        V11.row(
            f"{LARGEST} of symplectic Euler over that of explicit Euler, largest over h",
            AtMost(1.0),
            readings.largest(over),
            setup=WITH_DAYS,
            claimed="same order of accuracy, but approximately conserves energy",
            reason=f"{bounded} Explicit Euler's energy grows with the duration.",
        ),
    ]


def _end_of_implicit(table: DataFrame, implicit: str) -> list[Row]:
    """Where its steps have no solution, and what may be said of the escapes in H's caption."""
    caption = {"claimed": "escape trajectories for Mercury, Venus, and Earth"}
    cubic = (
        "A step needs r + h^2 mu / r^2 = |q + h v|, whose left side is at least "
        "3/2 (2 h^2 mu)^(1/3)"
    )
    closed = {"reference": "closed form of the step"}
    taken = [
        number(table, study=SMALLER, quantity=ESCAPES, label=body, step=PRINTED) for body in INNER
    ]
    far = np.array([number(table, study=BLIND, quantity=FAR, label=body) for body in ESCAPING])
    return [
        V11.row(
            f"{STOPPED}, largest over h, implicit Euler",
            Finding(Below(1.0)),
            readings.largest_of(table, study=implicit, quantity=STOPPED),
            setup=UNTIL_STOP,
            reason=f"{cubic}: below it the step has no solution but next to another planet, and "
            "no solver can go on. H does not mention it.",
            **caption,
            **closed,
        ),
        V11.row(
            f"{SOLVED}, least over h, implicit Euler",
            Finding(AtLeast(1.0)),
            readings.least_of(table, study=implicit, quantity=SOLVED),
            setup=UNTIL_STOP,
            reason=f"{cubic}: where Newton's method converges, a solution exists.",
            **caption,
            **closed,
        ),
        V11.row(
            "share of inner planets and h with energy to escape, larger solution of every step, "
            "implicit Euler",
            Finding(Exactly(0.0)),
            _share(readings.values(table, study=LARGER, quantity=ESCAPES)),
            setup=TWO_BODIES,
            reason="The orbit decays, r^3 = r0^3 - 6 h mu t, to where a step has no solution: with "
            "the solution that tends to the motion as h tends to 0 no planet ever has the energy "
            "to escape.",
            **caption,
            **closed,
        ),
        V11.row(
            "least share of steps whose smaller solution throws the planet out, Mercury, Venus, "
            "Earth and Mars, implicit Euler",
            Finding(AtLeast(0.9)),
            readings.least(np.array(taken)),
            setup=f"{TWO_BODIES.split(';')[0]}; h = {PRINTED:g} years; one of the steps before the "
            "one that has no solution takes its smaller one, each in turn",
            reason="Each step has a second solution next to the Sun, r about (h^2 mu / |q + h v|)^"
            "(1/2). A solver that comes upon it once, at nearly any step, throws any of the "
            "planets out, Mars too, whom H's caption keeps. H prints neither how steps were solved "
            "nor for how long: its escapes cannot be decided.",
            **caption,
            **closed,
        ),
        V11.row(
            f"how many of Mercury, Venus and Earth are beyond {GONE:g} au after {LATER:g} years, "
            "unconverged steps accepted, implicit Euler",
            Finding(),
            float(np.sum(far > GONE)) if np.all(np.isfinite(far)) else float("nan"),
            setup=f"{START}; h = {STEP:g} years",
            reason="States after a step without a solution are Newton's last iterates and not "
            "implicit Euler's: no evidence of an escape, and dependent on rounding. Orbits decay "
            "to that step in 0.09, 0.37, 0.9 and 3.0 years, so that H's three and not Mars are "
            "gone if the run lasted between 0.9 and 3 years.",
            reference="none",
            **caption,
        ),
    ]


def _by_step(table: DataFrame, label: str, quantity: str) -> Array:
    """Over all readings of h."""
    return np.concatenate(
        [
            series(table, "step", study=label + read, quantity=quantity)[1]
            for read in (READ, READ_IN_DAYS)
        ]
    )


def _share(seen: Array) -> float:
    """The mean; NaN when there is nothing."""
    return float(np.mean(seen)) if seen.size else float("nan")


def _apart(table: DataFrame) -> float:
    """The distance of the two truths, over the smallest error measured by them."""
    apart = readings.largest_of(table, quantity=ORACLES)
    return apart / readings.least_of(table, quantity=ORDER)


V11 = Claim(
    "V11",
    "Solar system by three Euler methods: energy rises, falls, stays",
    study,
    judge,
    ("H fig. 1.1",),
    setup=SETUP,
    reference="initial energy",
    statement="H fig. 1.1: the energy drifts by explicit and implicit Euler, and with the latter "
    "the inner planets escape; symplectic Euler, of the same order, approximately conserves it. "
    "Measured: as claimed of the energies. The escapes cannot be decided: they begin where the "
    "equations of a step have no solution near by, and H prints neither solver nor duration.",
    caught=(OTHER_TRUTH,),
)
