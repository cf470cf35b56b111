"""The theory of a method in a moving frame."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from galvi.analysis.motion_theory import AT_A_STEP, BOUNDS
from galvi.problem import Problem

VARIATIONAL = (
    "Hamilton's principle in phase space, in coordinates that move with the flow: every step is "
    "symplectic once its passes have converged, of order {order} in h"
)
ELSEWHERE = "the bounds of M and H are for curves in the inertial frame."
MOVED = (
    "its nodes are placed by the orbit at the start of a run: with the same nodes forward and "
    "backward steps cancel, from another start they differ by the error of the step."
)


def in_frame(
    pair: Mapping[str, Any], method: Any, problem: Problem | None, step: float | None
) -> dict[str, Any]:
    """The fields of a `Theory` of a method in a frame, from those of its space and rule."""
    frame = method.chart
    reasons = {name: why for name, why in pair["reasons"].items() if name != "spectral_radius"}
    reasons["spectral_radius"] = "the frame's equations are of first order, without this tableau."
    symmetric = pair["symmetric"]
    if not frame.reversible:
        symmetric, reasons["symmetric"] = None, MOVED
    about: dict[str, Any] = {}
    if problem is not None:
        about = {
            "problem": problem.name or type(problem.system).__name__, "units": problem.units,
            "step": None if step is None else float(step),
        }  # fmt: skip
        reasons.update(dict.fromkeys(("lipschitz", "frequency", *BOUNDS, *AT_A_STEP), ELSEWHERE))
    said = f"{VARIATIONAL.format(order=pair['order'])}; {frame.keeps}"
    changed = {"symmetric": symmetric, "name": method.name, "names": (method.name,)}
    none = {"spectral_radius": None, "reasons": reasons, "frame": said}
    return {**pair, **changed, **about, **none}
