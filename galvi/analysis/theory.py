"""What theory says of a method: order, symmetry, constants, its classical name."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field, fields
from math import inf
from types import MappingProxyType
from typing import Any

import numpy as np

from galvi import input_checks
from galvi.analysis.step_bounds import AT_A_STEP, BOUNDS, Z0, motion_theory, norms
from galvi.input_checks import shown
from galvi.problem import Problem
from galvi.properties.properties import classical_names, is_symmetric, orders
from galvi.rules.rule import Rule
from galvi.spaces.space import Space, checked
from galvi.systems.canonical import Canonical
from galvi.systems.nbody import NBody
from galvi.tableau import assemble


@dataclass(frozen=True)
class Theory:
    """Theoretical properties of a space and a rule, also of a pair that `galvi.Galerkin` refuses.

    space, rule        their names
    well_posed         a free particle has a unique motion: |u|_{X,N} is a norm (M lemma 1)
    unseen             number of independent functions that the rule cannot tell from 0
    consistent         that motion is a straight line to 1e-13
    defect             largest of |alpha_k - c_k| and |beta_p - 1|, of a step
    friedrichs         C_N of |u|_{0,N} <= C_N (h / z0) |u|_{X,N} (M 11)
    smallest_ratio     lambda_N of lambda_N |u|_X <= |u|_{X,N} (M 12)
    largest_ratio      Lambda_N of |u|_{X,N} <= Lambda_N |u|_X (M 12)
    seminorm_ratio     largest |u'|_{0,N} / |u'|_0 (M section 5)
    z0                 smallest positive root of 1 = z tan z (M section 2)
    order              at step ends, on smooth problems; 0 for a refused pair
    curve_order        of positions between step ends
    limited_by         "space", "rule for the force" or "rule for the kinetic energy"; "" for a
                       refused pair
    symmetric          a step forward and a step backward cancel
    name, names        the best known classical name, "" for none; all of them. With a problem those
                       that hold for it, without one those that hold for every Lagrangian
    spectral_radius    rho(A) of the Nystrom tableau
    frame              what holds in a moving frame, a sentence; "" for other methods

    With a problem, in its units; the theorems ask for a K that holds everywhere:

    problem, units, step   as given
    lipschitz              K, of dV/dq
    source                 of K: given, or how it was estimated (from below, near the start)
    frequency              sqrt(K / m), or when estimated the largest of M^-1 V''
    unique_motion_step     M theorem 1, 3 K h^2 / (m z0^2) < 1
    unique_step            M theorem 2, that times C_N^2
    stage_step             H theorem 2.3.1, and at most 1
    minimum_step           H theorem 2.3.5, pi sqrt(m / (D C_R))
    coercive_step          H theorem 2.3.8, pi sqrt(m / (2 D C_R))
    fixed_point_step       where h^2 rho(A) frequency^2 = 1
    contraction            eta C_N^2 at the step: the bound of M on a pass (M theorem 2)
    spectral_contraction   h^2 rho(A) frequency^2: what passes tend to
    exists                 the step is guaranteed to have exactly one solution (M theorem 2)
    minimizes, coercive    the steps' curves are minima (H 2.3.5), the action coercive (2.3.8)
    converges              fixed-point iteration contracts near a solution

    A field that does not apply or was not requested is None; ``reasons`` says why.
    """

    space: str
    rule: str
    well_posed: bool
    unseen: int | None
    consistent: bool
    defect: float
    friedrichs: float | None
    smallest_ratio: float | None
    largest_ratio: float | None
    seminorm_ratio: float | None
    order: int
    curve_order: int
    limited_by: str
    symmetric: bool | None
    name: str
    names: tuple[str, ...]
    spectral_radius: float | None
    z0: float = Z0
    problem: str | None = None
    units: str = ""
    step: float | None = None
    lipschitz: float | None = None
    source: str = ""
    frequency: float | None = None
    unique_motion_step: float | None = None
    unique_step: float | None = None
    stage_step: float | None = None
    minimum_step: float | None = None
    coercive_step: float | None = None
    fixed_point_step: float | None = None
    contraction: float | None = None
    spectral_contraction: float | None = None
    exists: bool | None = None
    minimizes: bool | None = None
    coercive: bool | None = None
    converges: bool | None = None
    reasons: Mapping[str, str] = field(default_factory=dict)
    frame: str = ""

    def __post_init__(self) -> None:
        object.__setattr__(self, "reasons", MappingProxyType(dict(self.reasons)))

    def __str__(self) -> str:
        return sentences(self)

    def to_dict(self) -> dict[str, Any]:
        """Field name -> value, in plain Python types."""
        values = {one.name: getattr(self, one.name) for one in fields(self)}
        return {**values, "names": list(self.names), "reasons": dict(self.reasons)}


def theory(
    method: Any,
    rule: Rule | None = None,
    problem: Problem | None = None,
    step: float | None = None,
    lipschitz: float | None = None,
) -> Theory:
    """The theory of a method, or of a space and a rule, and of a step on a problem.

    method     a `galvi.Galerkin`, or a space
    rule       quadrature rule when ``method`` is a space
    problem    the problem whose force bounds the step
    step       in the problem's unit of time, negative for backwards
    lipschitz  Lipschitz constant K of dV/dq; None: estimated along a short trajectory

    Raises TypeError for an argument of another type, ValueError for a step or a lipschitz without a
    problem, for a number that is zero or not finite, and for a negative lipschitz.
    """
    space, rule = _pair(method, rule)
    _check(problem, step, lipschitz)
    of_pair = _of_pair(space, rule, _is_separable(problem))
    if getattr(method, "in_frame", False):
        return Theory(**in_frame(of_pair, method, problem, step))
    if problem is None:
        return Theory(**of_pair)
    if getattr(method, "clock", None) is not None:
        raise ValueError(
            f"the bounds of a step are those of steps constant in time; received a method with the "
            f"clock {method.clock}. Leave the clock out, or the problem."
        )
    more = motion_theory(space, rule, of_pair, problem, step, lipschitz)
    reasons = {**of_pair["reasons"], **more["reasons"]}
    return Theory(**{**of_pair, **more, "reasons": reasons})


def _is_separable(problem: Problem | None) -> bool:
    """Whether L is that of a constant mass and of a potential, without other forces."""
    system: Any = None if problem is None else problem.system
    if isinstance(system, NBody):
        return bool(system.acting.conserve)
    return isinstance(system, Canonical) and system.force is None


def _of_pair(space: Space, rule: Rule, separable: bool) -> dict[str, Any]:
    pair, size, found = assemble(space, rule), norms(space, rule), orders(space, rule)
    reasons: dict[str, str] = {}
    constants: dict[str, float | None] = dict.fromkeys(
        ("friedrichs", "smallest_ratio", "largest_ratio", "seminorm_ratio")
    )
    if size is None:
        why = "the basis functions are too nearly dependent to tell the constant in float64."
        reasons.update(dict.fromkeys(("unseen", *constants), why))
    else:
        constants.update(
            smallest_ratio=size.lowest, largest_ratio=size.highest, seminorm_ratio=size.seminorm[1]
        )
        if np.isfinite(size.C):
            constants["friedrichs"] = size.C
        else:
            reasons["friedrichs"] = "no constant bounds a function that the rule cannot see."
    names: tuple[str, ...] = ()
    symmetric = radius = None
    if pair.table is None:
        for name in ("symmetric", "spectral_radius"):
            reasons[name] = "an ill-posed pair makes no step."
    else:
        symmetric = is_symmetric(pair.table, rule)
        if len(set(getattr(space, "degrees", (space.degree,)))) > 1:
            reasons["spectral_radius"] = "components of different degrees have no common tableau."
        else:
            radius = float(np.max(np.abs(np.linalg.eigvals(pair.table.A))))
            names = classical_names(pair.table, separable) if pair.consistent else ()
    return {
        "space": str(space), "rule": rule.name, "well_posed": pair.well_posed,
        "unseen": None if size is None else size.unseen, "consistent": pair.consistent,
        "defect": pair.defect, **constants, "order": found.at_steps,
        "curve_order": found.on_curve, "limited_by": found.limit, "symmetric": symmetric,
        "name": names[0] if names else "", "names": names, "spectral_radius": radius,
        "reasons": reasons,
    }  # fmt: skip


def _pair(method: Any, rule: Any) -> tuple[Space, Rule]:
    if isinstance(method, type) or not hasattr(method, "basis"):
        if isinstance(method, type) or not (hasattr(method, "space") and hasattr(method, "rule")):
            raise TypeError(
                f"theory is of a method such as galvi.Galerkin(galvi.Polynomials(8), "
                f"galvi.gauss(8)), or of a space and a rule; received {shown(method)}."
            )
        if rule is not None:
            raise TypeError(
                f"a method has its own rule; "
                f"received {shown(rule)} besides. Give a space and a rule, "
                f"or name the problem: theory(method, problem=problem)."
            )
        return method.space, method.rule
    if not isinstance(rule, Rule):
        raise TypeError(
            f"the theory of a space needs a rule such as galvi.gauss(8); received {shown(rule)}."
        )
    return checked(method), rule


def _check(problem: Any, step: Any, lipschitz: Any) -> None:
    for name, value in (("step", step), ("lipschitz", lipschitz)):
        if value is not None and problem is None:
            raise ValueError(
                f"{name} means nothing without a problem; "
                f"received {shown(value)}. Give the problem too."
            )
    if problem is not None and not isinstance(problem, Problem):
        raise TypeError(
            f"problem must be a galvi.Problem such as galvi.problems.kepler(0.6); received "
            f"{shown(problem)}."
        )
    if step is not None and input_checks.real("step", step) == 0.0:
        raise ValueError(f"step must not be zero; received {step!r}.")
    if lipschitz is not None:
        input_checks.positive("lipschitz", lipschitz, "Leave it out to have it estimated.")


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
    said = f"{VARIATIONAL.format(order=pair['order'])}; {frame.conserved}"
    changed = {"symmetric": symmetric, "name": method.name, "names": (method.name,)}
    none = {"spectral_radius": None, "reasons": reasons, "frame": said}
    return {**pair, **changed, **about, **none}


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
