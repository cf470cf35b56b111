"""A-priori properties of a method: order, symmetry, constants, classical names, step bounds."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import asdict, dataclass, replace
from math import inf, isfinite
from typing import Any

import numpy as np

from galvi import input_checks
from galvi.analysis.step_bounds import contracting_step, norms, stage_iteration_step, unique_step
from galvi.input_checks import shown
from galvi.problem import Problem
from galvi.properties.properties import classical_names, is_symmetric, orders
from galvi.rules.rule import Rule
from galvi.spaces.space import Space, checked
from galvi.systems.canonical import Canonical
from galvi.systems.canonical_on_rn import checked_degrees
from galvi.systems.nbody import NBody
from galvi.tableau import assemble


@dataclass(frozen=True)
class Theory:
    """Theoretical properties of a space and a rule, also of a pair that `galvi.Galerkin` refuses.

    Attributes
    ----------
    space, rule
        their names
    well_posed
        whether a free particle has a unique motion: ``|u|_{X,N}`` is a norm (M lemma 1)
    unseen
        number of independent functions that the rule cannot tell from 0
    consistent
        whether that motion is a straight line to 1e-13
    defect
        largest of ``|alpha_k - c_k|`` and ``|beta_p - 1|``
    friedrichs
        C_N of ``|u|_{0,N} <= C_N (h / z0) |u|_{X,N}`` (M 11)
    smallest_ratio
        lambda_N of ``lambda_N |u|_X <= |u|_{X,N}`` (M 12)
    largest_ratio
        Lambda_N of ``|u|_{X,N} <= Lambda_N |u|_X`` (M 12)
    order
        order of convergence at step ends, on smooth problems; 0 for a refused pair
    curve_order
        order of positions between step ends
    limited_by
        "space", "rule for the force" or "rule for the kinetic energy"; "" for a refused pair
    symmetric
        whether a step forward and a step backward cancel
    names
        classical names, the best known first: with a problem those that hold for it, else those
        that hold for every Lagrangian
    frame
        a sentence on the properties in a moving frame; "" for other methods
    problem, step
        name of the problem, and the given step; the fields below are in the problem's units
    lipschitz
        Lipschitz constant K of dV/dq; the theorems require one that holds everywhere
    source
        "given", or "at the start" where K was computed there; "" without K
    unique_step
        bound on h of M theorem 2, 3 K h^2 C_N^2 / (m z0^2) < 1 with z0 = 0.860
    stage_step
        bound on h of H theorem 2.3.1, at most 1
    fixed_point_step
        h with h^2 rho(A) K / m = 1, where A is the Nystrom tableau; without a given K, K / m is the
        largest eigenvalue of M^-1 V'' at the start
    no_bounds
        a sentence on why the problem has no bounds; "" where it has. A bound is None where the pair
        does not meet the conditions of its theorem

    Notes
    -----
    A field that does not apply, or that float64 cannot decide, is None.

    Examples
    --------
    >>> unsuitable = galvi.theory(galvi.Polynomials(3), galvi.gauss(2))
    >>> unsuitable.well_posed, unsuitable.unseen
    (False, 1)
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
    order: int
    curve_order: int
    limited_by: str
    symmetric: bool | None
    names: tuple[str, ...]
    frame: str = ""
    problem: str | None = None
    step: float | None = None
    lipschitz: float | None = None
    source: str = ""
    unique_step: float | None = None
    stage_step: float | None = None
    fixed_point_step: float | None = None
    no_bounds: str = ""

    @property
    def name(self) -> str:
        """The best known classical name, "" for none."""
        return self.names[0] if self.names else ""

    @property
    def exists(self) -> bool | None:
        """Whether the step is guaranteed to have exactly one solution (M theorem 2); None without a
        step or a bound, and where only the K of the start guarantees it."""
        return self._is_below(self.unique_step)

    @property
    def converges(self) -> bool | None:
        """Whether fixed-point iteration contracts near a solution of the step; None as for
        ``exists``."""
        return self._is_below(self.fixed_point_step)

    def _is_below(self, bound: float | None) -> bool | None:
        if bound is None or self.step is None:
            return None
        below = abs(self.step) < bound
        return None if below and self.source != "given" and bound < inf else below

    def __str__(self) -> str:
        return "\n".join(_lines(self))

    def to_dict(self) -> dict[str, Any]:
        """Name -> value of fields and properties, in plain Python types."""
        properties = {name: getattr(self, name) for name in ("name", "exists", "converges")}
        return {**asdict(self), "names": list(self.names), **properties}


def theory(
    method: Any,
    rule: Rule | None = None,
    problem: Problem | None = None,
    step: float | None = None,
    lipschitz: float | None = None,
) -> Theory:
    """The theory of a method, or of a space and a rule, and of a step on a problem.

    Parameters
    ----------
    method
        a `galvi.Galerkin`, or a space
    rule
        quadrature rule when ``method`` is a space
    problem
        the problem whose force bounds the step
    step
        step size in the problem's unit of time; negative for a step backwards
    lipschitz
        Lipschitz constant K of dV/dq; None: that at the start

    Raises
    ------
    TypeError
        For an argument of another type.
    ValueError
        For a step or a lipschitz without a problem, for a number that is not finite, a step of
        zero, a negative lipschitz, and a problem together with a method in a clock.

    Examples
    --------
    >>> galvi.theory(galvi.Polynomials(3), galvi.gauss(4)).order
    6
    >>> method = galvi.Galerkin(galvi.Polynomials(3), galvi.gauss(3))
    >>> spring = galvi.problems.harmonic_oscillator()
    >>> galvi.theory(method, problem=spring, step=0.1, lipschitz=1.0).exists
    True
    """
    space, rule = _space_and_rule(method, rule)
    _check_arguments(problem, step, lipschitz)
    report = _theory_of_pair(space, rule, _is_separable(problem))
    if problem is not None:
        name = problem.name or type(problem.system).__name__
        report = replace(report, problem=name, step=None if step is None else float(step))
    if getattr(method, "in_frame", False):
        return _theory_in_frame(report, method)
    if problem is None:
        return report
    if getattr(method, "clock", None) is not None:
        raise ValueError(
            f"the bounds of a step are those of steps constant in time; received a method with the "
            f"clock {method.clock}. Leave the clock out, or the problem."
        )
    checked_degrees(space, problem.system, problem.v0.size)
    if report.symmetric and not _is_commutative(problem.system):
        report = replace(report, symmetric=None)  # the chart of a step is based at its start
    stiffness = _lipschitz_and_frequency(problem, lipschitz)
    if isinstance(stiffness, str):
        return replace(report, no_bounds=stiffness)
    constant, square = stiffness
    return replace(
        report,
        lipschitz=constant,
        source="at the start" if lipschitz is None else "given",
        unique_step=unique_step(report.friedrichs, square),
        stage_step=stage_iteration_step(space, rule, square),
        fixed_point_step=contracting_step(space, rule, square),
    )


def _is_separable(problem: Problem | None) -> bool:
    """Whether L is that of a constant mass and of a potential, without other forces."""
    system: Any = None if problem is None else problem.system
    if isinstance(system, NBody):
        return bool(system.acting.conserve)
    return isinstance(system, Canonical) and system.force is None


def _theory_of_pair(space: Space, rule: Rule, separable: bool) -> Theory:
    pair, size, order = assemble(space, rule), norms(space, rule), orders(space, rule)
    one_degree = len(set(getattr(space, "degrees", (space.degree,)))) == 1
    return Theory(
        space=str(space),
        rule=rule.name,
        well_posed=pair.well_posed,
        unseen=None if size is None else size.unseen,
        consistent=pair.consistent,
        defect=pair.defect,
        friedrichs=size.C if size is not None and isfinite(size.C) else None,
        smallest_ratio=None if size is None else size.lowest,
        largest_ratio=None if size is None else size.highest,
        order=order.at_steps,
        curve_order=order.on_curve,
        limited_by=order.limit,
        symmetric=None if pair.table is None else is_symmetric(pair.table, rule),
        names=classical_names(pair.table, separable)
        if pair.table is not None and pair.consistent and one_degree
        else (),
    )


def _space_and_rule(method: Any, rule: Any) -> tuple[Space, Rule]:
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


def _check_arguments(problem: Any, step: Any, lipschitz: Any) -> None:
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
        raise ValueError(
            f"step must not be zero; received {step!r}. Give the step size in units of time."
        )
    if lipschitz is not None:
        number = input_checks.real("lipschitz", lipschitz, "Leave it out for that of the start.")
        if number < 0.0:
            raise ValueError(f"lipschitz must not be negative; received {shown(lipschitz)}.")


def _theory_in_frame(report: Theory, method: Any) -> Theory:
    """The theory of a method in a frame, from that of its space and rule.

    Where the orbit at the start of a run places the nodes, forward and backward steps with the same
    nodes cancel; from another start they differ by the error of the step: ``symmetric`` is None.
    """
    return replace(
        report,
        symmetric=report.symmetric if method.chart.reversible else None,
        names=(method.name,),
        frame=(
            "Hamilton's principle in phase space, in coordinates that move with the flow: every "
            "step is symplectic once its passes have converged, of order "
            f"{report.order} in h; {method.chart.conserved}"
        ),
        no_bounds=""
        if report.problem is None
        else "the bounds of M and H are for curves in the inertial frame.",
    )


def _lipschitz_and_frequency(
    problem: Problem, lipschitz: float | None
) -> tuple[float, float] | str:
    """The Lipschitz constant K of dV/dq, given or at the start, and the square of the largest
    frequency, at most K over the least mass; a sentence on the reason where there is no bound."""
    system: Any = problem.system
    if not hasattr(system, "acceleration_jacobian"):
        return (
            f"the theorems are for L = v.M v / 2 - V on a vector space, not for a "
            f"{type(system).__name__}."
        )
    if getattr(system, "force", None) is not None or getattr(system, "forces", None):
        return "the theorems are for the force of the potential alone; here is one besides."
    d = problem.v0.size
    units = np.eye(d).reshape(-1, *problem.v0.shape)
    mass = np.array([np.ravel(system.momentum(unit)) for unit in units])
    smallest_mass = float(np.linalg.eigvalsh(mass)[0])
    if smallest_mass <= 0.0:
        return "the theorems are for positive masses; here is a body without mass."
    if lipschitz is not None:
        return float(lipschitz), float(lipschitz) / smallest_mass
    jacobian = system.acceleration_jacobian(problem.q0, problem.t0).reshape(d, d)
    if not np.all(np.isfinite(jacobian)):
        return "the derivative of the force is not finite at the start."
    if not np.any(jacobian):
        return "the force does not change with position at the start. Give lipschitz."
    constant, square = (
        float(np.max(np.abs(np.linalg.eigvals(x)))) for x in (mass @ jacobian, jacobian)
    )
    return constant, square


def _is_commutative(system: Any) -> bool:
    """Whether the group is commutative, so that a chart's base does not matter."""
    layout = system.group.layout if hasattr(system, "group") else []
    return all(rotations == 0 or d == 1 for _, d, _, rotations in layout)


STAGE_ITERATION = "H's iteration contracts (H theorem 2.3.1)"


def _lines(report: Theory) -> Iterator[str]:
    """The lines of ``str(report)``: order and symmetry, constants, and with a problem step
    bounds."""
    yield f"{report.space} with {report.rule}" + (f" = {report.name}" if report.name else "")
    if not report.well_posed:
        yield "ill-posed: a free particle has no unique motion"
    elif not report.consistent:
        yield f"well posed, inconsistent: a free particle is off by {report.defect:.1e} of a step"
    else:
        symmetry = {True: ", symmetric", False: ", not symmetric", None: ""}[report.symmetric]
        yield f"well posed, consistent{symmetry}"
    if report.order:
        yield (
            f"order {report.order} at step ends, {report.curve_order} on the curve, limited by the "
            f"{report.limited_by}"
        )
    if report.friedrichs is not None:
        yield (
            f"C_N {report.friedrichs:.4f}, lambda_N {report.smallest_ratio:.4f}, "
            f"Lambda_N {report.largest_ratio:.4f}"
        )
    if report.frame:
        yield report.frame
    if report.no_bounds:
        yield f"{report.problem}: no bounds on the step: {report.no_bounds}"
    elif report.problem is not None:
        note = "" if report.source == "given" else "; give one that holds everywhere for a yes"
        yield f"{report.problem}: Lipschitz constant {report.lipschitz:.4g}, {report.source}{note}"
    for bound, holds, meaning in (
        (report.unique_step, report.exists, "a step has exactly one solution (M theorem 2)"),
        (report.stage_step, None, STAGE_ITERATION),
        (report.fixed_point_step, report.converges, "fixed-point iteration contracts (spectrum)"),
    ):
        if bound is not None:
            has_answer = report.step is not None and meaning != STAGE_ITERATION
            answer = f": {'yes' if holds else 'not said'} at {report.step:g}" if has_answer else ""
            yield f"{'any step' if bound == inf else f'h < {bound:.4g}':<13} {meaning}{answer}"
        elif report.problem is not None and not report.no_bounds:
            yield f"{'no bound':<13} {meaning}: the pair does not have what it needs"
