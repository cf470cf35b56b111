"""V11: the solar system by explicit, implicit and symplectic Euler (H figure 1.1)."""

from __future__ import annotations

from typing import Any

import numpy as np
import pandas as pd

import galvi
from benchmarks.checks.bounds import AtLeast, AtMost, Exactly, Order, Within
from benchmarks.checks.claim import Claim, MakeMethod, Report, Row
from benchmarks.measures.errors import energy_errors
from benchmarks.statistics import readings
from benchmarks.store.frames import failure, frame, history, number, row
from galvi import Problem, Trajectory
from references.contender import Contender
from references.rebound import ias15
from references.textbook.euler import EXPLICIT_EULER, SYMPLECTIC_EULER
from references.textbook.implicit_euler import IMPLICIT_EULER

DAYS = 365.25  # in a year
YEARS, STEP = 20.0, 0.005  # H gives h without a unit: read as years
STEPS = round(YEARS / STEP)
EVERY = 2  # steps between saved states
INNER = ("Mercury", "Venus", "Earth", "Mars")
ESCAPING = INNER[:3]  # H's caption
REFINED, HALVINGS = 0.02, 7  # years; h = 0.005 / 2^k
ORDER, AT_END, STOP = "position error", "distance to the Sun at the end", "solve stops converging"
ENERGY, RISES, FALLS = "energy error", "share of steps with rising energy", "change of energy"
EXPLICIT, IMPLICIT, SYMPLECTIC = "explicit Euler", "implicit Euler", "symplectic Euler"
BLIND = "implicit Euler, unconverged steps accepted"
FLOOR = 1e-13
SETUP = (
    "Sun and 8 planets; JPL DE421 states of 2000-01-01 (JD 2451544.5 TDB); "
    f"h = {STEP:g} years (H gives no unit), {YEARS:g} years"
)


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


def study(make_method: MakeMethod, quick: bool, report: Report) -> pd.DataFrame:
    """Series, with the method in `study` (au, days, relative for the energy):

    'energy error'     in time, at every completed step
    'position'         from the Sun, the inner planets in `label`, at every second step
    'change of energy' at the last completed step
    'share of steps with rising energy'
    'distance to the Sun at the end'  of each planet, NaN when the run ended early
    'solve stops converging'          end of the step, in years
    'position error'   after 0.02 years, against IAS15, the step halved

    The series of IAS15 holds the true distances of the inner planets at the end.
    """
    system, duration = problem(), YEARS * DAYS
    rows = []
    for label, (contender, options) in methods().items():
        report(label)
        run = contender.run(system, duration, {"step": STEP * DAYS, **options})
        rows += _run(label, run)
        if label != BLIND:
            rows += _refined(label, contender, system)
    report("IAS15")
    truth = ias15.IAS15.run(system, duration, {"samples": 1})
    return frame(rows + _at_end(ias15.IAS15.name, truth))


def _run(label: str, run: Trajectory) -> list[dict[str, Any]]:
    done = np.isfinite(run.q).all(axis=(1, 2))
    t, energy = run.t[done], energy_errors(run)[done]
    found = [
        *history(ENERGY, t, energy, study=label),
        row(study=label, quantity=FALLS, value=energy[-1], status=failure(run)),
        row(study=label, quantity=RISES, value=float(np.mean(np.diff(energy) > 0.0))),
    ]
    if run.failed_step is not None:
        stop = run.failed_step * STEP
        found.append(row(study=label, quantity=STOP, value=stop, status=failure(run)))
    place = (run.q - run.q[:, :1])[done]
    for body in INNER:
        k = run.problem.parameters["bodies"].index(body)
        found += history("position", t[::EVERY], place[::EVERY, k], study=label, label=body)
    return found + _at_end(label, run)


def _at_end(label: str, run: Trajectory) -> list[dict[str, Any]]:
    distance = np.linalg.norm(run.q[-1] - run.q[-1, :1], axis=-1)
    bodies = run.problem.parameters["bodies"]
    return [
        row(study=label, quantity=AT_END, label=body, value=distance[bodies.index(body)])
        for body in INNER
    ]


def _refined(label: str, contender: Contender, system: Problem) -> list[dict[str, Any]]:
    truth = ias15.IAS15.run(system, REFINED * DAYS, {"samples": 1}).q[-1]
    found = []
    for k in range(HALVINGS):
        steps = round(REFINED / STEP) * 2**k
        run = contender.run(system, REFINED * DAYS, {"step": REFINED * DAYS / steps})
        error = float(np.max(np.linalg.norm(run.q[-1] - truth, axis=-1)))
        where = {"step": REFINED / steps, "steps": steps, "status": failure(run)}
        found.append(row(study=label, quantity=ORDER, value=error, **where))
    return found


def judge(table: pd.DataFrame) -> list[Row]:
    """The energy of each method, the end of the implicit one, and the orders of all three."""
    final = {name: number(table, study=name, quantity=FALLS) for name in (EXPLICIT, IMPLICIT)}
    rising = {name: number(table, study=name, quantity=RISES) for name in (EXPLICIT, IMPLICIT)}
    stays = readings.largest(abs(readings.values(table, study=SYMPLECTIC, quantity=ENERGY)))
    escaped = [number(table, study=BLIND, quantity=AT_END, label=body) for body in ESCAPING]
    outward = {
        "claimed": "energy rises",
        "reason": "Each step ends outside the tangent circle: the planets gain energy and spiral "
        "out.",
    }
    inward = {
        "claimed": "energy falls",
        "reason": "The mirror image of the explicit method: the planets lose energy and spiral in, "
        "Mercury to where one step no longer resolves its orbit.",
    }
    return [
        V11.row(
            "energy at the end, relative change, explicit Euler",
            Within(0.03, 0.12),
            final[EXPLICIT],
            **outward,
        ),
        V11.row(
            "share of steps in which the energy rises, explicit Euler",
            Exactly(1.0),
            rising[EXPLICIT],
            **outward,
        ),
        V11.row(
            "largest relative energy error, symplectic Euler",
            AtMost(3e-4),
            stays,
            claimed="energy stays",
            reason="It conserves a modified energy, which differs from the energy by O(h).",
        ),
        V11.row(
            "energy before the solve stops, relative change, implicit Euler",
            Within(-0.02, -1e-3),
            final[IMPLICIT],
            **inward,
        ),
        V11.row(
            "share of steps in which the energy rises, implicit Euler",
            Exactly(0.0),
            rising[IMPLICIT],
            **inward,
        ),
        V11.row(
            "time at which the solve stops converging [years], implicit Euler",
            Within(0.05, 0.15),
            number(table, study=IMPLICIT, quantity=STOP),
            claimed="energy falls; Mercury, Venus and Earth escape",
            reason="Near the Sun the equations of a step have no solution close by. This is as far "
            "as implicit Euler goes; H does not mention it.",
            reference="convergence of Newton's method",
        ),
        V11.row(
            "nearest of Mercury, Venus and Earth to the Sun at the end [au], implicit Euler with "
            "unconverged steps accepted",
            AtLeast(50.0),
            float(np.min(escaped)),
            claimed="Mercury, Venus and Earth escape",
            reason="Newton's last iterates throw Mercury past the others, which it scatters; the "
            "escapes of H's caption are of the solver and not of implicit Euler. How far they get "
            "depends on rounding; Mars escapes here too.",
            reference=ias15.IAS15.name,
        ),
        *(
            V11.row(
                f"order of the position error after {REFINED:g} years, {label}",
                Order(1.0),
                readings.order(table, FLOOR, study=label, quantity=ORDER),
                claimed="all three are O(h)",
                reason="What is compared are the methods, not mistakes in them.",
                reference=ias15.IAS15.name,
            )
            for label in (EXPLICIT, IMPLICIT, SYMPLECTIC)
        ),
    ]


V11 = Claim(
    "V11",
    "Solar system by three Euler methods: energy rises, falls, stays",
    study,
    judge,
    ("H fig. 1.1",),
    setup=SETUP,
    reference="initial energy",
)
