"""A step of an iteration in lanes: what laws on R^d and on groups share.

A kind of step is an object with

rows            a layout of galvi.lanes.layouts, and in its record the fields named there
rule            what ends the passes, of galvi.lanes.stopping
velocity_row    the first rows of work for velocities at the stages, for those of the last step or
series_row      the coefficients of their series, and for a guess of them; the row of times
guess_row
time_row
prepare()       does what is needed once a run
begin()         first stages of a step, from the velocities
one_pass(first) a pass, which notes the largest change; ``first`` of its step or not
after_first_pass(convergence)   the sizes to which changes are relative
add_low_parts(chosen)         adds what the low parts of the tables make of the rates, for some runs
ends()          [(field, i, its number at the step's end), ...], and whether that is within reach
"""

from __future__ import annotations

import math

from galvi.kernels.compile.internals import cgutils
from galvi.kernels.lie.arithmetic import larger
from galvi.kernels.nystrom.solve import FIXED_POINT_PASSES
from galvi.lanes.stopping import Convergence, Mask, terms_kept
from galvi.lanes.vectors import of_address

PREPARE, STEP = range(2)  # parts
LARGEST_GUESS = 64.0  # over the velocities before, above which its terms are chosen anew


def extrapolate(kind):
    """Extrapolate the velocities of the last step by a Legendre series of the chosen length.

    The number of terms is chosen in some steps, and anew where the guess is LARGEST_GUESS times the
    velocities: sizes from a guess that rounding made 1e10 times too large would make any change
    small, and end the iteration before it began.
    """
    rows, builder, guess = kind.rows, kind.rows.builder, kind.guess_row
    chosen, alive = Mask(builder, rows.runs), rows.field("alive") > 0.0
    if rows.reconsider == 1:
        choose_terms(kind, alive)
        rows.extrapolate(kind.velocity_row, kind.series_row, kind.velocity_row)
        return
    remainder = builder.urem(rows.number, rows.row(rows.reconsider))
    due = rows.for_all(builder.icmp_unsigned("==", remainder, rows.row(0)))
    chosen.set(alive & (due | (rows.field("terms") < 1.0)))
    if rows.merged:
        choose_terms(kind, chosen.value)
        return
    with cgutils.for_range(builder, rows.row(2), intp=rows.row) as loop:
        choose_terms(kind, chosen.value)
        rows.extrapolate(kind.velocity_row, kind.series_row, guess)
        before, after = (
            rows.largest_of(range(first, first + rows.d)) for first in (kind.velocity_row, guess)
        )
        chosen.set(~(after <= LARGEST_GUESS * before))
        with builder.if_then((~chosen.value).all):
            loop.do_break()
    rows.chunks(
        lambda lanes: rows.store_rows(lanes, rows.load_rows(lanes, guess), kind.velocity_row)
    )


def choose_terms(kind, chosen):
    """Choose the number of terms to extrapolate for the runs ``chosen``."""
    rows = kind.rows

    def measure(lanes):
        largest, series = rows.zero(), rows.series(lanes, kind.velocity_row)
        for coefficient in series:
            largest = larger(abs(coefficient), largest)
        rows.keep_series(lanes, series, kind.series_row)
        rows.store_row(lanes, largest, kind.time_row)

    with rows.builder.if_then(chosen.any):
        rows.chunks(measure)
        terms = terms_kept(rows, lambda index: rows.stage_number(kind.time_row, index))
        rows.keep_where(chosen, "terms", terms)


def iterate(kind, convergence):
    """Iterate until no run is active."""
    rows, builder = kind.rows, kind.rows.builder
    convergence.begin(rows.field("alive") > 0.0)
    passes, tolerance = rows.variable(), rows.real(rows.terms)
    with cgutils.for_range(builder, rows.row(FIXED_POINT_PASSES), intp=rows.row) as loop:
        counted = passes.lane
        passes.set((counted + 1.0).where(convergence.active.value, counted))
        rows.forget()
        first = builder.icmp_unsigned("==", loop.index, rows.row(0))
        kind.one_pass(first)
        change = rows.change()
        with builder.if_else(first) as (at_first, later):
            with at_first:
                kind.after_first_pass(convergence, change)
            with later:
                convergence.judge(change, tolerance)
        with builder.if_then(convergence.settles.value.any):
            kind.add_low_parts(convergence.settles.value)
        with builder.if_then((~convergence.active.value).all):
            loop.do_break()
    rows.keep("passes", rows.field("passes") + passes.lane)


def one_step(kind, convergence):
    """Do a step of all runs that are alive; a run whose step fails keeps its state and ends."""
    rows, builder = kind.rows, kind.rows.builder
    convergence.active.set(rows.field("alive") > 0.0)
    rows.remember(kind.velocity_row, kind.series_row)
    with builder.if_then(builder.icmp_unsigned("!=", rows.continues, rows.row(0))):
        extrapolate(kind)
    rows.times(kind.time_row)
    kind.begin(convergence)
    iterate(kind, convergence)
    ends, within = kind.ends()
    total = rows.variable().lane
    for name, _, number in ends:
        if name in ("q", "p"):
            total = total + abs(number)
    finished, lost = convergence.end(total < math.inf, within)
    for name, i, number in ends:
        rows.keep_where(finished, name, number, i)
    rows.keep_where(lost, "alive", 0.0)
    rows.keep_where(lost, "failed", rows.whole_number(rows.number) + 1.0)
    rows.keep_where(lost, "code", convergence.code.lane)


def generated(kind):
    """An intrinsic of the address of the arguments of galvi.lanes.layouts: a step's parts.

    Parameters
    ----------
    kind
        (context, builder, arguments) -> a kind of step
    """

    def parts(context, builder, arguments):
        step = kind(context, builder, arguments)
        convergence = Convergence(builder, step.rule, step.rows.runs)
        step.rows.active = convergence.active
        for number, part in ((PREPARE, step.prepare), (STEP, lambda: one_step(step, convergence))):
            selected = builder.icmp_unsigned("==", step.rows.part, step.rows.row(number))
            with builder.if_then(selected):
                part()

    return of_address(parts)
