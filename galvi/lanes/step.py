"""A step in lanes: the iteration that laws on R^d and on groups share.

A step is an object with

rows            a layout of galvi.lanes.layouts
rule            a stopping rule of galvi.lanes.stopping
velocity_row    first row of work for the velocities at the stages
series_row      first row of work for the velocities of the last step, or for the coefficients of
                their series
guess_row       first row of work for a guess of the velocities
time_row        row of work for the times of the stages
prepare()       does the work that is needed once for a run
begin(convergence)  sets the initial stages of a step, from the velocities
one_pass(first)     does a pass and notes the largest change; ``first`` is an LLVM truth value:
                    whether it is the first pass of the step
after_first_pass(convergence, change)  sets the sizes to which changes are relative
add_low_parts(chosen)  adds the low parts of the tables times the slopes, for the runs ``chosen``
ends()          returns [(field, i, number at the step's end), ...], and for which runs the step is
                valid
"""

from __future__ import annotations

import math

from galvi.kernels.compile.internals import cgutils
from galvi.kernels.lie.arithmetic import larger
from galvi.kernels.nystrom.solve import FIXED_POINT_PASSES
from galvi.lanes.stopping import Convergence, Mask, terms_of_guess
from galvi.lanes.vectors import address_intrinsic

PREPARE, STEP = range(2)  # parts of a step
# Largest ratio of guessed velocities to those of the last step with the same number of terms.
LARGEST_GUESS_RATIO = 64.0


def extrapolate(step):
    """Extrapolate the velocities of the last step by a Legendre series of the chosen length.

    The number of terms is chosen every ``choice_interval`` steps, and again where the guess is more
    than LARGEST_GUESS_RATIO times the velocities: if rounding made a guess 1e10 times too large,
    all changes would be small relative to it, and the iteration would end at once.
    """
    rows, builder, guess = step.rows, step.rows.builder, step.guess_row
    to_choose, alive = Mask(builder, rows.runs), rows.field("alive") > 0.0
    if rows.choice_interval == 1:
        choose_terms(step, alive)
        rows.extrapolate(step.velocity_row, step.series_row, step.velocity_row)
        return
    remainder = builder.urem(rows.number, rows.row(rows.choice_interval))
    is_due = rows.spread_bit(builder.icmp_unsigned("==", remainder, rows.row(0)))
    to_choose.set(alive & (is_due | (rows.field("terms") < 1.0)))
    if rows.ahead_holds_A:
        choose_terms(step, to_choose.value)
        return
    with cgutils.for_range(builder, rows.row(2), intp=rows.row) as loop:
        choose_terms(step, to_choose.value)
        rows.extrapolate(step.velocity_row, step.series_row, guess)
        before, after = (
            rows.largest_of(range(first, first + rows.d)) for first in (step.velocity_row, guess)
        )
        to_choose.set(~(after <= LARGEST_GUESS_RATIO * before))
        with builder.if_then((~to_choose.value).all):
            loop.do_break()
    rows.chunks(
        lambda lanes: rows.store_rows(lanes, rows.load_rows(lanes, guess), step.velocity_row)
    )


def choose_terms(step, chosen):
    """Choose the number of terms to extrapolate for the runs ``chosen``."""
    rows = step.rows

    def measure(lanes):
        largest, series = rows.zero(), rows.series_of(lanes, step.velocity_row)
        for coefficient in series:
            largest = larger(abs(coefficient), largest)
        rows.keep_series(lanes, series, step.series_row)
        rows.store_row(lanes, largest, step.time_row)

    with rows.builder.if_then(chosen.any):
        rows.chunks(measure)
        terms = terms_of_guess(rows, lambda index: rows.stage_number(step.time_row, index))
        rows.keep_where(chosen, "terms", terms)


def iterate(step, convergence):
    """Iterate until no run is active, in at most FIXED_POINT_PASSES passes."""
    rows, builder = step.rows, step.rows.builder
    convergence.begin(rows.field("alive") > 0.0)
    passes, tolerance = rows.variable(), rows.real(rows.terms)
    with cgutils.for_range(builder, rows.row(FIXED_POINT_PASSES), intp=rows.row) as loop:
        passes_before = passes.lane
        passes.set((passes_before + 1.0).where(convergence.active.value, passes_before))
        rows.reset_change()
        first = builder.icmp_unsigned("==", loop.index, rows.row(0))
        step.one_pass(first)
        change = rows.change()
        with builder.if_else(first) as (at_first, later):
            with at_first:
                step.after_first_pass(convergence, change)
            with later:
                convergence.update(change, tolerance)
        with builder.if_then(convergence.settles.value.any):
            step.add_low_parts(convergence.settles.value)
        with builder.if_then((~convergence.active.value).all):
            loop.do_break()
    rows.keep("passes", rows.field("passes") + passes.lane)


def one_step(step, convergence):
    """Do a step of all runs that are alive; a run whose step fails keeps its state and is no longer
    alive."""
    rows, builder = step.rows, step.rows.builder
    convergence.active.set(rows.field("alive") > 0.0)
    rows.remember(step.velocity_row, step.series_row)
    with builder.if_then(builder.icmp_unsigned("!=", rows.continues, rows.row(0))):
        extrapolate(step)
    rows.store_times(step.time_row)
    step.begin(convergence)
    iterate(step, convergence)
    end_rows, within = step.ends()
    absolute_sum = rows.variable().lane
    for name, _, number in end_rows:
        if name in ("q", "p"):
            absolute_sum = absolute_sum + abs(number)
    finished, failed = convergence.end(absolute_sum < math.inf, within)
    for name, i, number in end_rows:
        rows.keep_where(finished, name, number, i)
    rows.keep_where(failed, "alive", 0.0)
    rows.keep_where(failed, "failed", rows.integer_as_real(rows.number) + 1.0)
    rows.keep_where(failed, "code", convergence.code.lane)


def step_intrinsic(make_step):
    """An intrinsic of the address of the arguments of galvi.lanes.layouts, which runs the part of a
    step that these name.

    Parameters
    ----------
    make_step
        (context, builder, arguments) -> a step, see the docstring of the module
    """

    def parts(context, builder, arguments):
        step = make_step(context, builder, arguments)
        convergence = Convergence(builder, step.rule, step.rows.runs)
        step.rows.active = convergence.active
        for number, part in ((PREPARE, step.prepare), (STEP, lambda: one_step(step, convergence))):
            selected = builder.icmp_unsigned("==", step.rows.part, step.rows.row(number))
            with builder.if_then(selected):
                part()

    return address_intrinsic(parts)
