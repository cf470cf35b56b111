"""Forces under integrators, by the secular rates of a planet's orbit."""

from __future__ import annotations

import warnings
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from functools import cache
from typing import Any

import numpy as np
import pandas as pd

import galvi
from benchmarks.checks.claim import Report
from galvi.arrays import Array
from references.contender import EngineMissing, missing_engine
from references.heyoka.engine import QUADRUPLE
from references.heyoka.taylor import HEYOKA_QUADRUPLE
from references.rebound import extras

COLUMNS = (
    "force",
    "eccentricity",
    "contender",
    "verdict",
    "steps",
    "error",
    "error_quarter",
    "bound",
    "status",
    "versions",
)
ORBITS = 20
MASS, NODE, ARGUMENT, TILT = 1e-6, 0.5, 0.7, 0.3
MU = 1.0 + MASS
PERIOD = 2.0 * np.pi / np.sqrt(MU)
C, J2, RADIUS, STRENGTH, BETA, SLOWING = 300.0, 1e-3, 0.1, 1e-5, 1e-3, 1e-5
K2, OWN_RADIUS, LAG = 0.3, 6e-3, 0.1  # of the planet
FIRST_ORDER_FACTOR = 10.0  # bound of the difference from first order, over the size of the force
STEP_RATIO = 4
SECOND_ORDER = 1.7  # least order that counts as a fall with the square of the step
RIGHT_VERDICT, RIGHT_FOR_SHORT_STEPS, WRONG, REFUSED, ABSENT = (
    "right",
    "right for short steps",
    "wrong",
    "refused",
    "not here",
)
GALVI, THEORY, NO_KICK, WRONG_SIGN, FRAME, CLOCK = (
    "galvi degree 8, Gauss 8",
    "theory, first order",
    "galvi, kick left out",
    "galvi, sign changed",
    "galvi, Kepler frame",
    "galvi, clock",
)
IN_FRAME, IN_CLOCK = {"chart": galvi.KeplerFrame()}, {"clock": galvi.DynamicalTime()}
ONE_STEP_LENGTH_NOTE = (
    "At one length of the step, since steps with a force of velocity are in plain Python."
)
REBOUND = ("ias15", "bs", "whfast", "whfast512", "saba", "leapfrog", "mercurius", "trace")
SETTINGS: Mapping[float, tuple[int, int, int]] = {  # e: samples, REBOUND's steps, galvi's, an orbit
    0.2: (20, 40, 16),
    0.9: (80, 80, 200),
}
EXPLANATION = (
    "A planet of 1e-6 of its star's mass with one force, started at apocentre, 0.3 from the "
    "equator: rates of the orbit's mean elements (ln a, e, node and argument of pericentre, means "
    "over each of 20 orbits) under galvi, and under REBOUND's integrators with "
    "REBOUNDx's forces less their rates without the force. The error is that of the worst rate "
    "over the largest one, against heyoka in quadruple precision, whose run is itself held to the "
    f"formulas of first order by the bound: {FIRST_ORDER_FACTOR:g} times the largest rate over the "
    "mean motion, the size of what the first order, and one post-Newtonian form against another, "
    "leave out. "
    "Right is within the bound at 40 steps an orbit (80 at e = 0.9; galvi: 16 and 200) and at four "
    "times as many; right for short steps is within it at the second, or falling as the square of "
    "the step; anything else is wrong. Steps are not of equal cost: this is about right and "
    "wrong, not about speed. REBOUND's integrators are at their defaults. galvi runs in the "
    "inertial frame, in a KeplerFrame, which refuses forces of velocity, and with "
    "clock=DynamicalTime(), 16 steps an orbit at both eccentricities, with forces of velocity at "
    "this length alone. Planted in galvi's runs "
    "are a force of the other sign and a force that never acts. That TRACE misapplies "
    "forces where it switches at a pericentre is reported as hannorein/rebound#833."
)
REFUSALS = ValueError, RuntimeError, AttributeError  # of REBOUND and REBOUNDx
Formula = Callable[[float, float, float], tuple[float, float, float, float]]


@dataclass(frozen=True)
class Case:
    """A force, as galvi's and as REBOUNDx's.

    Attributes
    ----------
    rates
        (a, e, i) of mean elements -> rates of ln a, e, node and argument, to first order
    parameters
        parameters of REBOUNDx's force; `of_bodies` has those of its bodies
    sign_changed
        galvi's force with the sign changed; None where its sign cannot be changed
    pull
        attraction of the star at rest, as a fraction of gravity, for the osculating elements
    """

    force: Any
    name: str
    rates: Formula
    parameters: Mapping[str, Any] = field(default_factory=dict)
    of_bodies: Mapping[int, Mapping[str, Any]] = field(default_factory=dict)
    sign_changed: Any = None
    pull: float = 1.0
    eccentricities: tuple[float, ...] = (0.2,)


def motion(a: float) -> float:
    """The mean motion n of a mean semi-major axis."""
    return float(np.sqrt(MU / a**3))


def oblate(a: float, e: float, i: float) -> tuple[float, float, float, float]:
    """Node -3/2 n J2 (R / p)^2 cos i, argument 3/4 n J2 (R / p)^2 (5 cos^2 i - 1)."""
    size = motion(a) * J2 * (RADIUS / (a * (1.0 - e * e))) ** 2
    return 0.0, 0.0, -1.5 * size * np.cos(i), 0.75 * size * (5.0 * np.cos(i) ** 2 - 1.0)


def relativistic(a: float, e: float, i: float) -> tuple[float, float, float, float]:
    """Argument 6 pi G M / (c^2 p) an orbit, M of both."""
    return 0.0, 0.0, 0.0, 3.0 * motion(a) * MU / (C * C * a * (1.0 - e * e))


def inverse_fourth(a: float, e: float, i: float) -> tuple[float, float, float, float]:
    """Of an attraction A / r^4: argument A / (n a^5 (1 - e^2)^2), by Lagrange's equations."""
    return 0.0, 0.0, 0.0, STRENGTH * MU / (motion(a) * a**5 * (1.0 - e * e) ** 2)


def radiated(a: float, e: float, i: float) -> tuple[float, float, float, float]:
    """Poynting-Robertson drag (Wyatt and Whipple, Astrophys. J. 111 (1950) 134)."""
    size, left = BETA / (C * a * a), 1.0 - e * e
    return -size * (2.0 + 3.0 * e * e) / left**1.5, -2.5 * size * e / left**0.5, 0.0, 0.0


def dragged(a: float, e: float, i: float) -> tuple[float, float, float, float]:
    """Of -k v: energy and angular momentum fall as exp(-2kt) and exp(-kt)."""
    return -2.0 * SLOWING, 0.0, 0.0, 0.0


def tidal(a: float, e: float, i: float) -> tuple[float, float, float, float]:
    """Hut (1981), eqs. 9 and 10, without spin; the bulge at rest turns the pericentre."""
    x, left = e * e, 1.0 - e * e
    size = K2 * MU / MASS * OWN_RADIUS**5 / a**8  # 3 size: of the force, at a
    f1 = 1.0 + 31.0 / 2.0 * x + 255.0 / 8.0 * x**2 + 185.0 / 16.0 * x**3 + 25.0 / 64.0 * x**4
    f3 = 1.0 + 15.0 / 4.0 * x + 15.0 / 8.0 * x**2 + 5.0 / 64.0 * x**3
    turn = 7.5 * size / motion(a) * (1.0 + 1.5 * x + x * x / 8.0) / left**5
    return -6.0 * LAG * size * f1 / left**7.5, -27.0 * LAG * size * e * f3 / left**6.5, 0.0, turn


def _oblate(J2: float) -> Any:
    return galvi.Oblateness(0, J2, RADIUS)


CASES: Mapping[str, Case] = {
    "J2": Case(_oblate(J2), "gravitational_harmonics", oblate, {}, {0: {"J2": J2, "R_eq": RADIUS}},
               _oblate(-J2), eccentricities=(0.2, 0.9)),
    "attraction as r^-4": Case(
        galvi.PowerLaw(0, -STRENGTH, -4.0), "central_force", inverse_fourth, {},
        {0: {"Acentral": -STRENGTH, "gammacentral": -4.0}}, galvi.PowerLaw(0, STRENGTH, -4.0),
    ),
    "relativity, potential": Case(galvi.Relativity(C, form="potential"), "gr_potential",
                                  relativistic, {"c": C}, eccentricities=(0.2, 0.9)),
    "relativity, one source": Case(galvi.Relativity(C), "gr", relativistic, {"c": C},
                                   eccentricities=(0.2, 0.9)),
    "relativity, EIH": Case(galvi.Relativity(C, form="EIH"), "gr_full", relativistic, {"c": C}),
    "radiation": Case(galvi.Radiation([0.0, BETA], C), "radiation_forces", radiated, {"c": C},
                      {0: {"radiation_source": 1}, 1: {"beta": BETA}}, pull=1.0 - BETA),
    "drag": Case(galvi.Drag([0.0, SLOWING]), "modify_orbits_forces", dragged, {},
                 {1: {"tau_a": -0.5 / SLOWING}}),
    "tides": Case(galvi.Tides(1, K2, OWN_RADIUS, LAG), "tides_constant_time_lag", tidal, {},
                  {1: {"r": OWN_RADIUS, "tctl_k2": K2, "tctl_tau": LAG}},
                  eccentricities=(0.2,)),
}  # fmt: skip


QUICK_FORCES = ("J2", "relativity, one source")


def problem(e: float, forces: Any = ()) -> galvi.Problem:
    """The star and its planet at apocentre."""
    distance, speed = 1.0 + e, np.sqrt(MU * (1.0 - e) / (1.0 + e))
    turn = _about(2, NODE) @ _about(0, TILT) @ _about(2, ARGUMENT)
    x, v = turn @ [-distance, 0.0, 0.0], turn @ [0.0, -speed, 0.0]
    fractions = np.array([[-MASS / MU], [1.0 / MU]])
    return galvi.Problem(galvi.NBody([1.0, MASS], forces=forces), fractions * x, fractions * v)


def _about(axis: int, angle: float) -> Array:
    c, s = np.cos(angle), np.sin(angle)
    i, j = [k for k in range(3) if k != axis]
    matrix = np.eye(3)
    matrix[i, i] = matrix[j, j] = c
    matrix[i, j], matrix[j, i] = -s, s
    return matrix


def mean_elements(q: Array, v: Array, samples: int, pull: float = 1.0) -> Array:
    """(orbits, 5) of ln a, e, node, argument and inclination from states (n, 2, 3)."""
    mu = MU * pull
    x, w = q[:, 1] - q[:, 0], v[:, 1] - v[:, 0]
    r, h = np.linalg.norm(x, axis=1), np.cross(x, w)
    node = np.unwrap(np.arctan2(h[:, 0], -h[:, 1]))
    vector = np.cross(w, h) / mu - x / r[:, None]
    n = np.stack([np.cos(node), np.sin(node), 0.0 * node], axis=1)
    unit = h / np.linalg.norm(h, axis=1)[:, None]
    along, across = np.sum(vector * n, axis=1), np.sum(vector * np.cross(unit, n), axis=1)
    a = 1.0 / (2.0 / r - np.sum(w * w, axis=1) / mu)
    a[a < 0.0] = np.nan  # not bound
    elements = [
        np.log(a),
        np.hypot(along, across),
        node,
        np.unwrap(np.arctan2(across, along)),
        np.arccos(unit[:, 2]),
    ]
    return np.array(elements)[:, :-1].reshape(5, -1, samples).mean(axis=2).T


def slopes(means: Array) -> Array:
    """The rates (4,) of ln a, e, node and argument, by least squares over the orbits."""
    return np.polyfit(PERIOD * np.arange(len(means)), means[:, :4], 1)[0]


@dataclass(frozen=True)
class Orbit:
    """A case at an eccentricity."""

    case: Case
    e: float

    @property
    def times(self) -> Array:
        """Times of the samples, (orbits samples + 1,)."""
        samples = SETTINGS[self.e][0]
        return PERIOD * np.arange(ORBITS * samples + 1) / samples

    def rates(self, q: Array, v: Array) -> Array:
        """Rates of the mean elements of states at the times."""
        return slopes(mean_elements(q, v, SETTINGS[self.e][0], self.case.pull))

    def truth(self) -> tuple[Array, Array]:
        """Rates, and those of theory at the mean elements, by a run in quadruple precision."""
        start = problem(self.e, self.case.force)
        states = HEYOKA_QUADRUPLE.states(start, self.times, QUADRUPLE)[0]
        rows = states.astype(np.float64).reshape(len(self.times), 2, 2, 3)
        means = mean_elements(rows[:, :, 0], rows[:, :, 1], SETTINGS[self.e][0], self.case.pull)
        middle = means.mean(axis=0)
        theory = self.case.rates(float(np.exp(middle[0])), float(middle[1]), float(middle[4]))
        return slopes(means), np.array(theory)

    def by_galvi(
        self, force: Any, finer: int, options: Mapping[str, Any], steps: int | None = None
    ) -> Array:
        """The rates of galvi's run with a force, and with the frame or clock in `options`.

        Parameters
        ----------
        steps
            steps in an orbit; None: those of galvi in ``SETTINGS``
        """
        method = galvi.Galerkin(galvi.Polynomials(8), galvi.gauss(8), **options)
        steps = steps or SETTINGS[self.e][2]
        step, start = PERIOD / (steps * finer), problem(self.e, force)
        run = galvi.integrate(start, method, step, duration=ORBITS * PERIOD)
        if not run.success:
            return np.full(4, np.nan)
        q, p = galvi.states_at(run, self.times)
        return self.rates(q, p / start.system.masses[:, None])

    def by_rebound(self, integrator: str, finer: int) -> Array:
        """The rates with REBOUNDx's force less those without, which are the integrator's own."""
        case, dt = self.case, PERIOD / (SETTINGS[self.e][1] * finer)
        q, v = extras.states(
            problem(self.e), integrator, dt, self.times, case.name, case.parameters, case.of_bodies
        )
        return self.rates(q, v) - self.rates(*_without(self.e, integrator, dt))


@cache
def _without(e: float, integrator: str, dt: float) -> tuple[Array, Array]:
    times = Orbit(CASES["J2"], e).times
    return extras.states(problem(e), integrator, dt, times, "", {}, {})


def forces_table(quick: bool = False, report: Report = lambda sentence: None) -> pd.DataFrame:
    """A row for each force, eccentricity and contender; see COLUMNS.

    quick                 whether only QUICK_FORCES are run, at the first eccentricity
    error, error_quarter  of the worst rate over the largest one, and that with a quarter of the
                          step; nan without steps of a length
    Raises ModuleNotFoundError without heyoka in quadruple precision.
    """
    if HEYOKA_QUADRUPLE.missing:
        raise EngineMissing(HEYOKA_QUADRUPLE.missing, name=missing_engine(HEYOKA_QUADRUPLE))
    rows = []
    for name, case in CASES.items():
        for e in (
            case.eccentricities[: 1 if quick else None] if name in QUICK_FORCES or not quick else ()
        ):
            report(f"{name}, e = {e:g}")
            for row in rows_of(Orbit(case, e)):
                rows.append({"force": name, "eccentricity": e, **row})
    return pd.DataFrame(rows, columns=list(COLUMNS))


def verdict(errors: Array, bound: float) -> str:
    """The verdict on an error, or on that and the one at a quarter of the step; NaN counts as
    wrong."""
    if np.all(errors <= bound):
        return RIGHT_VERDICT
    if errors[-1] <= bound or STEP_RATIO**SECOND_ORDER * errors[-1] <= errors[0]:
        return RIGHT_FOR_SHORT_STEPS
    return WRONG


def _first_sentence(text: str) -> str:
    return " ".join(text.split()).partition(". ")[0].rstrip(".") + "."


def rows_of(orbit: Orbit) -> list[dict[str, Any]]:
    """The rows of one force and eccentricity."""
    case, in_clock = orbit.case, SETTINGS[0.2][2]
    _, rebound_steps, galvi_steps = SETTINGS[orbit.e]
    true, theory = orbit.truth()
    largest = float(np.max(np.abs(true)))
    bound = FIRST_ORDER_FACTOR * largest * PERIOD / (2.0 * np.pi)

    def row(
        contender: str,
        steps: int,
        run: Callable[[int], Array],
        refusals: Any = (),
        lengths: tuple[int, ...] = (1, STEP_RATIO),
    ) -> dict[str, Any]:
        columns = {"contender": contender, "steps": steps, "bound": bound}
        with warnings.catch_warnings(record=True) as warned:
            warnings.simplefilter("always")
            try:
                rates = np.array([run(finer) for finer in (lengths if steps else (1,))])
            except refusals as error:
                return {**columns, "verdict": REFUSED, "status": _first_sentence(str(error))}
        remarks = dict.fromkeys(_first_sentence(str(warning.message)) for warning in warned)
        if np.all(np.abs(rates) <= bound * largest):
            remarks["The force does not act."] = None
        if not np.all(np.isfinite(rates)):
            remarks["The planet is lost."] = None
        errors = np.max(np.abs(rates - true), axis=1) / largest
        ends = dict(zip(("error", "error_quarter"), errors, strict=False))
        return {**columns, "verdict": verdict(errors, bound), **ends, "status": " ".join(remarks)}

    def in_time(finer: int) -> Array:
        return orbit.by_galvi(case.force, finer, IN_CLOCK, in_clock)

    rows = [
        row(THEORY, 0, lambda finer: theory),
        row(GALVI, galvi_steps, lambda finer: orbit.by_galvi(case.force, finer, {}))
        | {"versions": f"galvi {galvi.__version__}"},
        row(
            FRAME,
            galvi_steps,
            lambda finer: orbit.by_galvi(case.force, finer, IN_FRAME),
            ValueError,
        ),
        row(CLOCK, in_clock, in_time, lengths=(1,)) | {"status": ONE_STEP_LENGTH_NOTE}
        if case.force.takes_velocity
        else row(CLOCK, in_clock, in_time),
        row(NO_KICK, galvi_steps, lambda finer: orbit.by_galvi((), finer, {})),
    ]
    if case.sign_changed is not None:
        rows.append(
            row(WRONG_SIGN, galvi_steps, lambda finer: orbit.by_galvi(case.sign_changed, finer, {}))
        )
    missing_reason = extras.missing()
    for integrator in REBOUND:
        if missing_reason:
            rows.append(
                {"contender": f"REBOUND {integrator}", "verdict": ABSENT, "status": missing_reason}
            )
            continue
        adaptive = integrator in extras.ADAPTIVE
        line = row(
            f"REBOUND {integrator}",
            0 if adaptive else rebound_steps,
            lambda finer, integrator=integrator: orbit.by_rebound(integrator, finer),
            REFUSALS,
        )
        rows.append(line | {"versions": extras.versions()})
    return rows


SHORT = {
    THEORY: "theory",
    GALVI: "galvi",
    FRAME: FRAME,
    CLOCK: CLOCK,
    NO_KICK: "no kick",
    WRONG_SIGN: "other sign",
}


def matrix(rows: pd.DataFrame) -> pd.DataFrame:
    """A line for each force and eccentricity, a column for each contender: the verdict, with the
    error at a quarter of the step where it is wrong."""

    def cell(row: Any) -> str:
        if row["verdict"] != WRONG:
            return str(row["verdict"])
        last = 100.0 * (row["error_quarter"] if row["steps"] else row["error"])
        return f"wrong by {last:.{0 if last >= 10.0 else 1}f} %"

    lines: dict[tuple[str, float], dict[str, Any]] = {}
    for row in rows.to_dict("records"):
        key = row["force"], row["eccentricity"]
        line = lines.setdefault(key, {"force": key[0], "e": f"{key[1]:g}"})
        contender = str(row["contender"]).removeprefix("REBOUND ")
        line[SHORT.get(contender, contender)] = cell(row)
    table = pd.DataFrame(lines.values())
    ordered = [name for name in SHORT.values() if name in table]
    first = ["force", "e", *ordered]
    return table[[*first, *(name for name in table if name not in first)]].fillna("")


if __name__ == "__main__":
    print(matrix(forces_table(report=print)).to_markdown(index=False))
