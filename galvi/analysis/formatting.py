"""Formats a `Theory` as text."""

from __future__ import annotations

from collections.abc import Iterator
from math import inf
from typing import Any

LIMITS = (
    ("unique_motion_step", "", "the exact motion is unique (M theorem 1)"),
    ("unique_step", "exists", "a step has exactly one solution (M theorem 2)"),
    ("stage_step", "", "H's iteration contracts (H theorem 2.3.1)"),
    ("minimum_step", "minimizes", "a step's curve is a minimum (H theorem 2.3.5)"),
    ("coercive_step", "coercive", "the exact action is coercive (H theorem 2.3.8)"),
    ("fixed_point_step", "converges", "fixed-point iteration contracts (spectrum)"),
)


def sentences(theory: Any) -> str:
    """The text of a `Theory`: order and symmetry, constants and, with a problem, step bounds."""
    return "\n".join(_lines(theory))


def _lines(theory: Any) -> Iterator[str]:
    known = f" = {theory.name}" if theory.name else ""
    yield f"{theory.space} with {theory.rule}{known}"
    yield _verdict(theory)
    if theory.order:
        yield (
            f"order {theory.order} at step ends, {theory.curve_order} on the curve, limited by the "
            f"{theory.limited_by}"
        )
    if theory.friedrichs is not None:
        yield (
            f"C_N {theory.friedrichs:.4f}, lambda_N {theory.smallest_ratio:.4f}, "
            f"Lambda_N {theory.largest_ratio:.4f}"
        )
    if theory.frame:
        yield theory.frame
    if theory.problem is None:
        return
    if theory.lipschitz is None:
        yield f"{theory.problem}: no bounds on the step: {theory.reasons['lipschitz']}"
        return
    yield f"{theory.problem}: Lipschitz constant {theory.lipschitz:.4g}, {theory.source}"
    yield from _limits(theory)


def _verdict(theory: Any) -> str:
    if not theory.well_posed:
        return "ill-posed: a free particle has no unique motion"
    if not theory.consistent:
        return f"well posed, inconsistent: a free particle is off by {theory.defect:.1e} of a step"
    symmetry = {True: ", symmetric", False: ", not symmetric", None: ""}[theory.symmetric]
    return f"well posed, consistent{symmetry}"


def _limits(theory: Any) -> Iterator[str]:
    for name, holds, words in LIMITS:
        limit = getattr(theory, name)
        if limit is None:
            yield f"no bound      {theory.reasons[name]}"
            continue
        line = f"{'any step' if limit == inf else f'h < {limit:.4g}':<14}{words}"
        if holds and theory.step is not None:
            line += f": {'yes' if getattr(theory, holds) else 'not said'} at {theory.step:g}"
        yield line
