"""V25: a brownout cloud of sand of several diameters (M figure 2), by a stated model."""

from __future__ import annotations

from benchmarks.applications.brownout.cloud import BY_REYNOLDS, CONSTANT, DIAMETERS, UNTIL, Cloud
from benchmarks.applications.brownout.cost_at import over
from benchmarks.applications.brownout.emission import LEVEL, friction_speed
from benchmarks.applications.brownout.flights import ALOFT, LANDED, Flights, Ground
from benchmarks.applications.brownout.statistics import DEPTH, HEIGHT
from benchmarks.applications.brownout.step_errors import (
    COMPARED,
    OF_STEP,
    SAMPLING,
    TOO_LONG,
    UNSOLVED,
    compared,
    cost_of,
    sampling_error,
    step_errors,
)  # fmt: skip
from benchmarks.claims.kit import *
from benchmarks.store.frames import rows as rows_of
from galvi.problems.brownout import GRAVITY
from references.textbook.grain_flights import landings

STEPS = (192, 288, 384, 576, 768, 1152, 1536)
QUICK_STEPS = (384, 576, 768, 1152)
TRACKED, QUICK_TRACKED = 100, 30  # grains of each size and drag law: 1000 in all
DEGREES = (1, 2)
FIRM = (200e-6, 400e-6)  # m, diameters of grains that relax in several of the longest steps
ERROR, FATES = "median error of the last place [m]", "grains that end elsewhere"
FLOOR = 1e-10  # m
REBOUNDING = Ground(0.5)
SHOWN, MOVING = "picture", "moving picture"  # studies of places in the meridional plane's half
TIMES = (1.5, 3.0, 4.5, 6.0)  # s; M prints no times
FRAMES = 24  # of the moving picture, and as many parts of the time
PICTURED, IN_MOTION = 1000, 100  # grains of a size, other ones for each
SAMPLED, QUICK_SAMPLED = 4000, 600  # of each size, for the statistics
FEW, MILLION = 2e4, 1e6  # grains of all sizes
HIGHEST, LOST, PUSHED = (
    "highest place, least over sizes [m]",
    "grains that are neither aloft nor on the ground",
    "momentum that the recorded impulses do not account for, share",
)
ALONE = "numbers of a grain that depend on other grains"


def words(diameter: float) -> str:
    """A diameter as text."""
    return f"{diameter * 1e6:g} micrometres"


LABELS = tuple(map(words, DIAMETERS))


def study(make_method: MakeMethod, quick: bool, report: Report) -> DataFrame:
    """Paths of grains against DOP853, balances, statistics and places for pictures.

    ERROR and FATES in `study` of a drag law (and CONSTANT and "rebound"), with the size in `label`,
    degree + 1 in `n`; LOST, PUSHED, ALONE, HIGHEST; DEPTH and HEIGHT with their SAMPLING errors and
    OF_STEP, named in `study`; WORK and UNSOLVED; SHOWN and MOVING: x, z and t, with the size in
    `label`.
    """
    found: list[dict[str, Any]] = []
    for drag in (CONSTANT, BY_REYNOLDS):
        for diameter in DIAMETERS:
            report(f"{drag}, {words(diameter)}")
            found += _paths(make_method, quick, drag, Cloud(diameter, drag))
    report("rebounds")
    found += _paths(make_method, quick, "rebound", Cloud(200e-6, ground=REBOUNDING))
    found += _balances(make_method, quick)
    found += step_errors(make_method, quick, QUICK_SAMPLED if quick else SAMPLED, report)
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
            run = cloud.flights(collocation(make_method, s), steps)
            values = {
                ERROR: float(np.median(np.linalg.norm(run.q - truth.q, axis=1))),
                FATES: float(np.sum((run.status == LANDED) != truth.landed)),
            }
            found += rows_of(values, study=study, label=words(cloud.diameter), n=s + 1,
                             step=UNTIL / steps, steps=steps)  # fmt: skip
    return found


def balance(cloud: Cloud, run: Flights) -> tuple[float, float]:
    """The number of grains that are neither aloft nor on the ground, and the share of the recorded
    impulses of drag and ground that the change of momentum and the weight leave."""
    _, v0, t0 = cloud.starts()
    change = run.v - v0
    change[:, 2] += GRAVITY * (run.t - t0)
    left = np.sum(change - run.drag - run.contact, axis=0)
    size = np.sum(np.abs(run.drag)) + np.sum(np.abs(run.contact))
    lost = np.sum((run.status != ALOFT) & (run.status != LANDED))
    return float(lost), float(np.max(np.abs(left)) / size)


def _balances(make_method: MakeMethod, quick: bool) -> list[dict[str, Any]]:
    method, found, highest = collocation(make_method, 2), [], []
    grains, differ = np.arange(QUICK_SAMPLED if quick else SAMPLED), 0
    for diameter in DIAMETERS:
        for ground in (Ground(), REBOUNDING):
            cloud = Cloud(diameter, grains=grains, ground=ground)
            run = cloud.flights(method, 384, saves=FRAMES)
            lost, pushed = balance(cloud, run)
            found += rows_of({LOST: lost, PUSHED: pushed}, label=words(diameter))
            some = Cloud(diameter, grains=grains[7::97], ground=ground).flights(method, 384)
            differ += int(np.sum(some.q != run.q[7::97]) + np.sum(some.v != run.v[7::97]))
        highest.append(float(np.nanmax(run.places[:, :, 2])))
    return [*found, *rows_of({HIGHEST: min(highest), ALONE: float(differ)})]


def _places(make_method: MakeMethod) -> list[dict[str, Any]]:
    found: list[dict[str, Any]] = []
    for k, diameter in enumerate(DIAMETERS):
        cloud = Cloud(diameter, grains=np.arange(PICTURED) + k * PICTURED)
        run = cloud.flights(collocation(make_method, 2), 384, saves=FRAMES)
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
    "M's picture cannot be reproduced: it prints neither its wind (computed elsewhere) nor how the "
    "ground gives off sand and takes it back, nor C_d, sizes, numbers or times. This is a stated "
    "model's cloud instead"
)
EXACT = "compiled DOP853 with contacts, tolerance 1e-13; heyoka's events agree to 1e-9 m"


def judge(table: DataFrame) -> list[Row]:
    """Rows on the picture, on convergence, balances and statistics; none of them is M's claim."""
    return [
        V25.row(
            HIGHEST,
            Finding(AtLeast(thrown())),
            number(table, quantity=HIGHEST),
            reason=f"{UNPRINTED}. Without a wind that rises no grain gets above the layer in which "
            "it enters and the height of a throw with its speed, which is the bound.",
        ),
        V25.row(
            ALONE,
            Finding(Exactly(0)),
            number(table, quantity=ALONE),
            reason="As in M, particles do not interact. Each grain has a lane of its own: with "
            "other grains, and elsewhere in the array, its numbers are the same to the last bit.",
        ),
        *(_order(table, drag, d, s) for drag in (CONSTANT, BY_REYNOLDS) for d in FIRM
          for s in DEGREES),
        *(_order(table, "rebound", 200e-6, s) for s in DEGREES),
        *(_small(table, d, bound, why) for d, (bound, why) in SMALL.items()),
        *_fates(table),
        *(
            V25.row(
                f"{quantity}, largest over sizes and grounds",
                Finding(bound),
                readings.largest_of(table, quantity=quantity),
                setup="2 Gauss points, 384 steps; grains stay on the ground, or rebound with 0.5",
                reason=why,
            )
            for quantity, bound, why in (
                (LOST, Exactly(0), "None is left out, and none fails: as all have the same mass, "
                 "the mass lifted is then aloft or on the ground, however they move."),
                (PUSHED, AtMost(1e-12), "Impulses are summed beside the velocities: a step or a "
                 "contact that only one of them has would show. How exact they are would not."),
            )
        ),
        *(_seen(table, quantity) for quantity in (DEPTH, HEIGHT)),
        *_unsolved(table),
        _limit(table, DEPTH),
        *(_crossing(table, HEIGHT, s, steps) for s, steps in ((1, 96), (2, 96), (4, 48))),
        *(_cheapest(table, HEIGHT, grains) for grains in (FEW, MILLION)),
    ]  # fmt: skip


def thrown() -> float:
    """The height that no grain reaches without a rising wind [m]."""
    r, t = np.linspace(0.5, 20.0, 400)[:, None], np.linspace(0.0, UNTIL, 100)[None, :]
    return float(LEVEL + np.max(friction_speed(r, t)) ** 2 / (2.0 * GRAVITY))


def _order(table: DataFrame, study: str, diameter: float, s: int) -> Row:
    return V25.row(
        f"order of the {ERROR}, N = {s}, {words(diameter)}, {study}",
        Finding(Order(2 * s)),
        readings.order(table, FLOOR, study=study, quantity=ERROR, label=words(diameter), n=s + 1),
        reference=EXACT,
        reason="The moment of a contact is the root of the end of a shortened step, as exact as "
        "the step; the root of the curve of the whole step has order N + 1.",
    )


SMALL: Mapping[float, tuple[Bound, str]] = {
    10e-6: (
        AtLeast(2.0, uncertainty=0.0),
        "Steps of 5 to 40 relaxation times: collocation at N points has order N on stiff problems.",
    ),
    50e-6: (
        AtLeast(2.0, uncertainty=0.0),
        "Steps of 0.2 to 1.5 relaxation times: between the order N of stiff problems and 2 N.",
    ),
    100e-6: (Order(4), "Steps of less than half a relaxation time: the order 2 N."),
}


def _small(table: DataFrame, diameter: float, bound: Bound, why: str) -> Row:
    fit = readings.order(
        table, FLOOR, study=BY_REYNOLDS, quantity=ERROR, label=words(diameter), n=3
    )
    return V25.row(
        f"order of the {ERROR}, N = 2, {words(diameter)}, {BY_REYNOLDS}",
        Finding(bound),
        fit,
        reference=EXACT,
        reason=why,
    )


def _fates(table: DataFrame) -> list[Row]:
    found = pick(table, quantity=FATES)
    finest = pick(found, steps=readings.largest(found["steps"].to_numpy()), n=3)
    name = "grains aloft that should be on the ground, and the reverse"
    return [
        V25.row(
            f"{name}, N = 2, smallest step, all sizes, drag laws and grounds",
            Finding(Exactly(0)),
            float(finest["value"].sum()) if len(finest) else float("nan"),
            reference=EXACT,
            reason="A grain that lands just before the end of the run, or just misses the ground, "
            "is told rightly too.",
        ),
        V25.row(
            f"{name}, largest over N = 1 and 2, steps, sizes, drag laws and grounds",
            Finding(),
            readings.largest(found["value"].to_numpy()),
            setup=f"of {TRACKED} grains ({QUICK_TRACKED} in the quick form), in {STEPS[0]} to "
            f"{STEPS[-1]} steps",
            reference=EXACT,
            reason="A long step tells a close case wrongly.",
        ),
    ]


def _seen(table: DataFrame, quantity: str) -> Row:
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


def _unsolved(table: DataFrame) -> list[Row]:
    def counted(s: int, steps: int) -> float:
        return number(table, quantity=UNSOLVED, n=s + 1, steps=steps)

    return [
        V25.row(
            f"{UNSOLVED}, all runs compared",
            Finding(Exactly(0)),
            float(sum(counted(s, steps) for s, steps in compared())),
            setup=_setup(),
            reason="A cloud of which one grain is missing has no mean, and is not compared.",
        ),
        *(
            V25.row(
                f"{UNSOLVED}, N = {s}, {steps} steps",
                Finding(),
                counted(s, steps),
                setup=_setup(),
                reason="Newton's iteration does not converge for all grains in steps so long, "
                "which are left out of the comparison.",
            )
            for s, steps in TOO_LONG.items()
        ),
    ]


def _limit(table: DataFrame, quantity: str) -> Row:
    where = {"study": quantity}
    errors = np.abs(readings.values(table, quantity=OF_STEP, **where))
    own = readings.values(table, quantity=f"{SAMPLING} of it", **where)
    return V25.row(
        f"{quantity}: upper limit of the {OF_STEP} over the {SAMPLING} of {FEW:g} grains, largest "
        "over the runs compared",
        Finding(),
        readings.largest(errors + 2.0 * own) / sampling_error(table, quantity, FEW),
        setup=_setup(),
        reason="The size of the difference and two of its standard errors. Few grains are near the "
        "ray, so that the difference itself is not known: nothing follows on which N is better.",
    )


def _crossing(table: DataFrame, quantity: str, s: int, steps: int) -> Row:
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


def _cheapest(table: DataFrame, quantity: str, grains: float) -> Row:
    level = sampling_error(table, quantity, grains)
    first, *others = (cost_of(table, quantity, s, level) for s in COMPARED)
    known = [cost for cost in others if np.isfinite(cost.value)]
    cheapest = min(known, key=lambda cost: cost.value, default=Estimate(float("nan")))
    return V25.row(
        f"{quantity}: evaluations with N = 1 over those of the cheapest higher N, for an {OF_STEP} "
        f"of the {SAMPLING} of {grains:g} grains",
        Finding(),
        over(first, cheapest),
        setup=_setup(),
        reason="Above 1 a high order pays for this statistic, below 1 it does not: the error of "
        "sampling shrinks slowly, so that a coarse step is fine enough until there are very many "
        "grains. Interpolated between steps, which adds less than a hundredth to the uncertainty.",
    )


def _setup() -> str:
    runs = "; ".join(
        f"N = {s} in {', '.join(map(str, several))} steps" for s, several in COMPARED.items()
    )
    return (
        f"{runs}; {MODEL}; {SAMPLED} super-particles of each size ({QUICK_SAMPLED} in the quick "
        "form)"
    )


MODEL = (
    f"quartz of {', '.join(f'{d * 1e6:g}' for d in DIAMETERS)} micrometres, galvi's rotor wind, "
    f"T = {UNTIL:g} s, emission by Shao and Lu's threshold and White's flux (brownout)"
)
ONLY_PATHS = {
    f"{__name__}.DIAMETERS": always((200e-6, 400e-6)),
    **{
        f"{__name__}.{name}": always(lambda *given: [])
        for name in ("_balances", "step_errors", "_places")
    },
}

V25 = Claim(
    "V25",
    "Brownout cloud: a stated model of many particles",
    study,
    judge,
    ("M fig. 2",),
    source="M 6.2, fig. 2",
    setup=f"{MODEL}; degree N with N Gauss points",
    claimed="none: M shows a picture without numbers",
    reference="none",
    statement="M 6.2, fig. 2 shows a cloud without numbers, so that there is nothing to check: a "
    "stated model's cloud is computed, and its statistics converge.",
    caught=(
        replace(of_table(wrong=ONLY_PATHS, b=1.0 + 1e-3), seen=some("N = 2, 400 micrometres")),
    ),
)
