"""V25: a brownout cloud of sand of several diameters (M figure 2), by a stated model."""

from __future__ import annotations

from typing import Any

import numpy as np
import pandas as pd

import galvi
from benchmarks.brownout.cloud import BY_REYNOLDS, CONSTANT, DIAMETERS, UNTIL, Cloud
from benchmarks.brownout.emission import LEVEL, friction_speed
from benchmarks.brownout.statistics import DEPTH, HEIGHT, Answers, answers, total
from benchmarks.checks.bounds import AtLeast, AtMost, Exactly, Finding, Order
from benchmarks.checks.claim import Claim, MakeMethod, Report, Row
from benchmarks.statistics import readings
from benchmarks.statistics.estimate import Estimate
from benchmarks.store.frames import frame, history, number, pick, row
from benchmarks.store.frames import rows as rows_of
from galvi.problems.brownout import GRAVITY
from galvi.run.grains.flights import ALOFT, LANDED, Flights, Ground
from references.textbook.grain_flights import landings

STEPS = (192, 288, 384, 576, 768, 1152, 1536)
QUICK_STEPS = (384, 576, 768, 1152)
TRACKED, QUICK_TRACKED = 100, 30  # grains of each size and drag law: 1000 in all
DEGREES = (1, 2)
FIRM = (200e-6, 400e-6)  # m, diameters of grains that relax in more than a step
ERROR, FATES = "median error of the last place [m]", "grains that end elsewhere"
FLOOR = 1e-10  # m
REBOUNDING = Ground(0.5)
SHOWN, MOVING = "picture", "moving picture"  # studies of places in the meridional plane's half
TIMES = (1.5, 3.0, 4.5, 6.0)  # s; M prints no times
FRAMES = 24  # of the moving picture, and as many parts of the time
PICTURED, IN_MOTION = 1000, 100  # grains of a size, other ones for each
SAMPLED, QUICK_SAMPLED = 4000, 600  # of each size, for the statistics
COMPARED = ((1, 48), (1, 96), (1, 192), (1, 384), (2, 48), (2, 96), (2, 192), (4, 48), (4, 96))
FINEST = (4, 768)
QUICK_FINEST = (4, 384)
MILLION = 1e6
HIGHEST, LOST, PUSHED = (
    "highest place, least over sizes [m]",
    "mass not found",
    "momentum not found",
)
ALONE = "numbers of a grain that depend on other grains"
WORK = "evaluations of the wind a grain"
SAMPLING, OF_STEP, GRAINS = "standard error", "error of the step", "super-particles"


def words(diameter: float) -> str:
    """A diameter as text."""
    return f"{diameter * 1e6:g} micrometres"


LABELS = tuple(map(words, DIAMETERS))


def gauss(make_method: MakeMethod, s: int) -> Any:
    """Degree s with s Gauss points."""
    return make_method(galvi.Polynomials(s), galvi.gauss(s))


def study(make_method: MakeMethod, quick: bool, report: Report) -> pd.DataFrame:
    """Paths of grains against DOP853, balances, statistics and places for pictures.

    ERROR and FATES in `study` of a drag law (and CONSTANT and "rebound"), with the size in `label`,
    degree + 1 in `n`; LOST, PUSHED, ALONE, HIGHEST; DEPTH and HEIGHT with their SAMPLING errors and
    OF_STEP, named in `study`; SHOWN and MOVING: x, z and t, with the size in `label`.
    """
    found: list[dict[str, Any]] = []
    for drag in (CONSTANT, BY_REYNOLDS):
        for diameter in DIAMETERS:
            report(f"{drag}, {words(diameter)}")
            found += _paths(make_method, quick, drag, Cloud(diameter, drag))
    report("rebounds")
    found += _paths(make_method, quick, "rebound", Cloud(200e-6, ground=REBOUNDING))
    found += _balances(make_method, quick)
    found += _statistics(make_method, quick, report)
    report("pictures")
    found += _places(make_method)
    return frame(found)


def _paths(make_method: MakeMethod, quick: bool, study: str, cloud: Cloud) -> list[dict[str, Any]]:
    grains = np.arange(QUICK_TRACKED if quick else TRACKED)
    cloud = Cloud(cloud.diameter, cloud.drag, grains, cloud.ground)
    truth = landings(cloud.problem, *cloud.starts(), UNTIL, restitution=cloud.ground.restitution,
                     slowest=cloud.ground.slowest)  # fmt: skip
    found = []
    for s in DEGREES:
        for steps in QUICK_STEPS if quick else STEPS:
            run = cloud.flights(gauss(make_method, s), steps)
            values = {
                ERROR: float(np.median(np.linalg.norm(run.q - truth.q, axis=1))),
                FATES: float(np.sum((run.status == LANDED) != truth.landed)),
            }
            found += rows_of(values, study=study, label=words(cloud.diameter), n=s + 1,
                             step=UNTIL / steps, steps=steps)  # fmt: skip
    return found


def balance(cloud: Cloud, run: Flights) -> tuple[float, float]:
    """The shares of the mass lifted that is neither aloft nor on the ground, and of the impulses of
    drag and ground that the change of momentum and the weight do not account for."""
    _, v0, t0 = cloud.starts()
    mass = cloud.emission.mass / len(t0)
    there = float(mass * np.sum((run.status == ALOFT) | (run.status == LANDED)))
    change = run.v - v0
    change[:, 2] += GRAVITY * (run.t - t0)
    left = np.sum(change - run.drag - run.contact, axis=0)
    size = np.sum(np.abs(run.drag)) + np.sum(np.abs(run.contact))
    return 1.0 - there / cloud.emission.mass, float(np.max(np.abs(left)) / size)


def _balances(make_method: MakeMethod, quick: bool) -> list[dict[str, Any]]:
    method, found, highest = gauss(make_method, 2), [], []
    grains, differ = np.arange(QUICK_SAMPLED if quick else SAMPLED), 0
    for diameter in DIAMETERS:
        for ground in (Ground(), REBOUNDING):
            cloud = Cloud(diameter, grains=grains, ground=ground)
            run = cloud.flights(method, 384, saves=FRAMES)
            lost, pushed = balance(cloud, run)
            found += rows_of({LOST: abs(lost), PUSHED: pushed}, label=words(diameter))
            some = Cloud(diameter, grains=grains[7::97], ground=ground).flights(method, 384)
            differ += int(np.sum(some.q != run.q[7::97]) + np.sum(some.v != run.v[7::97]))
        highest.append(float(np.nanmax(run.places[:, :, 2])))
    return [*found, *rows_of({HIGHEST: min(highest), ALONE: float(differ)})]


def _statistics(make_method: MakeMethod, quick: bool, report: Report) -> list[dict[str, Any]]:
    n = QUICK_SAMPLED if quick else SAMPLED
    clouds = {diameter: Cloud(diameter, grains=np.arange(n)) for diameter in DIAMETERS}
    s, steps = QUICK_FINEST if quick else FINEST
    report(f"statistics, degree {s} in {steps} steps")
    best, found = answers(clouds, gauss(make_method, s), steps), []
    for quantity in (DEPTH, HEIGHT):
        seen = total(best.of(quantity))
        values = {quantity: seen.value, SAMPLING: seen.uncertainty or 0.0, GRAINS: best.grains}
        found += rows_of(values, study=quantity)
    for s, steps in COMPARED:
        report(f"statistics, degree {s} in {steps} steps")
        run = answers(clouds, gauss(make_method, s), steps)
        where = {"n": s + 1, "steps": steps, "step": UNTIL / steps}
        for quantity in (DEPTH, HEIGHT):
            found += _error_of_step(quantity, run, best, where)
        work = run.work / (n * len(DIAMETERS))
        found.append(row(study=WORK, quantity=WORK, value=work, **where))
    return found


def _error_of_step(
    quantity: str, run: Answers, best: Answers, where: dict[str, Any]
) -> list[dict[str, Any]]:
    """The error of the step, and its own standard error."""
    apart = total(run.of(quantity) - best.of(quantity))
    values = {OF_STEP: apart.value, f"{SAMPLING} of it": apart.uncertainty or 0.0}
    return rows_of(values, study=quantity, **where)


def _places(make_method: MakeMethod) -> list[dict[str, Any]]:
    found: list[dict[str, Any]] = []
    for k, diameter in enumerate(DIAMETERS):
        cloud = Cloud(diameter, grains=np.arange(PICTURED) + k * PICTURED)
        run = cloud.flights(gauss(make_method, 2), 384, saves=FRAMES)
        for part in range(FRAMES + 1):
            t, all_places = UNTIL * part / FRAMES, run.places[:, part]
            flying = np.isfinite(all_places[:, 0]) & (all_places[:, 2] > 0.0)
            if t in TIMES:
                places = all_places[flying]
                found += history(SHOWN, np.full(len(places), t), places, study=SHOWN,
                                 label=words(diameter))  # fmt: skip
            places = all_places[:IN_MOTION][flying[:IN_MOTION]]
            found += history(MOVING, np.full(len(places), t), places, study=MOVING,
                             label=words(diameter))  # fmt: skip
    return found


UNPRINTED = (
    "M's picture cannot be reproduced: M prints neither its wind (computed elsewhere) nor how the "
    "ground gives off sand and takes it back, nor C_d, sizes, numbers or times. This is a stated "
    "model's cloud instead"
)
EXACT = "compiled DOP853 with contacts, tolerance 1e-13; heyoka's events agree to 1e-9 m"


def judge(table: pd.DataFrame) -> list[Row]:
    """Rows on what M says of the cloud, then on convergence, balances and statistics."""
    return [
        V25.row(
            HIGHEST,
            AtLeast(thrown()),
            number(table, quantity=HIGHEST),
            claimed="the uplifting of sand particles in the air by vortices of the aerodynamic "
            "field",
            reason="Without a wind that rises no grain gets above the layer in which it enters "
            "and the height of a throw with its speed, which is the bound.",
        ),
        V25.row(
            ALONE,
            Exactly(0),
            number(table, quantity=ALONE),
            claimed="non-interacting particles",
            reason="Each grain has a lane of its own: with other grains, elsewhere in the array "
            "and in another thread, its numbers are the same to the last bit.",
        ),
        *(_order(table, drag, d, s) for drag in (CONSTANT, BY_REYNOLDS) for d in FIRM
          for s in DEGREES),
        *(_order(table, "rebound", 200e-6, s) for s in DEGREES),
        *(_stiff(table, d) for d in DIAMETERS if d not in FIRM),
        _fates(table),
        *(
            V25.row(
                f"{quantity}, largest share over sizes and grounds",
                Finding(AtMost(1e-12)),
                readings.largest(readings.values(table, quantity=quantity)),
                setup="2 Gauss points, 384 steps; grains stay on the ground, or rebound with 0.5",
                reason=why,
            )
            for quantity, why in (
                (LOST, "Mass lifted = mass aloft + mass on the ground: no super-particle is lost, "
                 "and none fails."),
                (PUSHED, "The change of momentum is the impulse of weight, drag and ground: the "
                 "step conserves it, and each contact is counted."),
            )
        ),
        *(_seen(table, quantity) for quantity in (DEPTH, HEIGHT)),
        *(_crossing(table, quantity, s, steps) for quantity in (DEPTH, HEIGHT)
          for s, steps in ((1, 96), (2, 96), (4, 96))),
        *(_cheapest(table, quantity) for quantity in (DEPTH, HEIGHT)),
        _cheapest(table, HEIGHT, MILLION),
    ]  # fmt: skip


def thrown() -> float:
    """The height that no grain reaches without a rising wind [m]."""
    r, t = np.linspace(0.5, 20.0, 400)[:, None], np.linspace(0.0, UNTIL, 100)[None, :]
    return float(LEVEL + np.max(friction_speed(r, t)) ** 2 / (2.0 * GRAVITY))


def _order(table: pd.DataFrame, study: str, diameter: float, s: int) -> Row:
    return V25.row(
        f"order of the {ERROR}, N = {s}, {words(diameter)}, {study}",
        Finding(Order(2 * s)),
        readings.order(table, FLOOR, study=study, quantity=ERROR, label=words(diameter), n=s + 1),
        reference=EXACT,
        reason="The moment of a contact is the root of the end of a shortened step, as exact as "
        "the step; the root of the curve of the whole step has order N + 1.",
    )


def _stiff(table: pd.DataFrame, diameter: float) -> Row:
    fit = readings.order(
        table, FLOOR, study=BY_REYNOLDS, quantity=ERROR, label=words(diameter), n=3
    )
    return V25.row(
        f"order of the {ERROR}, N = 2, {words(diameter)}, {BY_REYNOLDS}",
        Finding(AtLeast(1.0, uncertainty=0.0)),
        fit,
        reference=EXACT,
        reason="A step takes up to 40 relaxation times: between the order N of stiff problems and "
        "2 N, and still convergent.",
    )


def _fates(table: pd.DataFrame) -> Row:
    finest = readings.largest(pick(table, study=BY_REYNOLDS, quantity=FATES)["steps"].to_numpy())
    found = pick(table, quantity=FATES, steps=finest, n=3)
    found = found[found["study"] != "rebound"]
    return V25.row(
        "grains aloft that should be on the ground, and the reverse, N = 2, smallest step",
        Finding(Exactly(0)),
        float(found["value"].sum()) if len(found) else float("nan"),
        reference=EXACT,
        reason="A grain that lands just before the end of the run, or just misses the ground, is "
        "told rightly too.",
    )


def _seen(table: pd.DataFrame, quantity: str) -> Row:
    value = number(table, study=quantity, quantity=quantity)
    return V25.row(
        quantity,
        Finding(),
        Estimate(value, number(table, study=quantity, quantity=SAMPLING)),
        setup=f"{MODEL}; {BY_REYNOLDS}; 4 Gauss points",
        reason="In the model stated, with alpha = 1e-3 /m; the optical depth is proportional to "
        "alpha, which soils have from 1e-4 to 1e-2. The uncertainty is that of sampling."
        if quantity == DEPTH
        else "Of all that was lifted; the uncertainty is that of sampling.",
    )


def _crossing(table: pd.DataFrame, quantity: str, s: int, steps: int) -> Row:
    where = {"study": quantity, "n": s + 1, "steps": steps}
    error = abs(number(table, quantity=OF_STEP, **where))
    own = number(table, quantity=f"{SAMPLING} of it", **where)
    left = sampling_error(table, quantity, MILLION)
    return V25.row(
        f"{quantity}: {OF_STEP} over the {SAMPLING} of 1e6 grains, N = {s}, {steps} steps",
        Finding(),
        Estimate(error / left, own / left) if left > 0.0 else float("nan"),
        reason="Above 1 the step decides the error, below it the number of grains: they cross at "
        "1e6 grains over the square of this number. Differences of the same grains.",
    )


def sampling_error(table: pd.DataFrame, quantity: str, grains: float | None = None) -> float:
    """The standard error that so many grains leave; None: those of the study."""
    n = number(table, study=quantity, quantity=GRAINS)
    error = number(table, study=quantity, quantity=SAMPLING)
    return error * float(np.sqrt(n / (grains or n)))


def _cheapest(table: pd.DataFrame, quantity: str, grains: float | None = None) -> Row:
    """The cost of the cheapest of COMPARED of degree 1 whose error of the step is below that of
    sampling, by two of its standard errors, over that of the cheapest of a higher degree."""
    costs: dict[bool, list[float]] = {True: [], False: []}
    for s, steps in COMPARED:
        where = {"n": s + 1, "steps": steps}
        error = abs(number(table, study=quantity, quantity=OF_STEP, **where))
        own = number(table, study=quantity, quantity=f"{SAMPLING} of it", **where)
        if error + 2.0 * own <= sampling_error(table, quantity, grains):
            costs[s == 1].append(number(table, study=WORK, quantity=WORK, **where))
    low, high = (min(costs[first], default=float("nan")) for first in (True, False))
    sample = "1e6 grains" if grains else "the grains of the study"
    return V25.row(
        f"{quantity}: evaluations of the cheapest N = 1 over those of the cheapest higher N, with "
        f"an error of the step below the standard error of {sample}",
        Finding(),
        low / high if high > 0.0 else float("nan"),
        setup=f"N = 1 in 48 to 384 steps, N = 2 in 48 to 192, N = 4 in 48 and 96; {MODEL}; "
        f"{SAMPLED} super-particles of each size ({QUICK_SAMPLED} in the quick form)",
        reason="Above 1 a high order pays for this statistic, below 1 it does not: the error of "
        "sampling shrinks slowly, so that a coarse step is fine enough until there are very many "
        "grains.",
    )


MODEL = (
    f"quartz of {', '.join(f'{d * 1e6:g}' for d in DIAMETERS)} micrometres, galvi's rotor wind, "
    f"T = {UNTIL:g} s, emission by Shao and Lu's threshold and White's flux (benchmarks.brownout)"
)
V25 = Claim(
    "V25",
    "Brownout cloud: a stated model of many particles",
    study,
    judge,
    ("M fig. 2",),
    source="M 6.2, fig. 2",
    setup=f"{MODEL}; degree N with N Gauss points",
    claimed="particle distributions at different time instants, a picture without numbers",
    reason=UNPRINTED,
    reference="none",
)
