"""V25: a brownout cloud of sand of several diameters (M figure 2), by a stated model."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from itertools import product
from typing import Any

import numpy as np

from benchmarks.applications.brownout.cloud import (
    CONSTANT_DRAG,
    DIAMETERS,
    END_TIME,
    REYNOLDS_DRAG,
    Cloud,
)
from benchmarks.applications.brownout.cost_at import ratio_of
from benchmarks.applications.brownout.emission import WALL_HEIGHT, friction_speed
from benchmarks.applications.brownout.flights import ALOFT, LANDED, WAITING, Flights, Ground
from benchmarks.applications.brownout.statistics import DEPTH, HEIGHT
from benchmarks.applications.brownout.step_errors import (
    COMPARED_STEPS,
    SAMPLING,
    STEP_ERROR,
    TOO_FEW_STEPS,
    UNSOLVED,
    compared,
    cost_of,
    sampling_error,
    step_errors,
)
from benchmarks.claims.kit import (
    DataFrame,
    Estimate,
    Fault,
    MakeMethod,
    Measurement,
    Report,
    collocation,
    faulty,
    fewer,
    history,
    number,
    pick,
    readings,
    rows,
    table_of,
    with_arguments,
)
from galvi.problems.brownout import GRAVITY
from references.textbook.grain_flights import landings

ERROR = "median error of the last place [m]"
ELSEWHERE = "grains aloft that should be on the ground, and the reverse, "
FATES = f"{ELSEWHERE}largest over N = 1 and 2, steps, sizes, drag laws and grounds"
REBOUND = "rebound"
GROUNDS = {"": Ground(), REBOUND: Ground(0.5)}
SHOWN, MOVING = "picture", "moving picture"  # studies of positions, for the pictures
TIMES = (1.5, 3.0, 4.5, 6.0)  # s; M prints no times
FRAMES = 24  # intervals between the frames of the moving picture
PICTURED, IN_MOTION = 1000, 100  # grains of each size in a picture
QUICK_SAMPLED = 600  # grains of each size for the statistics; 4000 in the full form
HIGHEST, LOST, PUSHED = (
    "highest place, least over sizes [m]",
    "grains that are neither aloft nor on the ground, largest over sizes and grounds",
    "momentum that the recorded impulses do not account for, share, largest over sizes and grounds",
)
OWN = f"{SAMPLING} of it"
ALONE = "numbers of a grain that depend on other grains"


def in_micrometres(diameter: float) -> str:
    """A diameter as text."""
    return f"{diameter * 1e6:g} micrometres"


LABELS = tuple(map(in_micrometres, DIAMETERS))


def study(make_method: MakeMethod, quick: bool, report: Report) -> DataFrame:
    """Rows on the paths of grains against DOP853, balances, statistics and positions for pictures.

    ERROR and FATES have the drag law or "rebound" in `study`, the size in `label` and the degree
    + 1 in `n`. LOST, PUSHED, ALONE and HIGHEST are balances. DEPTH and HEIGHT, with SAMPLING and
    OF_STEP errors, have their names in `study`, beside WORK and UNSOLVED. SHOWN and MOVING have x,
    z and t, with the size in `label`.
    """
    grains = QUICK_SAMPLED if quick else 4000
    return table_of(
        [
            *paths(make_method, quick, report),
            *balances(make_method, np.arange(grains)),
            *step_errors(make_method, quick, grains, report),
            *places(make_method),
        ]
    )


def paths(make_method: MakeMethod, quick: bool, report: Report) -> list[dict[str, Any]]:
    """Rows of the distance to the truth, and of the number of grains that are wrongly aloft or on
    the ground at the end."""
    table, grains = [], np.arange(30 if quick else 100)
    clouds = [
        (law, Cloud(d, law, grains)) for law in (CONSTANT_DRAG, REYNOLDS_DRAG) for d in DIAMETERS
    ]
    for name, cloud in (*clouds, (REBOUND, Cloud(200e-6, grains=grains, ground=GROUNDS[REBOUND]))):
        report(f"{name}, {in_micrometres(cloud.diameter)}")
        truth = landings(
            *(cloud.problem, *cloud.starts(), END_TIME),
            restitution=cloud.ground.restitution,
            slowest=cloud.ground.slowest,
        )
        step_counts = (384, 576, 768, 1152) if quick else (192, 288, 384, 576, 768, 1152, 1536)
        for s, steps in product((1, 2), step_counts):
            run = cloud.flights(collocation(make_method, s), steps)
            values = {
                ERROR: float(np.median(np.linalg.norm(run.q - truth.q, axis=1))),
                FATES: float(np.sum((run.status == LANDED) != truth.landed)),
            }
            where = {"n": s + 1, "step": END_TIME / steps, "steps": steps}
            table += rows(values, study=name, label=in_micrometres(cloud.diameter), **where)
    return table


def balances(make_method: MakeMethod, grains: Any) -> list[dict[str, Any]]:
    """Rows for each size and ground: the number of grains that are neither aloft nor on the ground;
    the momentum that the recorded impulses and the weight do not account for, over the impulses;
    the count of numbers that differ if a part of the grains flies alone; and the largest height."""
    method, part, table = collocation(make_method, 2), slice(7, None, 97), []
    for diameter, (name, ground) in product(DIAMETERS, GROUNDS.items()):
        cloud = Cloud(diameter, grains=grains, ground=ground)
        run = cloud.flights(method, 384, saves=FRAMES)
        partial_run = replace(cloud, grains=grains[part]).flights(method, 384)
        _, v0, t0 = cloud.starts()
        weight = np.outer(run.t - t0, [0.0, 0.0, GRAVITY])
        left = np.sum(run.v - v0 + weight - run.drag - run.contact, axis=0)
        values = {
            LOST: np.sum((run.status != ALOFT) & (run.status != LANDED)),
            PUSHED: np.max(abs(left)) / (np.sum(abs(run.drag)) + np.sum(abs(run.contact))),
            ALONE: np.sum(partial_run.q != run.q[part]) + np.sum(partial_run.v != run.v[part]),
            HIGHEST: np.nanmax(run.places[:, :, 2]),
        }
        table += rows(values, study=name, label=in_micrometres(diameter))
    return table


def places(make_method: MakeMethod) -> list[dict[str, Any]]:
    """Rows of the positions of grains, for the pictures."""
    table: list[dict[str, Any]] = []
    for k, diameter in enumerate(DIAMETERS):
        cloud = Cloud(diameter, grains=np.arange(PICTURED) + k * PICTURED)
        run = cloud.flights(collocation(make_method, 2), 384, saves=FRAMES)
        for part in range(FRAMES + 1):
            t = END_TIME * part / FRAMES
            for name, count in ((SHOWN, PICTURED * (t in TIMES)), (MOVING, IN_MOTION)):
                q = run.places[:count, part]
                flying = q[np.isfinite(q[:, 0]) & (q[:, 2] > 0.0)]
                t_of = np.full(len(flying), t)
                table += history(name, t_of, flying, study=name, label=in_micrometres(diameter))
    return table


def thrown() -> float:
    """The height that no grain reaches without a rising wind [m]: that of the layer in which grains
    enter plus that of a throw with the largest friction speed."""
    r, t = np.linspace(0.5, 20.0, 400)[:, None], np.linspace(0.0, END_TIME, 100)[None, :]
    return float(WALL_HEIGHT + np.max(friction_speed(r, t)) ** 2 / (2.0 * GRAVITY))


def read(table: DataFrame) -> dict[str, Measurement]:
    """Orders, balances and statistics; errors of the step over the sampling error of a number of
    grains; and evaluations with N = 1 over those of the cheapest higher N."""

    def unsolved(s: int, steps: int) -> float:
        return number(table, quantity=UNSOLVED, n=s + 1, steps=steps)

    def in_samplings(s: int, steps: int) -> Estimate:
        error, uncertainty = (
            number(table, study=HEIGHT, quantity=quantity, n=s + 1, steps=steps)
            / sampling_error(table, HEIGHT, 1e6)
            for quantity in (STEP_ERROR, OWN)
        )
        return Estimate(abs(error), uncertainty)

    def gain(grains: float) -> Estimate:
        level = sampling_error(table, HEIGHT, grains)
        first, *higher = (cost_of(table, HEIGHT, s, level) for s in COMPARED_STEPS)
        return ratio_of(first, min(higher, key=lambda cost: np.nan_to_num(cost.value, nan=np.inf)))

    fates = pick(table, quantity=FATES)
    error, uncertainty = (
        pick(table, study=DEPTH, quantity=quantity).set_index(["n", "steps"])["value"]
        for quantity in (STEP_ERROR, OWN)
    )
    limit = readings.largest((abs(error) + 2.0 * uncertainty).to_numpy())
    sampled = f"{STEP_ERROR} over the {SAMPLING} of"
    cost = f"evaluations with N = 1 over those of the cheapest higher N, for an {STEP_ERROR}"
    cases = [
        *product((CONSTANT_DRAG, REYNOLDS_DRAG), (200, 400), (1, 2)),
        *product([REBOUND], [200], (1, 2)),
        *product([REYNOLDS_DRAG], (10, 50, 100), [2]),
    ]
    return {
        "thrown": thrown(),
        HIGHEST: readings.smallest_of(table, study=REBOUND, quantity=HIGHEST),
        **{
            name: readings.largest_of(table, quantity=name) for name in (ALONE, LOST, PUSHED, FATES)
        },
        **{
            f"order of the {ERROR}, N = {s}, {size} micrometres, {law}": readings.order(
                pick(table, study=law, label=f"{size} micrometres", n=s + 1),
                1e-10,
                quantity=ERROR,
            )
            for law, size, s in cases
        },
        f"{ELSEWHERE}N = 2, smallest step, all sizes, drag laws and grounds": (
            pick(fates, steps=fates["steps"].max(), n=3)["value"].sum(min_count=1)
        ),
        f"{UNSOLVED}, all runs compared": sum(unsolved(*case) for case in compared()),
        **{f"{UNSOLVED}, N = {s}, {k} steps": unsolved(s, k) for s, k in TOO_FEW_STEPS.items()},
        **{
            name: Estimate(number(table, study=name, quantity=name), sampling_error(table, name))
            for name in (DEPTH, HEIGHT)
        },
        f"{DEPTH}: upper limit of the {sampled} 20000 grains, largest over the runs compared": (
            limit / sampling_error(table, DEPTH, 2e4)
        ),
        **{
            f"{HEIGHT}: {sampled} 1e6 grains, N = {s}, {k} steps": in_samplings(s, k)
            for s, k in ((1, 96), (2, 96), (4, 48))
        },
        **{
            f"{HEIGHT}: {cost} of the {SAMPLING} of {grains:g} grains": gain(grains)
            for grains in (2e4, 1e6)
        },
    }


def array(name: str, change: Callable[[Any], Any]) -> dict[str, Any]:
    """The `wrong` of a fault that changes an array of all flights."""

    def wrong(run: Flights) -> Flights:
        return replace(run, **{name: change(getattr(run, name))})

    return {
        FOLLOW: lambda original: (
            lambda *arguments, **options: wrong(original(*arguments, **options))
        )
    }


def no_rows(*arguments: Any) -> list[Any]:
    """[] in place of the rows of a part of the study."""
    return []


FOLLOW = f"{Cloud.__module__}.follow"
FLOWN = fewer(
    __name__, DIAMETERS=(200e-6, 400e-6), balances=no_rows, step_errors=no_rows, places=no_rows
)
BALANCED = fewer(__name__, QUICK_SAMPLED=200, paths=no_rows, step_errors=no_rows, places=no_rows)
FAULTS = {
    "weights larger by a thousandth": Fault(make=faulty(b=1.0 + 1e-3), wrong=FLOWN),
    "drag stronger by a thousandth": Fault(
        wrong=FLOWN
        | {
            FOLLOW: with_arguments(
                lambda method, q, v, t, rates, *options: (
                    *(method, q, v, t, rates * (1.0 + 1e-3 * np.eye(1, rates.shape[1]))),
                    *options,
                )
            )
        }
    ),
    "grains a thousandth of a second late": Fault(
        wrong=FLOWN
        | {
            FOLLOW: with_arguments(
                lambda method, q, v, t, *options: (method, q, v, t + 1e-3, *options)
            )
        }
    ),
    "contacts at the root of a step's curve": Fault(
        wrong=FLOWN
        | {
            FOLLOW: lambda original: (
                lambda *arguments, ground, **options: original(
                    *arguments, ground=replace(ground, exact=False), **options
                )
            )
        }
    ),
    "a grain has gone": Fault(
        wrong=BALANCED
        | array("status", lambda status: np.where(np.arange(len(status)), status, WAITING))
    ),
    "the ground pushes no grain": Fault(
        wrong=BALANCED | array("contact", lambda contact: 0.0 * contact)
    ),
    "the drag of a grain is not counted": Fault(
        wrong=BALANCED | array("drag", lambda drag: drag * np.sign(np.arange(len(drag)))[:, None])
    ),
    "grains that take a little of their neighbour's place": Fault(
        wrong=BALANCED | array("q", lambda q: q + 1e-12 * np.roll(q, 1, axis=0))
    ),
}
