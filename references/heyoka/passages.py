"""Where bodies are nearest to each other, by heyoka's events."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import lru_cache
from typing import Any

import numpy as np

from galvi import Problem
from galvi.arrays import Array
from references.engine_clock import engine_time
from references.heyoka import engine as heyoka_engine


def passages(
    problem: Problem, pairs: Sequence[tuple[int, int]], duration: float,
    setting: Mapping[str, Any] | None = None, *, sky: bool = False, precision: str = "double",
) -> tuple[Any, Array, Array]:  # fmt: skip
    """Least distances of pairs of bodies in three dimensions: the pair's number (k,), the time
    since the start (k,), and q_i - q_j (k, 3), in order of time.

    setting  tolerance, high_accuracy, compact_mode, as of `HeyokaTaylor`
    sky      distances are those seen from far away along x, while i is in front of j

    The integrator is compiled for its system and setting and kept: call once before timing.
    """
    number, system = heyoka_engine.kind(precision), problem.system
    options = heyoka_engine.switches(heyoka_engine.options(setting or {}, precision))
    law = (float(system.G), *system.masses.tolist())  # type: ignore[attr-defined]
    engine, found = _compiled(law, len(pairs), sky, precision, *options)
    found.clear()
    signs = np.zeros((len(pairs), len(law) - 1))
    for row, (i, j) in zip(signs, pairs, strict=True):
        row[[i, j]] = 1.0, -1.0
    engine.pars[:] = signs.ravel().astype(number)
    engine.reset_cooldowns()
    engine.time = number(0.0)
    engine.state[:] = np.concatenate([problem.q0, problem.v0], axis=1).ravel().astype(number)
    with engine_time:
        engine.propagate_until(number(duration))
    kept = [row for row in found if not sky or row[2][0] > 0.0]
    which: Any = np.array([row[0] for row in kept], dtype=np.int64)
    return which, np.array([row[1] for row in kept]), np.array([row[2] for row in kept])


@lru_cache(maxsize=16)
def _compiled(
    law: tuple[float, ...], pairs: int, sky: bool, precision: str, *options: Any
) -> tuple[Any, list[tuple[int, float, Array]]]:
    """heyoka's integrator, and the list to which its events are added; its parameters are the signs
    with which bodies' places add to the vector of each pair."""
    import heyoka

    number, found = heyoka_engine.kind(precision), []
    tolerance, accurate, compact = options
    equations = heyoka.model.nbody(
        len(law) - 1, Gconst=number(law[0]), masses=[number(m) for m in law[1:]]
    )
    symbols, bodies = [pair[0] for pair in equations], len(law) - 1

    def event(which: int) -> Any:
        own = slice(which * bodies, (which + 1) * bodies)

        def seen(integrator: Any, t: Any, sign: int) -> None:
            state = integrator.update_d_output(t).astype(np.float64).reshape(-1, 6)
            signs = integrator.pars[own].astype(np.float64)
            found.append((which, float(t), signs @ state[:, :3]))

        gap = [
            heyoka.sum([heyoka.par[own.start + b] * symbols[6 * b + k] for b in range(bodies)])
            for k in range(6)
        ]
        rate = heyoka.sum([gap[k] * gap[k + 3] for k in range(int(sky), 3)])
        return heyoka.nt_event(
            rate, seen, fp_type=number, direction=heyoka.event_direction.positive
        )

    engine = heyoka.taylor_adaptive(
        equations, np.zeros(len(symbols)).astype(number), time=number(0.0), tol=number(tolerance),
        high_accuracy=accurate, compact_mode=compact, fp_type=number,
        nt_events=[event(which) for which in range(pairs)],
    )  # fmt: skip
    return engine, found
