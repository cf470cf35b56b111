"""Flights of many grains above the ground, in lanes and threads."""

from __future__ import annotations

from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from functools import lru_cache
from itertools import pairwise
from typing import Any

import numpy as np
import numpy.typing as npt

from benchmarks.applications.brownout import flight_kernel as flight
from benchmarks.applications.brownout import grain_pass
from benchmarks.applications.brownout.grain_pass import PASS_OF_GRAINS, rows_of_grains
from galvi import input_checks
from galvi.arrays import Array
from galvi.input_checks import shown
from galvi.kernels.compile.cache import stamp
from galvi.kernels.compile.function_pointers import addresses
from galvi.kernels.forces.rotor_wind import DESCENT_TIME
from galvi.lanes.vectors import LANES
from galvi.method import Galerkin
from galvi.run.ensemble import processors
from galvi.run.in_lanes.tables import aligned, integrals_of
from galvi.run.interruption import defer_interrupts
from galvi.spaces.polynomials import Polynomials
from galvi.systems.forces.drag import DragLaw
from galvi.tracing import code

Codes = npt.NDArray[np.int64]
GRAIN_PASS_IMPORT = "from benchmarks.applications.brownout.grain_pass import grain_pass\n"
GRAIN_PASS_SOURCE = """

pass_of_grains = grain_pass(wind, drag, {s})


def grain_pass_DIGEST(work, numbers):
    pass_of_grains(work, numbers)
"""
ROTOR_WIND = "from galvi.kernels.forces.rotor_wind import rotor_wind as wind\n"
BATCH_GRAINS = 4096  # most in one call of the kernel
TOLERANCE = 1e-14  # change of one more pass, relative to the velocities
TWO_STEP_POINTS = (
    2  # points up to which the accelerations of two steps are extrapolated to the next
)
MOST_POINTS = 8  # the end of the curve in powers of the time errs by 4e-13 with 8, 2e-4 with 20
MOST_STEPS = 10**9
WAITING, ALOFT, LANDED, FAILED, BOUNCING = range(5)
STATUSES = (
    "not started: its time is the end or after it",
    "aloft at the end",
    "stays on the ground",
    "the stage equations were not solved: take a shorter step",
    f"{flight.MOST_CONTACTS} contacts before the end: give Ground a larger slowest, or an earlier "
    "until",
)


@dataclass(frozen=True)
class Ground:
    """The effect of a contact with z = 0.

    Attributes
    ----------
    restitution
        ratio of the vertical speed after a contact to that before; None: a grain stays where it
        lands
    slowest
        m/s; a grain that would leave the ground at this speed or slower stays
    exact
        whether the time of contact is the root of the end of a shortened step, of order 2 s with s
        points; otherwise that of the curve of the full step, of order s + 1
    """

    restitution: float | None = None
    slowest: float = 0.05
    exact: bool = True

    def __post_init__(self) -> None:
        if self.restitution is not None:
            restitution = input_checks.real("restitution", self.restitution)
            if restitution < 0.0:
                raise ValueError(
                    f"restitution must not be negative; received {restitution!r}. Give None for "
                    f"grains that stay where they land."
                )
        if input_checks.real("slowest", self.slowest) < 0.0:
            raise ValueError(
                f"slowest must not be negative; received {self.slowest!r}. Give a speed in m/s."
            )
        input_checks.flag("exact", self.exact)


@dataclass(frozen=True, eq=False)
class Flights:
    """The ends of the flights of n grains.

    Attributes
    ----------
    status
        (n,) index in STATUSES
    t, q, v
        (n,), (n, 3) the last time and state: at the end, at the last contact, or at the start of a
        grain that does not start; where equations were not solved, the start of that step, and NaN
    drag : array, shape (n, 3)
        impulse of the drag over the mass, m/s
    contact : array, shape (n, 3)
        impulses of the ground over the mass
    contacts, steps, passes
        (n,) numbers of contacts, steps and passes of the iteration
    places : array, shape (n, k, 3)
        positions at the saved times; NaN before the start, after a failure or the last contact
        allowed, and of a grain that does not start
    success
        (n,) whether it is aloft at the end, stays on the ground, or did not start
    """

    status: Codes
    t: Array
    q: Array
    v: Array
    drag: Array
    contact: Array
    contacts: Codes
    steps: Codes
    passes: Codes
    places: Array

    @property
    def success(self) -> npt.NDArray[np.bool_]:
        return self.status < FAILED


# More parameters than elsewhere: the numbers of an experiment, which callers vary one by one.
def follow(
    method: Galerkin,
    q0: Array,
    v0: Array,
    t0: Array,
    rates: Array,
    drag: DragLaw,
    step: float | Array,
    until: float,
    *,
    gravity: float,
    saves: int = 0,
    ground: Ground = Ground(),
    wind: str = ROTOR_WIND,
    tolerance: float = TOLERANCE,
    threads: int | None = None,
) -> Flights:
    """Follow n grains from their starts to a common end, or to where they stay on the ground.

    Parameters
    ----------
    method
        Gauss collocation of up to 8 points, e.g. ``Galerkin(Polynomials(2), gauss(2))``
    q0, v0 : array, shape (n, 3)
        in m and m/s, z above the ground or on it with an upward velocity
    t0 : array, shape (n,)
        times of the starts in s, from 0 on; a grain does not start whose time is the end, up to
        rounding, or after it
    rates : array, shape (n, 1 + numbers of the drag law)
        none negative: factor over mass, then the law's numbers
    step
        s, one for all or (n,), each a whole fraction of ``until`` and of its saved parts: steps end
        at its multiples, so that the first one is shorter
    saves
        positions are saved at the ends of this number of equal parts of ``until``, and at 0
    tolerance
        tolerance of the iteration: for the change of the last pass, or the expected one of the
        next, relative to the velocities; it also ends where a change below 1e-11 is at least half
        the one before
    wind
        source lines that define ``wind`` in lanes, see brownout.grain_pass; it is also evaluated
        below the ground, where a step may end before it is repeated up to the contact

    Raises
    ------
    ValueError
        For bad input.
    KeyboardInterrupt
        After Ctrl-C.

    Notes
    -----
    A grain's numbers do not depend on the other grains, their order, lanes or threads.
    """
    _check_method(method)
    arrays = {"q0": q0, "v0": v0, "t0": t0, "rates": rates}
    q0, v0, t0, rates = (input_checks.array(name, values) for name, values in arrays.items())
    if not isinstance(ground, Ground):
        raise TypeError(f"ground must be a Ground; received {shown(ground)}.")
    gravity = input_checks.real("gravity", gravity)
    tolerance = input_checks.positive("tolerance", tolerance)
    saves = input_checks.whole("saves", saves, 0)
    if threads is not None:
        threads = input_checks.whole("threads", threads)
    if t0.ndim != 1:
        raise ValueError(f"t0 must have shape (grains,); received shape {t0.shape}.")
    n = t0.size
    steps = _step_counts(step, until, saves, n)
    _check_starts(q0, v0, t0, rates, drag, n)
    starts = np.concatenate([q0, v0], axis=1)
    clocks, counts = _times_and_counts(t0, until, steps)
    constants = np.zeros((n, 2))
    constants[:, : rates.shape[1]] = rates
    restitution = -1.0 if ground.restitution is None else float(ground.restitution)
    rules = (restitution, ground.slowest, float(ground.exact))
    ends, codes = np.full((n, 13), 0.0), np.zeros((n, 4), np.int64)
    places = np.full((n, saves + 1 if saves else 0, 3), np.nan)
    law, kept_alive = _compiled(wind, drag.rate.__name__, method.stages)
    numbers, kernel = _tables(method, gravity, tolerance), flight.compiled_fly()

    def batch(part: Any) -> None:
        (work,) = aligned((rows_of_grains(method.stages), LANES))
        save_every = int(steps[part][0]) // saves if saves else 1
        kernel(
            law,
            (starts[part], clocks[part], constants[part], counts[part]),
            method.stages,
            numbers,
            rules,
            save_every,
            work,
            (ends[part], codes[part], places[part]),
        )

    _run_batches(batch, _batches(steps), threads)
    del kept_alive
    return Flights(
        codes[:, 0],
        np.where(codes[:, 0] == ALOFT, until, ends[:, 6]),
        ends[:, :3],
        ends[:, 3:6],
        ends[:, 7:10],
        ends[:, 10:],
        codes[:, 1],
        codes[:, 2],
        codes[:, 3],
        places,
    )


def _run_batches(batch: Callable[[Any], None], parts: list[Any], threads: int | None) -> None:
    """Run all batches in threads; after Ctrl-C no new one begins, and KeyboardInterrupt is
    raised."""
    with defer_interrupts() as pressed:

        def run_batch(part: Any) -> None:
            if not pressed():
                batch(part)

        with ThreadPoolExecutor(threads or processors()) as pool:
            list(pool.map(run_batch, parts))
        if pressed():
            raise KeyboardInterrupt


def _batches(steps: Codes) -> list[Any]:
    """Slices of at most BATCH_GRAINS grains with steps of one size."""
    changes = np.flatnonzero(np.diff(steps)) + 1
    edges = np.unique(
        np.concatenate([[0], changes, np.arange(0, len(steps), BATCH_GRAINS), [len(steps)]])
    )
    return [slice(int(a), int(b)) for a, b in pairwise(edges)]


def _times_and_counts(t0: Array, until: float, steps: Codes) -> tuple[Array, Codes]:
    """Start and step (n, 2); the first step's end and the last time, in steps from 0, (n, 2).

    A start at the end of a step to rounding is moved there: k / n may differ from k (1 / n).
    """
    sizes, never_starts = until / steps, t0 >= until
    t = np.where(never_starts, 0.0, t0)
    nearest = np.rint(t / sizes)
    t = np.where(np.abs(t - nearest * sizes) <= 4.0 * np.spacing(t), nearest * sizes, t)
    first = nearest + (nearest * sizes <= t)
    first = np.where(never_starts, steps + 1, first).astype(np.int64)
    return np.stack([np.where(never_starts, t0, t), sizes], axis=1), np.stack(
        [first, steps], axis=1
    )


def _step_counts(step: float | Array, until: float, saves: int, n: int) -> Codes:
    """The number of steps from 0 to the end, (n,)."""
    until = input_checks.positive("until", until)
    sizes = input_checks.array("step", step)
    if sizes.shape not in ((), (n,)):
        raise ValueError(
            f"step must be a number or have shape {(n,)}; received shape {sizes.shape}. Give one "
            f"for each grain."
        )
    if not np.all(sizes > 0.0):
        raise ValueError(
            f"step must be positive; received {float(np.min(sizes))!r}. Give it in seconds."
        )
    if np.any(sizes < until / MOST_STEPS):
        raise ValueError(
            f"step must be at least until / {MOST_STEPS:.0e}; received {float(np.min(sizes))!r} "
            f"for {until!r}. Take a longer one."
        )
    sizes = np.broadcast_to(sizes, (n,))
    counts = np.rint(until / sizes).astype(np.int64)
    fits = np.abs(counts * sizes - until) <= 1e-9 * until
    if not np.all(fits & (counts % max(1, saves) == 0)):
        size = float(sizes[~(fits & (counts % max(1, saves) == 0))][0])
        raise ValueError(
            f"step must be a whole fraction of until and of its {max(1, saves)} saved parts; "
            f"received {size!r} for {until!r}. Take until / n with n a multiple of saves."
        )
    return counts


def _check_starts(q0: Array, v0: Array, t0: Array, rates: Array, drag: DragLaw, n: int) -> None:
    expected = {
        "q0": (q0, (n, 3)),
        "v0": (v0, (n, 3)),
        "t0": (t0, (n,)),
        "rates": (rates, (n, 1 + len(drag.numbers))),
    }
    for name, (array, shape) in expected.items():
        if array.shape != shape:
            raise ValueError(
                f"{name} must have shape {shape}; received {array.shape}. Give one row for each "
                f"grain."
            )
    if np.any(rates < 0.0):
        raise ValueError(
            f"rates must not be negative; received {float(np.min(rates))!r}. Drag acts against the "
            "motion through the air."
        )
    low = (q0[:, 2] < 0.0) | ((q0[:, 2] == 0.0) & (v0[:, 2] <= 0.0))
    if np.any(low) or np.any(t0 < 0.0):
        raise ValueError(
            "grains must start above the ground, or on it with an upward velocity, from t = 0 on; "
            f"received {int(np.sum(low | (t0 < 0.0)))} others. Leave them out."
        )


def _check_method(method: Galerkin) -> None:
    if not isinstance(method, Galerkin):
        raise TypeError(f"method must be a galvi.Galerkin; received {shown(method)}.")
    s = method.stages
    if s > MOST_POINTS:
        raise ValueError(
            f"grains take at most {MOST_POINTS} points; received {s}. Take fewer, and a "
            "shorter step."
        )
    if method.space != Polynomials(s) or method.rule.degree != 2 * s - 1:
        raise ValueError(
            f"grains take Gauss collocation; received {method.name}. Take "
            "galvi.Galerkin(galvi.Polynomials(s), galvi.gauss(s))."
        )


@lru_cache(maxsize=32)
def _compiled(wind: str, drag: str, s: int) -> tuple[Any, Any]:
    """The address of a compiled pass, and the function, which must be kept while it is used."""
    lines = f"from galvi.kernels.forces.rotor_wind import {drag} as drag\n"
    function = compiled_grain_pass(wind, lines, s)
    return addresses((function, PASS_OF_GRAINS)), function


@lru_cache(maxsize=32)
def _tables(method: Galerkin, gravity: float, tolerance: float) -> Array:
    """The numbers of benchmarks.applications.brownout.grain_pass; gravity in m/s^2, downwards."""
    table, s = method.table, method.stages
    (A, _), (B, _) = integrals_of(table)
    # the integrals of the polynomials through the stages, by powers of tau
    powers = np.linalg.inv(np.vander(table.c, increasing=True)) / np.arange(1, s + 1)[:, None]
    from_one_step = _extrapolation(table.c, 1.0 + table.c)
    from_two_steps = np.concatenate([np.zeros((s, s)), from_one_step], axis=1)
    if s <= TWO_STEP_POINTS:
        from_two_steps = _extrapolation(np.append(table.c - 1.0, table.c), 1.0 + table.c)
    parts = (
        B,
        A @ B,
        table.c,
        table.b,
        [-gravity, tolerance, -1.0 / DESCENT_TIME],
        powers,
        from_one_step,
        from_two_steps,
    )
    return np.concatenate([np.ravel(part) for part in parts])


def _extrapolation(times: Array, new_times: Array) -> Array:
    """The matrix from values of a polynomial of degree n - 1 at n times to those at new times."""
    n = len(times)
    return np.vander(new_times, n, increasing=True) @ np.linalg.inv(
        np.vander(times, n, increasing=True)
    )


@lru_cache(maxsize=64)
def compiled_grain_pass(wind: str, drag: str, s: int) -> Any:
    """`brownout.grain_pass` of s stages, with source lines that define ``wind`` and ``drag``;
    compiled at the first call."""
    version_line = (
        f"# {stamp(grain_pass.__file__)}\n"  # part of the digest, as cached code depends on it
    )
    source = code.with_digest(
        version_line + GRAIN_PASS_IMPORT + wind + drag + GRAIN_PASS_SOURCE.format(s=s)
    )
    return code.functions(source)["grain_pass"]
