"""Fixed-point iteration of one step of point masses, in vector instructions.

Arrays as in `galvi.fast.lanes.nbody`: moves begins with h^2 A^T; Q, a, base, low and background
are (d, P). The first pass over all bodies is followed by some over two bodies alone, the star and
the planet that moves fastest relative to its distance, which extrapolation predicts by far the
worst: for the Sun and planets, the innermost to 1e-4, the next to 1e-10
(`benchmarks.experiments.solver_ideas`). These passes only improve the guess. Iterations and force
evaluations count the passes over all bodies; the PAIR_PASSES + 1 evaluations of the single pair are
counted as PAIRS.
"""

from __future__ import annotations

import math

from galvi.fast.lanes import gravity
from galvi.fast.lanes.celestial import add_terms
from galvi.kernels.compile.jit import jit_inline
from galvi.kernels.nystrom import solve

PAIR_PASSES = 3  # 2 and 4 are slower for some problems: docs/solver-experiments.md


@jit_inline
def pull_all(axes, masses, heavy, light, Q, a):
    """a <- accelerations at stages Q, adding the attractions of the last pairs first."""
    for k in range(heavy.size - 1, -1, -1):
        for chunk in range(Q.shape[1] // gravity.LANES):
            gravity.attract(axes, Q, a, masses, heavy, k, Q.shape[1], chunk)
    for k in range(light.size):
        for chunk in range(Q.shape[1] // gravity.LANES):
            gravity.follow(axes, Q, a, masses, heavy, light[k], Q.shape[1], chunk)


@jit_inline
def pull_and_measure(axes, masses, heavy, light, Q, a, nearest):
    """As ``pull_all``; nearest (P,) <- the least squared distance of two bodies at each stage."""
    for k in range(Q.shape[1]):
        nearest[k] = math.inf
    for k in range(heavy.size - 1, -1, -1):
        for chunk in range(Q.shape[1] // gravity.LANES):
            gravity.attract_and_measure(axes, Q, a, masses, heavy, k, Q.shape[1], chunk, nearest)
    for k in range(light.size):
        for chunk in range(Q.shape[1] // gravity.LANES):
            gravity.follow_and_measure(
                axes, Q, a, masses, heavy, light[k], Q.shape[1], chunk, nearest
            )


@jit_inline
def pull_pair(axes, masses, star, fastest_planet, sign, Q, given, a):
    """a <- given + sign times the attraction between two bodies, in their rows."""
    star_mass, planet_mass = sign * masses[star], sign * masses[fastest_planet]
    for chunk in range(Q.shape[1] // gravity.LANES):
        gravity.attract_pair(
            axes, Q, given, a, star, fastest_planet, star_mass, planet_mass, Q.shape[1], chunk
        )


@jit_inline
def move_one(axes, moves, start, s, a, base, low, state, Q, change, size, body):
    """Q <- q + (base + (low + h^2 A a)) of one body; returns the largest change so far."""
    for chunk in range(Q.shape[1] // gravity.LANES):
        change = gravity.move(
            axes, moves, start, a, base, low, state, Q, change, size, body, s, Q.shape[1], chunk
        )
    return change


@jit_inline
def iterate_pair(
    axes, masses, star, fastest_planet, moves, s, state, base, low, sizes, Q, a, background, history
):
    """Some passes over the star and one planet, the attraction of all others in ``background``.

    Extrapolation predicts the fastest planet by far the worst, and these passes are cheap. They
    contract like the passes over all bodies, which continue from their result.
    """
    last, change = history[0], history[0]
    for _passes in range(PAIR_PASSES):
        last = change
        pull_pair(axes, masses, star, fastest_planet, 1.0, Q, background, a)
        change = move_one(axes, moves, 0, s, a, base, low, state, Q, 0.0, sizes[star], star)
        change = move_one(
            axes, moves, 0, s, a, base, low, state, Q, change, sizes[fastest_planet], fastest_planet
        )
    solve.reset_history(history)
    if change > 0.0:
        history[0], history[1] = change, change / last


@jit_inline
def iterate(axes, masses, heavy, light, pulls, poles, star, fastest_planet, moves, s, state, base,
            low, sizes, tolerance, counts, Q, a, background, history, nearest):  # fmt: skip
    """Fixed-point iteration from stages Q until convergence; a holds the last accelerations.

    ``background`` is scratch, (d, P). nearest (P,) <- least squared distances at the stages, from
    the second pass, which is accurate enough for that; 0 if there is none.
    """
    nearest[0] = 0.0
    solve.reset_history(history)
    for passes in range(solve.FIXED_POINT_PASSES):
        if passes == 1:
            pull_and_measure(axes, masses, heavy, light, Q, a, nearest)
        else:
            pull_all(axes, masses, heavy, light, Q, a)
        add_terms(axes, pulls, poles, s, Q, a)
        with_pair = passes == 0 and masses.size > 2
        if with_pair:
            pull_pair(axes, masses, star, fastest_planet, -1.0, Q, a, background)
            counts[solve.PAIRS] += (PAIR_PASSES + 1) * s
        change = 0.0
        for body in range(masses.size):
            change = move_one(axes, moves, 0, s, a, base, low, state, Q, change, sizes[body], body)
        counts[solve.ITERATIONS] += 1
        counts[solve.FORCES] += s
        code = solve.verdict(change, tolerance, history)
        if code != solve.GOING:
            return code
        if with_pair:
            iterate_pair(
                axes,
                masses,
                star,
                fastest_planet,
                moves,
                s,
                state,
                base,
                low,
                sizes,
                Q,
                a,
                background,
                history,
            )
    return solve.DIVERGED
