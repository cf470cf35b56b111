"""The figures of V23, V24 and V25: figures 3 and 2 of M, sand in the wind of a helicopter."""

from __future__ import annotations

from collections.abc import Iterable

from benchmarks.applications.brownout.statistics import DEPTH, HEIGHT
from benchmarks.applications.brownout.step_errors import COMPARED_STEPS
from benchmarks.claims.vector_spaces import v23_brownout_order as v23
from benchmarks.claims.vector_spaces import v24_brownout_cost as v24
from benchmarks.claims.vector_spaces import v25_brownout_cloud as v25
from benchmarks.claims.vector_spaces.brownout_particle import ACROSS, AWAY, ERROR, EULER
from reports.figures.plots.convergence import Rate, convergence, in_h
from reports.figures.plots.lines import STEP, lines, sampling
from reports.figures.plots.paths import clouds, moving_cloud
from reports.results.section import Figure

SOURCE = "M fig. 3"
POSITION_ERROR = "largest error of the position [m]"
LINES_TEXT = "Solid line: fit over the filled points; dashed, a little above: the rate claimed"


def _rates(start: str, degrees: Iterable[int]) -> tuple[Rate, ...]:
    """Rates of Euler's method and of each degree N, for the runs from one start."""
    ns = [N + 1 for N in degrees]
    return (
        Rate(start, ERROR, "Euler", v23.FLOOR, claimed=1.0, n=1),
        *in_h(start, ERROR, ns, v23.FLOOR, lambda n: 2.0 * (n - 1), degrees=True),
    )


ENVELOPES = tuple(  # of runs through w = 0
    Rate(v23.PLACED, ERROR, f"$N={N}$", v23.FLOOR, n=N + 1, until=largest)
    for N, largest in v23.LIMITING.items()
)


BROWNOUT_FIGURES: tuple[Figure, ...] = (
    *(
        Figure(
            name=name,
            source=SOURCE,
            title=f"A sand particle in a rotor's wind, {title}",
            claims=("V23",),
            draw=convergence,
            options={"rates": rates, "ylabel": POSITION_ERROR, "unit": "s"},
            caption=f"{LINES_TEXT}. Euler: semi-implicit. {caption}",
            size=(6.4, 4.4),
        )
        for name, rates, title, caption in (
            (
                "m-fig-3-left",
                _rates(AWAY, v23.DEGREES),
                "never at rest in the air",
                "The drag is quadratic in the velocity relative to the air.",
            ),
            (
                "m-fig-3-left-crossing",
                (*_rates(ACROSS, [1]), *ENVELOPES),
                "overtaken by the air",
                "Where the velocity relative to the air is 0 the drag's second derivative jumps, "
                "and in the end no degree has an order above 3. From N = 2 on: the largest error "
                "of 13 runs with steps of nearly this size, which place that moment "
                "differently in its step.",
            ),
        )
    ),
    Figure(
        name="m-fig-3-left-saturation",
        source=SOURCE,
        title=f"A sand particle, N = {v23.SATURATING}: the solve stopped early",
        claims=("V23",),
        draw=lines,
        options={
            "quantity": ERROR,
            "against": STEP,
            "labels": {
                **{v23.stopped_at(t): f"stopped at {t:.0e}" for t in v23.TOLERANCES},
                v23.SOLVED: "solved to round-off",
            },
            "xlabel": "step size $h$ [s], smaller to the right",
            "ylabel": POSITION_ERROR,
        },
        caption="Newton's iteration stops when the relative change of the position is below this.",
    ),
    Figure(
        name="m-fig-3-right",
        source=SOURCE,
        title="A sand particle: error against time",
        claims=("V24",),
        draw=lines,
        options={
            "quantity": ERROR,
            "against": v24.SECONDS,
            "between": (v24.FASTEST, v24.SLOWEST),
            "labels": {
                EULER: "semi-implicit Euler",
                **{v24.label_of(N): f"$N={N}$" for N in v24.DEGREES},
            },
            "xlabel": "time to solution [s]",
            "ylabel": POSITION_ERROR,
        },
        caption="Medians of one interleaved run, with bars from the fastest to the slowest round, "
        "both in compiled code, Python's overhead and what it takes to set up a run included.",
    ),
    Figure(
        name="m-fig-2",
        source="M fig. 2",
        title="A brownout cloud at four times, by size",
        claims=("V25",),
        draw=clouds,
        options={"study": v25.SHOWN, "labels": v25.LABELS, "times": v25.TIMES},
        caption="A stated model, not M's, which prints neither wind nor emission; its times are "
        f"ours. {v25.PICTURED} super-particles of each size, of the same mass, seen from the side, "
        "the coarsest in front; those on the ground are not shown. Line: the rotor. Dashed: the "
        "pilot's ray.",
        size=(8.4, 3.6),
    ),
    Figure(
        name="m-fig-2-moving",
        source="M fig. 2",
        title="The brownout cloud as it grows",
        claims=("V25",),
        draw=moving_cloud,
        options={"study": v25.MOVING, "labels": v25.LABELS},
        caption=f"Every quarter of a second; {v25.IN_MOTION} super-particles of each size. The PNG "
        "shows the end.",
        size=(7.4, 3.2),
    ),
    *(
        Figure(
            name=f"m-fig-2-{name}",
            source="M fig. 2",
            title=f"The cloud's {quantity.split(' [')[0]}: error of the step and of sampling",
            claims=("V25",),
            draw=sampling,
            options={"quantity": quantity, "degrees": {N: f"$N={N}$" for N in COMPARED_STEPS}},
            caption="Mean difference from a run of high order with the same grains, with its "
            "standard error; arrows: upper limits, where it is below that. Dashed, dotted: what a "
            "number of grains leaves by chance, below which a finer step gains nothing.",
        )
        for name, quantity in (("depth", DEPTH), ("height", HEIGHT))
    ),
)
