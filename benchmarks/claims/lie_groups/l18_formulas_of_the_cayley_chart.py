"""L18: H's formulas for the free body in Cayley's chart, as printed (H 3.2.2, 3.4.1 to 3.4.3)."""

from __future__ import annotations

from itertools import permutations

from benchmarks.claims.kit import *
from benchmarks.claims.lie_groups import free_body, pendulum_motion, printed_formulas
from benchmarks.claims.lie_groups.cayley_curve import cayley_rate
from benchmarks.claims.lie_groups.held_base import BodySteps, ScaledRotations
from benchmarks.claims.lie_groups.printed_formulas import AS_PRINTED, IN_ORDER, lagrangian_of
from benchmarks.measures.independent_space import gauss_points
from references.textbook import galerkin
from references.textbook.galerkin import Rotations, cayley

SCALES = (-0.5, 10.0)  # galvi's xi is -2 times H's
SCALED, GALVI = (
    "distance between steps by Phi(s xi) and by Phi(xi)",
    "distance between galvi's steps and those by H's Phi(xi)",
)
INVERSE, LAMBDA, RELATIVE = "Phi(Phi(X)) - X", "lambda as printed", "xi_k as printed"
TRACE, HALF = "(3.32) beside (3.50) in order", "half of (3.32)"
PAIRS, ORDERED = "(3.50) as printed", "(3.50) with I_1 at phi_a, I_3 at phi_c"
READINGS = (PAIRS, *(f"{PAIRS}, reading {k}" for k in range(2, 13)))  # axes 1, 2, 3 are the first
OF_PRINTED, OF_ORDERED = "(3.51) beside the printed (3.50)", "(3.51) beside (3.50) in order"
STAGES = "largest (3.51) along galvi's steps, i = 2 to n - 1, over |p|"
CHAIN, MENDED = "dL_d / dlambda as printed", "dL_d / dlambda with b in the last line"
HELD, MOVED = "base held", "base moved"
CHANGES = (
    "change of |y| in a step, relative",
    "change of the momentum in space in a step, relative",
)
IN_H = "base held, one step"
N, STEP, STEPS = 4, 0.5, 2
NS, ORDERS, BODY_STEPS = (3, 4, 5, 8), (3, 4, 5), 6
POINTS: Mapping[str, Callable[[int], int]] = {
    "n": lambda n: n,
    "n + 1": lambda n: n + 1,
    "2 n": lambda n: 2 * n,
}  # of Gauss's rule, which H leaves open
SEED, STATES = 350, 100
ROUND_OFF = 1e-12  # of two steps by Newton's method, and of formulas; 5e-14 was measured
KEPT = 1e-13  # of momentum in a step; 3e-15 was measured
FLOOR = 1e-14
MOMENTS, J_D = np.array([3.3, 2.5, 3.4]), np.diag([1.3, 2.1, 1.2])
P0 = MOMENTS * np.array([2.0, -1.9, 1.0])
RANDOM = (
    "J_d = diag(1.3, 2.1, 1.2), so I = (3.3, 2.5, 3.4); random xi, xi' and phi_i, phi_i', normal, "
    "xi times 1/2; largest of all states, relative"
)
CURVES = "x -> s x maps the space of curves onto itself"
PROOF = "R' = -(I + R) X' (I + X)^-1, hat(w) = R^T R' = -2 hat(xi' + xi x xi') / (1 + |xi|^2)"


def study(make_method: MakeMethod, quick: bool, report: Report) -> DataFrame:
    """Steps by scaled charts and by galvi; each formula beside its truth, at random states; the
    momentum of steps with the base of the chart held and moved."""
    found: list[dict[str, Any]] = []
    for name, problem in (("free", free_body.problem()), ("pendulum", pendulum_motion.problem())):
        report(f"steps by scaled charts, {name}")
        found += _scaled(name, problem, make_method)
    rng = np.random.default_rng(SEED)
    for _ in range(STATES):
        found += rows(_formulas(rng), study="formulas")
    found += _stages(make_method)
    for n in NS:
        report(f"momentum, n = {n}")
        for kind, printed in ((HELD, True), (MOVED, False)):
            for label, points in POINTS.items():
                body = BodySteps(MOMENTS, n, points(n), STEP, printed)
                found += rows(_changes(body, BODY_STEPS), study=kind, n=n, label=label)
    for n in ORDERS:
        for h in [2.0 ** (-j / 4) for j in range(12, 25)]:
            found += rows(_changes(BodySteps(MOMENTS, n, n, h, True), 1), study=IN_H, n=n, step=h)
    return frame(found)


def _changes(body: BodySteps, steps: int) -> dict[str, float]:
    """The largest change in a step of |y| and of the momentum in space, over |y|."""
    R, p = body.run(P0, steps)
    y = np.einsum("kab,kb->ka", R, p)
    size = np.linalg.norm(y, axis=1)
    changes = np.abs(np.diff(size)), np.linalg.norm(np.diff(y, axis=0), axis=1)
    return {name: float(np.max(one) / size[0]) for name, one in zip(CHANGES, changes, strict=True)}


def _scaled(name: str, problem: Problem, make_method: MakeMethod) -> list[dict[str, Any]]:
    """Largest distances of R and p over all steps."""
    L, start = lagrangian_of(problem), (problem.q0, problem.v0, STEP, STEPS)
    known = galerkin.Galerkin(N, *gauss_points(N), Rotations()).run(L, *start)

    def apart(run: Any) -> float:
        return float(max(np.max(np.abs(run.q - known.q)), np.max(np.abs(run.p - known.p))))

    runs = [
        galerkin.Galerkin(N, *gauss_points(N), ScaledRotations(s)).run(L, *start) for s in SCALES
    ]
    found = [row(study=name, quantity=SCALED, value=apart(run)) for run in runs]
    run = galvi.integrate(problem, method_on_group(make_method, N), STEP, STEPS)
    return [*found, row(study=name, quantity=GALVI, value=apart(run), status=failure(run))]


def _formulas(rng: np.random.Generator) -> dict[str, float]:
    """Each formula's relative departure from its truth, at a random state."""
    h = printed_formulas
    xi, first, rate = rng.standard_normal((3, 3)) * [[0.5], [0.5], [1.0]]
    value, change = rng.standard_normal(2)
    T = h.kinetic_energy(MOMENTS, xi, rate)
    readings_of = [
        h.lagrangian(MOMENTS, sign * xi[list(axes)], sign * rate[list(axes)], AS_PRINTED)
        for axes in permutations(range(3))
        for sign in (1.0, -1.0)
    ]
    terms = h.stage_terms(MOMENTS, xi, rate, value, change)
    of_printed, of_ordered = (
        h.gradient(
            lambda e, pairs=pairs: h.lagrangian(MOMENTS, xi + value * e, rate + change * e, pairs)
        )
        for pairs in (AS_PRINTED, IN_ORDER)
    )
    point = h.composed(first, xi)
    by_point = h.gradient(lambda e: h.lagrangian(MOMENTS, h.relative(first, point + e), rate))
    by_xi = h.stage_terms(MOMENTS, xi, rate, 1.0, 0.0)
    chart = h.change_of_chart(first, point)
    turned = h.inverse_cayley(cayley(first) @ cayley(xi))
    back = h.inverse_cayley(cayley(first).T @ cayley(turned))
    return {
        INVERSE: _apart(h.inverse_cayley(cayley(xi)), xi),
        LAMBDA: _apart(point, turned),
        RELATIVE: _apart(h.relative(first, turned), back),
        TRACE: _apart(h.trace_lagrangian(J_D, xi, rate), h.lagrangian(MOMENTS, xi, rate)),
        HALF: _apart(0.5 * h.trace_lagrangian(J_D, xi, rate), T),
        **{READINGS[k]: _apart(one, T) for k, one in enumerate(readings_of)},
        ORDERED: _apart(h.lagrangian(MOMENTS, xi, rate), T),
        OF_PRINTED: _apart(terms, of_printed),
        OF_ORDERED: _apart(terms, of_ordered),
        CHAIN: _apart(h.changed_slope(by_xi, chart, printed=True), by_point),
        MENDED: _apart(h.changed_slope(by_xi, chart, printed=False), by_point),
    }


def _apart(mine: Any, known: Any) -> float:
    return float(np.linalg.norm(np.subtract(mine, known)) / np.linalg.norm(known))


def _stages(make_method: MakeMethod) -> list[dict[str, Any]]:
    """H's equations at the curves of galvi's steps of the free body, for i = 2 to n - 1."""
    c, b = gauss_points(N)
    table = galerkin.Galerkin(N, c, b, Rotations())
    run = galvi.integrate(free_body.problem(), method_on_group(make_method, N), STEP, STEPS)
    largest = 0.0
    for t in run.t[:-1]:
        times = t + STEP * np.concatenate([[0.0], c])
        xi, rate = cayley_rate(run(times), run.velocity(times))
        for value, slope in zip(table.phi[1:-1], table.rates[1:-1] / STEP, strict=True):
            known = (-0.5 * xi[1:], -0.5 * rate[1:], value, slope)  # H's xi is -1/2 times galvi's
            sums = STEP * b @ printed_formulas.stage_terms(MOMENTS, *known)
            largest = max(largest, float(np.linalg.norm(sums) / np.linalg.norm(P0)))
    return [row(study="stages", quantity=STAGES, value=largest, status=failure(run))]


def judge(table: DataFrame) -> list[Row]:
    """The charts, the change of chart, the Lagrangian, its slopes, and the momentum."""
    return [*_charts(table), *_changes_of_chart(table), *_lagrangians(table), *_momentum(table)]


def _charts(table: DataFrame) -> list[Row]:
    bodies = {"free": free_body.BODY, "pendulum": pendulum_motion.MOTION}
    method = f"Polynomials({N - 1}), gauss({N}); {STEPS} steps of h = {STEP:g}"
    scales = ", ".join(f"{s:g}" for s in SCALES)
    shared = {
        "source": "H 3.4.2",
        "claimed": "different versions of the Cayley transform result in equivalent methods",
        "reference": "references/textbook, Newton's method by complex steps",
    }
    return [
        L18.row(
            f"largest {quantity}, {name}",
            AtMost(ROUND_OFF),
            readings.largest_of(table, quantity=quantity, study=name),
            setup=f"{setup}; {method}; {versions}; R and p at the ends",
            reason=f"{CURVES}, and the action is that of the curve on the group.",
            **shared,
        )
        for quantity, versions in (
            (SCALED, f"s = {scales}"),
            (GALVI, "Phi(xi) = (I - X)(I + X)^-1 beside galvi's (I - X / 2)^-1 (I + X / 2)"),
        )
        for name, setup in bodies.items()
    ]


def _changes_of_chart(table: DataFrame) -> list[Row]:
    slip = (
        "The last line has dL_d / dxi_c d xi_b / d lambda_c for dL_d / dxi_b d xi_b / d lambda_c, "
        "and the line above all three dL_d / d lambda_a"
    )
    return [
        _formula(
            table, INVERSE, AtMost(ROUND_OFF), "H 3.4.2", "it is its own inverse",
            "(I - Q)(I + Q)^-1 with Q = (I - X)(I + X)^-1: I - Q = 2 X (I + X)^-1 and I + Q = "
            "2 (I + X)^-1, so that the quotient is X.",
        ),
        _formula(
            table, LAMBDA, AtMost(ROUND_OFF), "H 3.4.3", "lambda = Phi^-1(Phi(xi^0) Phi(xi_k))",
            "Rodrigues' formula for the product of two rotations: (x0 + x - x0 x x) / "
            "(1 - x0 . x) with the sign of H's chart.",
        ),
        _formula(
            table, RELATIVE, AtMost(ROUND_OFF), "H 3.4.3",
            "xi_k = Phi^-1(Phi(xi^0)^-1 Phi(lambda))",
            "The same formula with -xi^0, since Phi(-x) = Phi(x)^-1.",
        ),
        _formula(
            table, CHAIN, AtMost(ROUND_OFF), "H 3.4.3",
            "D_1 L_d = (dL_d / d lambda_a, a, a), three sums by the chain rule",
            f"Index slip, unsafe direction: {slip[0].lower()}{slip[1:]}.", CONTRADICTED,
        ),
        _formula(
            table, MENDED, Finding(AtMost(ROUND_OFF)), "H 3.4.3",
            "the row above; our value: the chain rule with b in its place", f"{slip}.",
        ),
    ]  # fmt: skip


def _lagrangians(table: DataFrame) -> list[Row]:
    least = readings.least(
        np.array([readings.largest_of(table, quantity=name) for name in READINGS])
    )
    pairing = (
        f"{PROOF}, of which phi(a, b, c) is the a-component: I_1 belongs to it, and I_3 to phi(c, "
        "a, b). As printed axes 1 and 3 are exchanged, another body"
    )
    dots = "dots, and lines of (3.51b, c), are lost in the text at hand; by (3.51a) and symmetry"
    return [
        _formula(
            table, TRACE, AtMost(ROUND_OFF), "H (3.32)",
            "L = tr(R'^T R J_d R^T R'), which (3.50) sums in coordinates",
            "A half is missing: tr(...) is w . J w. (3.50) in coordinates and 3.5.2 have it. "
            "Harmless without a potential.", CONTRADICTED,
        ),
        _formula(
            table, HALF, Finding(AtMost(ROUND_OFF)), "H (3.32)", "the row above; our value: a half",
            "w . J w / 2 with J = tr(J_d) I - J_d, as printed, and hat(w) = R^T R'.",
        ),
        _formula(
            table, PAIRS, AtMost(ROUND_OFF), "H (3.50)",
            "L = 2 / (1 + |xi|^2)^2 (I_1 phi_c^2 + I_2 phi_b^2 + I_3 phi_a^2), phi_a = phi(xi_a, "
            "xi_b, xi_c); a, b, c are axes 1, 2, 3 by (3.17)", f"{pairing}.", CONTRADICTED,
        ),
        L18.row(
            f"{PAIRS}, departure, least over a, b, c any order of axes, with either sign",
            Finding(AtMost(ROUND_OFF)),
            least,
            source="H (3.50)",
            claimed="the row above; ours: a reading that mends it",
            reason="The least is that of a, b, c = -3, -2, -1, a rotation of the axes, which "
            "(3.17) excludes; and (3.51) would be false, see below.",
        ),
        _formula(
            table, ORDERED, Finding(AtMost(ROUND_OFF)), "H (3.50)",
            "(3.50); our value: I_1 phi_a^2 + I_2 phi_b^2 + I_3 phi_c^2", f"{pairing}.",
        ),
        _formula(
            table, OF_PRINTED, AtMost(ROUND_OFF), "H (3.50), H (3.51)",
            "(3.51) is the derivative of the sum in (3.50)",
            f"(3.51) pairs I_3 with phi_c and I_1 with phi_a, (3.50) the other way; {dots}.",
            CONTRADICTED,
        ),
        _formula(
            table, OF_ORDERED, Finding(AtMost(ROUND_OFF)), "H (3.51)",
            "the row above; our value: of (3.50) with its axes in order",
            f"The slip is in (3.50), not in (3.51); {dots}.",
        ),
        L18.row(
            STAGES,
            AtMost(KEPT),
            readings.largest_of(table, quantity=STAGES),
            source="H (3.51)",
            setup=f"{free_body.BODY}; Polynomials({N - 1}), gauss({N}); {STEPS} steps of h = "
            f"{STEP:g}; xi and xi' from R(t) and the body velocity",
            claimed="the internal stage equations",
            reason=f"They are galvi's, in other coordinates; {dots}.",
        ),
    ]  # fmt: skip


def _momentum(table: DataFrame) -> list[Row]:
    size, whole = CHANGES
    setup = (
        f"{free_body.BODY}; n = {{}}; Gauss's rule of n, n + 1 and 2 n points; {BODY_STEPS} steps "
        f"of h = {STEP:g}; (3.51), solved to round-off"
    )
    why = (
        "L_d is a function of R_k and R_(k + 1), whose curves are R_k Phi(xi(t)): D_1 L_d moves "
        "the base R_k, and L_d(R_k^T R_(k + 1)) of a free body makes R p constant"
    )
    return [
        *(
            L18.row(
                f"{size}, {HELD} as printed, least over the rules, n = {n}",
                AtMost(KEPT),
                readings.least_of(table, study=HELD, quantity=size, n=n),
                source="H (3.9), H 3.4.3",
                setup=setup.format(n),
                claimed="D_1 L_d = dL_d / dxi_k d xi_k / d lambda_k, (3.51) at i = 1 in the chart "
                "of the step, whose flow keeps momenta (3.1.1) and |y| (3.5.1)",
                expected=CONTRADICTED,
                reason=f"{why}. At a base that is held xi^1 alone moves, within another space of "
                "curves, and momentum is lost in every step.",
                reference="|y| of the start",
            )
            for n in NS
        ),
        L18.row(
            f"largest {whole}, {MOVED}, all n and rules",
            Finding(AtMost(KEPT)),
            readings.largest_of(table, quantity=whole, study=MOVED),
            source="H (3.9), H 3.4.3",
            setup=setup.format(", ".join(str(n) for n in NS)),
            claimed="the rows above; our value: the base moves along",
            reason=f"{why}.",
            reference="R p of the start",
        ),
        *(
            L18.row(
                f"order of the {whole}, {HELD} as printed, n = {n}",
                Finding(AtLeast(2 * n - 1, uncertainty=0.0)),
                readings.order(table, FLOOR, study=IN_H, quantity=whole, n=n),
                source="H (3.9), H 3.4.3",
                setup=f"{free_body.BODY}; Gauss n, n = {n}; one step of h = 2^(-j/4), j = 12, ...",
                claimed="the rows above: how much is lost",
                reason="Either space of curves gives L_d with an error O(h^(2 n - 1)): the order "
                f"of the step is kept, and what is lost in one is O(h^{2 * n - 1}) or less.",
                reference="R p of the start",
            )
            for n in ORDERS
        ),
    ]


def _formula(
    table: DataFrame,
    quantity: str,
    bound: Bound,
    source: str,
    claimed: str,
    reason: str,
    expected: str = "",
) -> Row:
    """The largest departure of a formula from its truth over all states."""
    texts = {"expected": expected} if expected else {}
    texts |= {"source": source, "claimed": claimed, "reason": reason}
    return L18.row(
        f"{quantity}, departure", bound, readings.largest_of(table, quantity=quantity), **texts
    )


def _reversed(sound: Callable[..., Array]) -> Callable[..., Array]:
    return lambda first, point: -sound(-np.array(first), -np.array(point))


FEW = fewer(__name__, NS=(3,), ORDERS=(), SCALES=(10.0,), STATES=10, STEPS=1)

L18 = Claim(
    "L18",
    "The formulas of the Cayley chart, and which of them hold as printed",
    study,
    judge,
    source="H 3.4.3",
    setup=RANDOM,
    reference="matrices by numpy, derivatives by complex steps",
    statement="H 3.4: scaled Cayley transforms give one method; lambda and xi_k are each other's "
    "change of chart; L, its sum in coordinates (3.50) and its derivative (3.51); the momentum is "
    "matched by (3.9). Measured: (3.32) lacks a half, (3.50) exchanges axes, (3.9) loses momentum.",
    caught=(
        of_table(STAGES, integral=1.0 + 1e-9, wrong=FEW),
        Fault(
            "another chart",
            {*(f"largest {GALVI}, {name}" for name in ("free", "pendulum")), STAGES}.__eq__,
            lambda space, rule, chart=None: galvi.Galerkin(space, rule, galvi.Exponential()),
            wrong=FEW,
        ),
        *(
            Fault(
                f"the cross product of {name} with another sign",
                {f"{quantity}, departure"},
                wrong={f"benchmarks.claims.lie_groups.printed_formulas.{name}": _reversed, **FEW},
            )
            for name, quantity in (("composed", LAMBDA), ("relative", RELATIVE))
        ),
    ),
)
