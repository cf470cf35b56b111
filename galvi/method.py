"""A Galerkin variational integrator as a value."""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property
from typing import Any, cast

from galvi.charts.chart import Cayley, Chart, MovingChart
from galvi.input_checks import shown
from galvi.properties.properties import classical_names, is_symmetric, orders
from galvi.rules.rule import Rule, gauss
from galvi.spaces.polynomials import Polynomials
from galvi.spaces.space import Space
from galvi.tableau import Tableau, tabulate


@dataclass(frozen=True)
class Galerkin:
    """The variational integrator of a space and a rule.

    H eq. 2.3, 2.4; M section 3.

    Parameters
    ----------
    space
        e.g. ``Polynomials(8)``
    rule
        e.g. ``gauss(8)``
    chart
        coordinates on a Lie group about the start of each step, unused on vector spaces; or a frame
        that moves with an integrable flow, e.g. ``KeplerFrame()``, which needs ``Polynomials(s)``
        with ``gauss(s)``
    clock
        steps are constant in tau, dt = g(q) dtau, e.g. ``DynamicalTime()``, and follow the motion;
        None: constant in time

    Raises
    ------
    ValueError
        For an ill-posed pair (the free particle has no unique motion, M lemma 1) and for an
        inconsistent one (the free particle does not move in a straight line).
    TypeError
        For an argument of another type.

    Examples
    --------
    >>> method = galvi.Galerkin(galvi.Polynomials(4), galvi.lobatto(5))
    >>> method.name, method.order, method.stages, method.symmetric
    ('Galerkin degree 4, Lobatto 5', 8, 5, True)
    """

    space: Space
    rule: Rule
    chart: Chart | MovingChart = field(default_factory=Cayley)
    clock: Any = None

    def __post_init__(self) -> None:
        for name, kind, example in (
            ("space", "basis", "Polynomials(8)"),
            ("rule", "exact_nodes", "gauss(8)"),
            ("chart", ("farthest", "flow"), "Cayley()"),
        ):
            value, kinds = getattr(self, name), (kind,) if isinstance(kind, str) else kind
            if isinstance(value, type) or not any(hasattr(value, attribute) for attribute in kinds):
                raise TypeError(
                    f"{name} must be a {name} such as galvi.{example}; received {shown(value)}."
                )
        if self.clock is not None and (
            isinstance(self.clock, type) or not hasattr(self.clock, "rate")
        ):
            raise TypeError(
                f"clock must be a clock such as galvi.DynamicalTime(); "
                f"received {shown(self.clock)}."
            )
        tabulate(self.space, self.rule)
        s = self.space.degree
        if self.in_frame and not (self.space == Polynomials(s) and self.rule == gauss(s)):
            raise ValueError(
                f"a frame needs galvi.Polynomials(s) with galvi.gauss(s), collocation at Gauss "
                f"nodes; received {self.space} with {self.rule.name}. Use as many points as the "
                f"degree, or another chart."
            )
        if self.in_frame and self.clock is not None:
            raise ValueError(
                "a frame and a clock exclude each other: a frame's flow is exact in time, a "
                "clock's steps are constant in tau. Leave one of the two out."
            )

    @property
    def in_frame(self) -> bool:
        """Whether the chart is a frame that moves with an integrable flow."""
        return hasattr(self.chart, "flow")

    @cached_property
    def table(self) -> Tableau:
        """The tabulated pair."""
        return tabulate(self.space, self.rule)

    @property
    def group_chart(self) -> Chart:
        """The chart as one of a Lie group; only for methods without a frame."""
        return cast(Chart, self.chart)

    @property
    def stages(self) -> int:
        """Number of stages: force evaluations per iteration of a step."""
        return self.rule.points

    @property
    def order(self) -> int:
        """Order of convergence at step ends, on smooth problems (galvi.properties.properties)."""
        return orders(self.space, self.rule).at_steps

    @cached_property
    def symmetric(self) -> bool:
        """Whether a step forward and a step backward cancel on vector spaces.

        On groups they do not, since each step's chart is based at its start: the remainder is of
        order 2 s + 1 (none for degree 1 with the exponential chart). In a moving frame this is of
        the space and the rule alone: with nodes that an orbit places, as in `KeplerFrame()`, steps
        back cancel only up to the error of the step.
        """
        return is_symmetric(self.table, self.rule)

    @cached_property
    def name(self) -> str:
        """The classical name if the method has one for every Lagrangian, else the space and the
        rule. Names that hold only for a constant mass are in `galvi.theory` of a problem."""
        if self.in_frame:
            return f"Gauss collocation, {self.stages} stages, in the {self.chart.name}"
        one_degree = len(set(getattr(self.space, "degrees", (self.space.degree,)))) == 1
        classical = (
            next(iter(classical_names(self.table, separable=False)), "") if one_degree else ""
        )
        polynomials = self.space.dimension == self.space.degree + 1
        space = f"degree {self.space.degree}" if polynomials else str(self.space)
        clock = "" if self.clock is None else f", in the clock {self.clock}"
        return (classical or f"Galerkin {space}, {self.rule.name}") + clock

    def __repr__(self) -> str:
        chart = "" if self.chart == Cayley() else f", {self.chart}"
        clock = "" if self.clock is None else f", clock={self.clock}"
        return f"Galerkin({self.space}, {self.rule}{chart}{clock})"

    def theory(
        self, problem: Any = None, step: float | None = None, lipschitz: float | None = None
    ) -> Any:
        """Theoretical properties of this method and of a step on a problem: see `galvi.theory`."""
        from galvi.analysis.theory import theory  # analysis stands on methods

        return theory(self, None, problem, step, lipschitz)
