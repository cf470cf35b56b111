"""Cost against the number of bodies, and the limit of the machine."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import pandas as pd
from llvmlite import ir
from numba import types
from numba.extending import intrinsic

from benchmarks.applications.external.integrator import ExternalIntegrator
from benchmarks.statistics.repeated_run import repeated_run
from benchmarks.statistics.timing import Timing, call_of, interleaved, once, warmed
from benchmarks.test_problems.planets import innermost_period, many_planets
from benchmarks.work_precision.galvi_methods import gauss_collocation
from benchmarks.work_precision.participants import label_beside, offered_settings, readable_setting
from galvi import Problem, Trajectory
from galvi.kernels.compile.jit import jit
from galvi.lanes.vectors import DOUBLE, LANES, VECTOR
from references import Contender
from references.rebound.ias15 import IAS15
from references.rebound.whfast import BEST, WHFAST

# The largest rate of pairs that this machine's divide and square-root units allow.
#
# A pair of bodies needs 1 / (x sqrt(x)) of its squared distance x. This kernel computes nothing
# else, on numbers in the L1 cache, with the same vector instructions as galvi's own.

PAIR_COUNT = 1024  # squared distances, 16 KiB with the results
PULL_PASSES = 500


@intrinsic
def pull(typingctx, squares, pulls, chunk):
    """pulls <- 1 / (squares sqrt(squares)) in eight lanes from 8 chunk on."""
    signature = types.void(squares, pulls, types.intp)

    def generate(context, builder, signature, arguments):
        offset = builder.mul(arguments[2], ir.Constant(arguments[2].type, LANES))
        addresses = []
        for kind, argument in zip(signature.args[:2], arguments[:2], strict=True):
            base = context.make_array(kind)(context, builder, argument).data
            address = builder.gep(base, [offset])
            addresses.append(builder.bitcast(address, VECTOR.as_pointer()))
        x = builder.load(addresses[0])
        x.align = 8
        name = f"llvm.sqrt.v{LANES}f64"
        module = builder.module
        root = module.globals.get(name) or ir.Function(
            module, ir.FunctionType(VECTOR, [VECTOR]), name
        )
        cube = builder.fmul(x, builder.call(root, [x]))
        ones = ir.Constant(VECTOR, [ir.Constant(DOUBLE, 1.0)] * LANES)
        builder.store(builder.fdiv(ones, cube), addresses[1]).align = 8
        return context.get_dummy_value()

    return signature, generate


@jit
def pull_pairs(squares, pulls, passes):
    """Apply `pull` to all squares, `passes` times."""
    for _ in range(passes):
        for chunk in range(squares.size // LANES):
            pull(squares, pulls, chunk)


def call_and_pairs():
    """A function without arguments, and the number of pairs that one call evaluates."""
    squares, pulls = np.linspace(1.0, 900.0, PAIR_COUNT), np.zeros(PAIR_COUNT)
    return lambda: pull_pairs(squares, pulls, PULL_PASSES), PAIR_COUNT * PULL_PASSES


# Cost against the number of bodies at matched error, and the share of the machine's limit.
#
# Each contender runs at several settings and is represented by the fastest within TARGET of the
# truth after ORBITS revolutions.

COLUMNS = (
    "contender",
    "settings",
    "bodies",
    "orbits",
    "seconds_per_orbit",
    "seconds_low",
    "seconds_high",
    "error",
    "matched",
    "evaluations_per_orbit",
    "pairs_per_second",
    "limit_pairs_per_second",
    "share",
    "status",
)
BODIES, QUICK_BODIES = (3, 10, 30, 100), (3, 10, 30)
ORBITS, QUICK_ORBITS = 30, 12  # revolutions of the innermost planet
WORK = 1800  # bodies times orbits of a timed run, so that its start-up is negligible
STEPS_AN_ORBIT = 4  # fewest for an external integrator without settings
MASSIVE_BODIES = 10  # bodies with a mass where the others are massless
MASSIVE_SUFFIX = f", {MASSIVE_BODIES} heavy"  # of a contender's label there
TARGET = 1e-8  # au, largest error of a body at the end
ROUNDS = 3


@dataclass(frozen=True)
class ScalingParticipant:
    """One setting of one contender.

    Attributes
    ----------
    per_orbit
        approximate steps per revolution of the innermost planet; None if adaptive
    options
        further (key, value) pairs of its setting
    """

    label: str
    contender: Contender
    per_orbit: int | None = None
    options: tuple[tuple[str, Any], ...] = ()

    @property
    def settings(self) -> str:
        """The settings in words."""
        if self.per_orbit is not None:
            return f"P/{self.per_orbit}"
        return ", ".join(f"{key} = {value:g}" for key, value in self.options)

    def call(self, problem: Problem, orbits: int) -> Callable[[], Trajectory]:
        """A run over `orbits` revolutions, never with a whole number of steps in each."""
        duration = orbits * innermost_period(problem)
        if self.per_orbit is None:
            setting: dict[str, Any] = {"samples": 1, **dict(self.options)}
            return lambda: self.contender.run(problem, duration, setting)
        steps = orbits * self.per_orbit + orbits // 3 + 1
        setting = {"step": duration / steps, "save_every": steps, **dict(self.options)}
        return lambda: self.contender.run(problem, duration, setting)

    def timed(
        self, problem: Problem, orbits: int, seconds: float, round_seconds: float
    ) -> tuple[Callable[[], Trajectory], int]:
        """A run long enough to be timed, and its number of revolutions.

        Parameters
        ----------
        seconds
            time of the run over `orbits`
        round_seconds
            least seconds of a round
        """
        timed_orbits = max(orbits, WORK // len(problem.q0))
        return self.call(problem, timed_orbits), timed_orbits


@dataclass(frozen=True, eq=False)
class ExternalParticipant:
    """One setting offered by an external integrator for a problem and number of revolutions."""

    label: str
    contender: ExternalIntegrator
    setting: Mapping[str, Any]

    @property
    def settings(self) -> str:
        """The settings in words."""
        return readable_setting(self.setting)

    def call(self, problem: Problem, orbits: int) -> Callable[[], Trajectory]:
        """See `ScalingParticipant`."""
        return call_of(self.contender, problem, orbits * innermost_period(problem), self.setting)

    def timed(
        self, problem: Problem, orbits: int, seconds: float, round_seconds: float
    ) -> tuple[Callable[[], Trajectory], int]:
        """See `ScalingParticipant`; a run that is long already is not lengthened."""
        duration = orbits * innermost_period(problem)
        longer = repeated_run(
            self.contender, problem, duration, self.setting, seconds, round_seconds
        )
        return longer.call, orbits * longer.times


TRUTH = ScalingParticipant("REBOUND IAS15", IAS15, None, (("epsilon", 1e-9),))  # its default
PARTICIPANTS = (
    *(ScalingParticipant("galvi degree 8, Gauss 8", gauss_collocation(8), k) for k in (4, 5, 6)),
    TRUTH,
    *(ScalingParticipant("REBOUND IAS15", IAS15, None, (("epsilon", e),)) for e in (1e-6, 1e-4)),
    *(
        ScalingParticipant("REBOUND WHFast, best", WHFAST, k, tuple(BEST.items()))
        for k in (15, 20, 30, 60)
    ),
)


def scaling(
    quick: bool = False,
    report: Callable[[str], None] = lambda sentence: None,
    bodies: Sequence[int] | None = None,
    orbits: int | None = None,
    externals: Sequence[ExternalIntegrator] = (),
) -> pd.DataFrame:
    """One row for each number of bodies, contender and setting, timed alternately; external
    integrators take part where they can. The largest number of
    bodies is measured again with all but MASSIVE_BODIES of them massless.

    orbits                  revolutions of the innermost planet in a timed run
    seconds_per_orbit       median over rounds; seconds_low and seconds_high are the fastest and
                            the slowest
    error                   largest distance of a body from the truth, IAS15 at its default, after
                            ORBITS (fewer when quick), in au; NaN for the truth
    matched                 whether it is the fastest of its contender within TARGET
    evaluations_per_orbit   evaluations of all forces; NaN when the engine does not count
    pairs_per_second        evaluations times the number of pairs, over the time
    limit_pairs_per_second  limit by divisions and square roots alone: the study's fastest round
    share                   share of that limit
    """
    bodies = bodies or (QUICK_BODIES if quick else BODIES)
    orbits = orbits or (QUICK_ORBITS if quick else ORBITS)
    rows, limit = [], 0.0
    for number in bodies:
        for heavy in (None, MASSIVE_BODIES) if number == max(bodies) > MASSIVE_BODIES else (None,):
            report(f"{number} bodies{f', {heavy} heavy' if heavy else ''}")
            number_rows, measured_limit = _rows(
                number, orbits, 0.01 if quick else 0.05, externals, heavy
            )
            rows, limit = rows + number_rows, max(limit, measured_limit)
    table = pd.DataFrame(rows, columns=list(COLUMNS))
    table["limit_pairs_per_second"] = limit
    table["share"] = table["pairs_per_second"] / limit
    return table


def _rows(
    bodies: int,
    orbits: int,
    round_seconds: float,
    externals: Sequence[ExternalIntegrator],
    heavy: int | None = None,
) -> tuple[list[dict[str, Any]], float]:
    """The rows of one number of bodies, and the limit in pairs per second measured meanwhile."""
    problem = many_planets(bodies, heavy)
    participants = (*PARTICIPANTS, *_external_participants(problem, orbits, externals))
    if heavy:
        participants = tuple(
            replace(participant, label=f"{participant.label}{MASSIVE_SUFFIX}")
            for participant in participants
        )
    truth = next(
        (participant for participant in participants if participant.settings == TRUTH.settings),
        TRUTH,
    )
    runnable = [participant for participant in participants if not participant.contender.missing]
    firsts = [once(participant.call(problem, orbits)) for participant in runnable]
    runs = {participant: run for participant, (run, _) in zip(runnable, firsts, strict=True)}
    succeeded = [
        (participant, seconds)
        for participant, (run, seconds) in zip(runnable, firsts, strict=True)
        if run.success
    ]
    calls, spans = [], []
    for participant, seconds in succeeded:
        call, span = participant.timed(problem, orbits, seconds, round_seconds)
        calls.append(call)
        spans.append(span)
    limit, pairs = call_and_pairs()
    last, warm = zip(*map(once, calls), warmed(limit), strict=True)
    *timings, machine = interleaved([*calls, limit], ROUNDS, round_seconds, warm)
    row_of = {
        participant: _row(
            participant, bodies, span, runs[participant], end, timing, runs.get(truth)
        )
        for (participant, _), span, end, timing in zip(
            succeeded, spans, last[:-1], timings, strict=True
        )
    }
    for label in {participant.label for participant in runnable}:
        within_target = [
            row
            for participant, row in row_of.items()
            if participant.label == label
            and (row["error"] <= TARGET or participant == truth)
            and row["seconds_per_orbit"] > 0.0
        ]
        if within_target:
            min(within_target, key=lambda row: row["seconds_per_orbit"])["matched"] = True
    blank = {**dict.fromkeys(COLUMNS, float("nan")), "matched": False}
    rows = [
        row_of.get(
            participant,
            {
                **blank,
                "contender": participant.label,
                "settings": participant.settings,
                "bodies": bodies,
                "orbits": orbits,
                "status": participant.contender.missing or runs[participant].status,
            },
        )
        for participant in participants
    ]
    return rows, pairs / machine.low


def _external_participants(
    problem: Problem, orbits: int, externals: Sequence[ExternalIntegrator]
) -> list[ExternalParticipant]:
    """Every setting of every external integrator."""
    labels = [participant.label for participant in PARTICIPANTS]
    duration, fewest = orbits * innermost_period(problem), orbits * STEPS_AN_ORBIT
    return [
        ExternalParticipant(label_beside(external, labels), external, setting)
        for external in externals
        for setting in offered_settings(external, problem, duration, fewest)
    ]


def _row(
    participant: ScalingParticipant | ExternalParticipant,
    bodies: int,
    orbits: int,
    run: Trajectory,
    last: Trajectory,
    timing: Timing,
    truth: Trajectory | None,
) -> dict[str, Any]:
    """The row of a setting; `run` is that of the error comparison, `last` the timed one."""
    nan, finished = float("nan"), run.success and last.success
    forces = float(last.counts.get("force_evaluations", nan))
    pairs = float(last.counts.get("pair_evaluations", forces * (bodies * (bodies - 1) / 2)))
    is_comparable = finished and truth is not None and truth.success and run is not truth
    status = next((trajectory.status for trajectory in (run, last) if not trajectory.success), "")
    return {
        "contender": participant.label,
        "settings": participant.settings,
        "bodies": bodies,
        "orbits": orbits,
        "seconds_per_orbit": timing.seconds / orbits if finished else nan,
        "seconds_low": timing.low / orbits if finished else nan,
        "seconds_high": timing.high / orbits if finished else nan,
        "error": float(np.max(np.linalg.norm(run.q[-1] - truth.q[-1], axis=-1)))
        if is_comparable
        else nan,
        "matched": False,
        "evaluations_per_orbit": forces / orbits,
        "pairs_per_second": pairs / timing.seconds if finished else nan,
        "limit_pairs_per_second": nan,
        "share": nan,
        "status": "truth" if finished and run is truth else status or _untimed(timing),
    }


def _untimed(timing: Timing) -> str:
    return "" if timing.seconds > 0.0 else "A later run of the same setting failed."
