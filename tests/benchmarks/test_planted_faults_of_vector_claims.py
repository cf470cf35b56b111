"""The claims V14 to V18 and V22 catch wrong tables, curves, derivatives and momenta."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

import galvi
from benchmarks.checks.bounds import CONTRADICTED, FINDING, HOLDS
from benchmarks.checks.claim import Claim
from benchmarks.claims.vector_spaces import v14_curves_between_ends as v14
from benchmarks.claims.vector_spaces import v15_noether_quantities as v15
from benchmarks.claims.vector_spaces import v16_symplecticity as v16
from benchmarks.claims.vector_spaces import v22_best_approximation as v22
from benchmarks.claims.vector_spaces import v29_moving_frames as v29
from benchmarks.claims.vector_spaces.v14_curves_between_ends import V14
from benchmarks.claims.vector_spaces.v15_noether_quantities import V15
from benchmarks.claims.vector_spaces.v16_symplecticity import V16
from benchmarks.claims.vector_spaces.v17_oscillator_order import V17
from benchmarks.claims.vector_spaces.v18_oscillator_convergence_in_degree import V18
from benchmarks.claims.vector_spaces.v22_best_approximation import V22
from benchmarks.claims.vector_spaces.v29_moving_frames import V29
from benchmarks.measures.space_rule_pairs import kinds
from benchmarks.measures.step_jacobian import canonical_defect, map_derivative
from benchmarks.store.frames import frame, row
from tests.benchmarks.planted_tables import contradicted, faulty


@pytest.mark.parametrize(
    ("claim", "make", "quantities"),
    [
        (V14, faulty(beta=1.0 + 1e-9, C=1.0 + 1e-4),
         {"base of the step's error", f"base of the {v14.CURVE}", f"base of the {v14.LARGEST}",
          f"order of the {v14.CURVE}, n = 6", f"order of the {v14.LARGEST}, n = 6"}),
        (V15, faulty(beta=1.0 + 1e-6, b=1.0 + 1e-3),
         {f"error of {v15.ALONG}, over the largest of single steps from exact states",
          *(f"change of angular momentum at step ends, {kind} [roundings]" for kind in kinds())}),
        (V16, faulty(A=1.0 + 1e-4),
         {f"{v16.DEFECT}, {kind}, {name}" for kind in kinds() for name in v16.PROBLEMS}),
        (V17, faulty(A=1.0 + 1e-4),
         {f"order of the error, N = {degree}{more}" for degree in (3, 4, 5)
          for more in ("", ", against the theory")}),
        (V18, faulty(beta=1.0 + 1e-6),
         {"base of the error, h = 0.8", "base of the error, h = 8"}),
        (V22, faulty(A=1.0 + 1e-4, C=1.0 + 1e-3),
         {"order of error along the path, smooth, N = 4",
          "order of the one-step error, Gauss N, N = 4",
          "order of the one-step error, Lobatto N + 1, N = 4"}),
        (V29, faulty(integral=1.5),
         {v29.ANGULAR, v29.ENERGY, v29.PLACE,
          *(f"{v29.DEFECT}, {name}" for name in ("harmonic frame", "Kepler frame")),
          *(f"{v29.FROM_EXACT}, {name}" for name in v29.FRAMES),
          *(f"{v29.ORDER}, {name}, {k} stages" for name in v29.FRAMES for k in (2, 3))}),
    ],
    ids=lambda value: getattr(value, "id", None),
)  # fmt: skip
def test_a_table_that_is_slightly_wrong_is_caught(
    claim: Claim, make: Any, quantities: set[str]
) -> None:
    assert quantities <= contradicted(claim, make)


@pytest.mark.parametrize(
    ("more", "verdicts"),
    [(0.0, (CONTRADICTED, FINDING)), (0.5, (HOLDS, CONTRADICTED))],
    ids=["the root of C_f", "C_f"],
)
def test_the_printed_power_of_c_f_would_hold_if_it_were_so(
    more: float, verdicts: tuple[str, str]
) -> None:
    """Curves of order n + 1/2 hold, and those of order n do not: no verdict is built in."""
    steps = 2.0 ** -np.arange(2.0, 8.0)
    powers = {v14.ENDS: lambda n: 2.0 * n - 1.0, v14.CURVE: lambda n: n + more}
    made = frame(
        row(study=v14.COERCIVE, quantity=quantity, n=n, step=h, value=h ** power(n))
        for n in v14.NS for quantity, power in powers.items() for h in steps
    )  # fmt: skip
    printed = [one for one in V14.judge(made) if one.quantity.startswith("order of distance /")]
    assert tuple(one.verdict for one in printed) == verdicts


def test_a_momentum_that_leaks_is_caught(monkeypatch: pytest.MonkeyPatch) -> None:
    true_to_itself = galvi.integrate

    def leaking(*given: Any, **more: Any) -> galvi.Trajectory:
        run = true_to_itself(*given, **more)
        fading = np.linspace(1.0, 1.0 + 1e-12, len(run.t)).reshape(-1, *[1] * (run.p.ndim - 1))
        return replace(run, p=run.p * fading)

    monkeypatch.setattr(galvi, "integrate", leaking)
    expected = {f"change of linear momentum at step ends, {kind} [roundings]" for kind in kinds()}
    translated = "change of linear momentum, translation, degrees by component [roundings]"
    assert expected | {translated} <= contradicted(V15)


def test_a_derivative_that_is_not_the_steps_is_caught(monkeypatch: pytest.MonkeyPatch) -> None:
    """A canonical matrix that is another step's has no defect; differences tell."""
    true_to_itself = galvi.step_derivative
    monkeypatch.setattr(v16, "QUICK_POINTS", (3,))
    monkeypatch.setattr(
        galvi, "step_derivative", lambda *given: true_to_itself(*given[:2], given[2] * (1 + 1e-6))
    )
    assert contradicted(V16) == {f"{v16.APART}, {name}" for name in v16.PROBLEMS}


def test_a_wrong_derivative_of_a_step_in_a_frame_is_caught(monkeypatch: pytest.MonkeyPatch) -> None:
    """A shear of the state before it: symplectic, so that only the differences tell."""
    derivative = galvi.step_derivative

    def sheared(*given: Any) -> Any:
        DF = derivative(*given)
        d = len(DF) // 2
        shear = np.eye(2 * d)
        shear[:d, d:] = 1e-8 * np.eye(d)
        return DF @ shear

    monkeypatch.setattr(galvi, "step_derivative", sheared)
    monkeypatch.setattr(v29, "_planets", lambda *given: {})
    monkeypatch.setattr(v29, "_noise", lambda *given: 0.0)
    held = [name for name in v29.FRAMES if not v29._moved(name)]
    assert contradicted(V29) == {f"{v29.APART}, {name}" for name in held}


def test_nodes_that_follow_the_start_are_not_held() -> None:
    """What V29 finds of them is no round-off, and shrinks with the step's error."""
    problem, chart, longest, _ = v29.FRAMES["Kepler frame, moved nodes"]
    method = galvi.Galerkin(galvi.Polynomials(3), galvi.gauss(3), chart)
    long, short = (canonical_defect(map_derivative(problem, method, h))
                   for h in (longest, longest / 2))  # fmt: skip
    assert long > 1e-11 and 2.0**5 < long / short < 2.0**8  # 6e-10, and 82


def test_approximations_of_too_low_a_degree_are_caught(monkeypatch: pytest.MonkeyPatch) -> None:
    sound = v22.best_errors
    monkeypatch.setattr(v22, "refine", lambda *given: [])
    monkeypatch.setattr(
        v22, "best_errors", lambda motion, edges, degree, *rest: sound(motion, edges, 1, *rest)
    )
    expected = {f"order of {v22.MEAN}, {name}, N = {n}" for name in v22.CASES for n in (2, 3, 4)}
    assert expected <= contradicted(V22)
