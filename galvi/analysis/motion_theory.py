"""The part of the theory of a method that depends on the problem: bounds on the step."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from galvi.analysis import step_bounds
from galvi.analysis.friedrichs import Z0
from galvi.analysis.step_bounds import Bound
from galvi.analysis.stiffness import Stiffness, estimated, given
from galvi.problem import Problem
from galvi.rules.rule import Rule
from galvi.spaces.space import Space
from galvi.systems.component_degrees import checked_degrees

STEPS = 10.0  # number of steps along which K is estimated
BOUNDS = (
    "unique_motion_step",
    "unique_step",
    "stage_step",
    "minimum_step",
    "coercive_step",
    "fixed_point_step",
)
AT_A_STEP = (
    "contraction",
    "spectral_contraction",
    "exists",
    "minimizes",
    "coercive",
    "converges",
)


def motion_theory(
    space: Space,
    rule: Rule,
    pair: Mapping[str, Any],
    problem: Problem,
    step: float | None,
    lipschitz: float | None,
) -> dict[str, Any]:
    """The fields of a `Theory` that depend on the problem, and the reasons for those that are None.

    pair  the fields that depend on space and rule alone

    Raises ValueError for a space with degrees for components that the problem does not have.
    """
    found: dict[str, Any] = {
        "problem": problem.name or type(problem.system).__name__,
        "units": problem.units,
        "step": None if step is None else float(step),
    }
    checked_degrees(space, problem.system, problem.v0.size)
    changed: dict[str, Any] = {}
    reasons: dict[str, str] = {}
    if pair["symmetric"] and not _commutes(problem.system):
        changed["symmetric"] = None
        reasons["symmetric"] = (
            "on a group a step's chart is based at its start: forward and backward steps differ by "
            "an error of order 2 s + 1."
        )
    stiffness, why = _stiffness(problem, step, lipschitz)
    if stiffness is None:
        none = ("lipschitz", "frequency", *BOUNDS, *AT_A_STEP)
        return {**found, **changed, "reasons": {**reasons, **dict.fromkeys(none, why)}}
    bounds = _bounds(space, rule, pair, stiffness)
    reasons.update({name: bound.reason for name, bound in bounds.items() if bound.step is None})
    found.update({name: bound.step for name, bound in bounds.items()})
    found.update(
        lipschitz=stiffness.lipschitz, source=stiffness.source, frequency=stiffness.frequency
    )
    if step is None:
        reasons.update(dict.fromkeys(AT_A_STEP, "no step was given."))
    else:
        found.update(_at_a_step(abs(float(step)), stiffness, pair, bounds, reasons))
    return {**found, **changed, "reasons": reasons}


def _stiffness(
    problem: Problem, step: float | None, lipschitz: float | None
) -> tuple[Stiffness | None, str]:
    """The stiffness, and why it is None."""
    if not hasattr(problem.system, "acceleration_jacobian"):
        return None, (
            f"the theorems are for L = v.M v / 2 - V on a vector space, not for a "
            f"{type(problem.system).__name__}."
        )
    if getattr(problem.system, "force", None) is not None:
        return None, "the theorems are for forces that have a potential; here is one besides."
    if lipschitz is not None:
        return given(problem, float(lipschitz)), ""
    return estimated(problem, None if step is None else STEPS * float(step))


def _commutes(system: Any) -> bool:
    """Whether the group is commutative, so that a chart's base does not matter."""
    layout = system.group.layout if hasattr(system, "group") else []
    return all(rotations == 0 or d == 1 for _, d, _, rotations in layout)


def _bounds(
    space: Space, rule: Rule, pair: Mapping[str, Any], stiffness: Stiffness
) -> dict[str, Bound]:
    found = (
        step_bounds.unique_motion(stiffness),
        step_bounds.unique_step(stiffness, pair["friedrichs"]),
        step_bounds.contracting_stages(space, rule, stiffness),
        step_bounds.minimal_action(space, rule, stiffness),
        step_bounds.coercive_action(stiffness),
        step_bounds.converging_passes(
            stiffness, pair["spectral_radius"], pair["reasons"].get("spectral_radius", "")
        ),
    )
    return dict(zip(BOUNDS, found, strict=True))


def _at_a_step(
    h: float,
    stiffness: Stiffness,
    pair: Mapping[str, Any],
    bounds: Mapping[str, Bound],
    reasons: dict[str, str],
) -> dict[str, Any]:
    found: dict[str, Any] = {}
    for name, limit in (
        ("exists", "unique_step"),
        ("minimizes", "minimum_step"),
        ("coercive", "coercive_step"),
        ("converges", "fixed_point_step"),
    ):
        bound = bounds[limit]
        found[name] = None if bound.step is None else h < bound.step
        if bound.step is None:
            reasons[name] = bound.reason
    eta = step_bounds.CAUTION * stiffness.square * (h / Z0) ** 2
    C, radius = pair["friedrichs"], pair["spectral_radius"]
    found["contraction"] = None if C is None else eta * C**2
    found["spectral_contraction"] = None if radius is None else h * h * stiffness.square * radius
    for name, constant in (
        ("contraction", "friedrichs"),
        ("spectral_contraction", "spectral_radius"),
    ):
        if found[name] is None:
            reasons[name] = pair["reasons"][constant]
    return found
