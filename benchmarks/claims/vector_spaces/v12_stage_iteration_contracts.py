"""V12: H's iteration for the stages contracts (H theorem 2.3.1, lemmas 2.3.1 and 2.3.2)."""

from __future__ import annotations

from benchmarks.claims.kit import *
from benchmarks.claims.vector_spaces.contraction import REACH, SAME, SPREAD, Passes, passes
from benchmarks.measures.independent_space import (
    gauss_points,
    lagrange_at_chebyshev,
    slopes,
    values,
)
from benchmarks.test_problems.oscillators import NONLINEAR, NonlinearOscillator

NS = (3, 4, 6, 8, 12, 16, 20)
SHOWN = (4, 8, 16)
SIZES = tuple(np.round(np.arange(0.05, 1.0, 0.05), 10).tolist())
SINGULAR, GROWN = "least singular value of A_1", "|A^-1| at h < 1, over that at 1"
LIMIT, BOUND = "step where the iteration stops to contract", "H's bound on the step"
SPECTRAL = "step where the iteration stops to converge"
PASS, SAID = "galvi's pass against H's, relative", "galvi.theory's bound over H's formula"
ROUND_OFF = 1e-10  # 8e-14 was measured
STUDY = "oscillator"
SHARES = (0.5, 0.9)  # of H's bound, for passes of nonlinear oscillators
RATIO = "ratio of successive passes over H's factor"
AGREE = 1e-12  # places of size 1; 6e-14 was measured, at n = 20
PASSED = (
    "Lagrange basis and rows as for the oscillator; {}; passes from w = q0 at {} of H's bound with "
    "C_L = K"
)


def study(make_method: MakeMethod, quick: bool, report: Report) -> DataFrame:
    """For each n: A_1 of H (2.6)-(2.8), and the contraction of one pass in nodal values.

    With m = k = 1 the pass w -> A^-1 f(w) is linear with the matrix h^2 D, D the same for any h.
    Row 0 of A is the initial value, rows 1 to n - 1 test with all basis functions but the last.
    Then the passes themselves for nonlinear oscillators, each a study of its name.
    """
    found = []
    for n in NS:
        report(f"n = {n}")
        method = make_method(galvi.Polynomials(n - 1), galvi.gauss(2 * n))
        found += rows(_numbers(method, n), study=STUDY, n=n)
        for case in NONLINEAR:
            values, why = _nonlinear(case, method, n)
            found += rows(values, study=case.name, n=n, status=why)
    return frame(found)


def _numbers(method: Any, n: int) -> dict[str, float]:
    phi, b, stiff = _basis(n)
    mass, A = (phi * b) @ phi.T, _matrix(stiff, 1.0)
    inverse, most = np.linalg.inv(A), _most(phi)
    D = inverse @ np.vstack([np.zeros(n), mass[:-1]])
    limit = 1.0 / np.sqrt(np.linalg.norm(D, np.inf))
    bound = min(1.0, 1.0 / (_size(inverse) * most))
    grown = max(_size(np.linalg.inv(_matrix(stiff, h))) for h in SIZES) / _size(inverse)
    said = method.theory(galvi.problems.harmonic_oscillator(), lipschitz=1.0).stage_step
    return {
        SINGULAR: float(np.linalg.svd(A, compute_uv=False)[-1]),
        GROWN: float(grown),
        LIMIT: float(limit),
        SPECTRAL: float(np.max(abs(np.linalg.eigvals(D))) ** -0.5),
        BOUND: bound,
        PASS: float(np.max(abs(_pass_of(method) - D)) / np.max(abs(D))),
        SAID: float(said / bound),
    }


def _basis(n: int) -> tuple[Array, Array, Array]:
    """Values of the basis at the points (n, 2 n), weights, and the Gram matrix of slopes."""
    basis, (t, b) = lagrange_at_chebyshev(n - 1), gauss_points(2 * n)
    dphi = slopes(basis, t)
    return values(basis, t), b, (dphi * b) @ dphi.T


def _most(phi: Array) -> float:
    """H's max_j |phi(c_j)|_1 |phi_p(c_j)|."""
    return float(np.max(np.sum(abs(phi), axis=0) * np.max(abs(phi[:-1]), axis=0)))


def _nonlinear(case: NonlinearOscillator, method: Any, n: int) -> tuple[dict[str, float], str]:
    """H's passes A^-1 f(w) for an oscillator with a Lipschitz constant K of its own."""
    phi, b, stiff = _basis(n)
    start: Any = case.problem()
    q0, v0 = float(start.q0[0]), float(start.v0[0])
    inverse = np.linalg.inv(_matrix(stiff, 1.0))
    factor = _size(inverse) * case.lipschitz * _most(phi)  # of h
    bound = min(1.0, 1.0 / factor)

    def once(w: Array, h: float) -> Array:
        pushed = h * (phi[:-1] * b) @ case.slope(phi.T @ w)
        pushed[0] -= v0
        return inverse @ np.concatenate([[q0], h * pushed])  # A^-1 = A_1^-1 diag(1, h, .. h)

    def run(share: float) -> Passes:
        pass_at = partial(once, h=share * bound)
        return passes(pass_at, np.full(n, q0), _largest_entry, lambda w: phi.T @ w)

    ran = {share: run(share) for share in SHARES}
    reaches = [
        abs(q0) + np.max(np.sum(abs(phi), axis=0)) * one.first / (1.0 - share * bound * factor)
        for share, one in ran.items()
    ]
    slope = inverse @ np.vstack([np.zeros(2 * n), phi[:-1] * b])
    steepest = max(_size((slope * k) @ phi.T) for k in case.curvature(case.places(2 * n)))
    step = galvi.integrate(start, method, SHARES[-1] * bound, 1, solver="fixed_point")
    worst = [one.ratio / (share * bound * factor) for share, one in ran.items()]
    return {
        RATIO: float(np.max(worst)),
        LIMIT: float(steepest**-0.5),
        BOUND: bound,
        REACH: float(np.max(reaches)) / case.radius,
        SPREAD: max(one.spread for one in ran.values()) / case.radius,
        SAME: float(abs(step.q[-1, 0] - ran[SHARES[-1]].limit[-1])),
    }, failure(step)


def _matrix(stiff: Array, h: float) -> Array:
    """A of H (2.6)-(2.8) on [0, h], from the Gram matrix of slopes on [0, 1]."""
    return np.vstack([np.eye(1, len(stiff)), stiff[:-1] / h])


def _pass_of(method: Any) -> Array:
    """The matrix of the method's own pass in nodal values, from its tableau, over -h^2 k / m.

    Q = psi x + q0 at the stages, a = -k Q / m, x = h^2 C a, and values at the nodes from x.
    """
    space, table = method.space, method.table
    nodes = space.basis(space.nodes)
    coefficients = np.linalg.inv(nodes)
    at_stages = coefficients[:1] + table.psi @ coefficients[1:]
    return -np.asarray((nodes[:, 1:] - nodes[:1, 1:]) @ table.C @ at_stages)


def _largest_entry(w: Array) -> float:
    return float(np.max(abs(w)))


def _size(matrix: Any) -> float:
    return float(np.linalg.norm(matrix, np.inf))


def judge(table: DataFrame) -> list[Row]:
    """Rows for the lemmas, the theorem's bound, and the iteration itself."""
    over_bound = _by_n(table, LIMIT) / _by_n(table, BOUND)
    return [
        V12.row(
            "least singular value of A_1 over all n",
            Above(1e-6),
            readings.least(_by_n(table, SINGULAR)),
            source="H lemma 2.3.1",
            claimed="A is invertible",
            reason="Testing with all but the last function leaves no polynomial but 0.",
        ),
        V12.row(
            "largest |A^-1| at h < 1 over |A_1^-1|, all n",
            Below(1.0),
            readings.largest(_by_n(table, GROWN)),
            source="H lemma 2.3.2",
            claimed="|A^-1| at h < 1 is below |A_1^-1|",
            reason="All columns of A^-1 but the first have a factor h.",
        ),
        V12.row(
            "least of measured limit / bound, all n",
            AtLeast(1.0),
            readings.least(over_bound),
            reason="Each of the estimates is a safe one.",
        ),
        *(
            V12.row(
                f"measured limit / bound, n = {n}",
                AtLeast(1.0),
                _over_bound(table, LIMIT, n),
                reason="Sums of |phi_i| and of the rows of A^-1 are bounded apart, and one of the "
                "two factors h is given away.",
            )
            for n in SHOWN
        ),
        *(
            V12.row(
                f"measured limit in any norm / bound, n = {n}",
                AtLeast(1.0),
                _over_bound(table, SPECTRAL, n),
                reason="Passes converge as long as the spectral radius is below 1, farther than "
                "one norm tells.",
            )
            for n in SHOWN
        ),
        V12.row(
            "galvi's pass against H's, largest relative difference, all n",
            AtMost(ROUND_OFF),
            readings.largest(_by_n(table, PASS)),
            source="H (2.5)",
            claimed="q = A^-1 f(q), with the force in f's last row that H's print lacks",
            reason="The tableau is the same iteration, its coefficients eliminated.",
        ),
        V12.row(
            "galvi.theory's bound over H's formula, largest departure from 1, all n",
            AtMost(ROUND_OFF),
            readings.largest(abs(_by_n(table, SAID) - 1.0)),
            claimed="the bound as printed, h at most 1",
            reason="The same formula, from another basis.",
        ),
        *(row for case in NONLINEAR for row in _of(table, case)),
    ]


def _of(table: DataFrame, case: NonlinearOscillator) -> list[Row]:
    """The rows of a nonlinear oscillator."""
    over_bound = _by_n(table, LIMIT, case.name) / _by_n(table, BOUND, case.name)
    texts = {"setup": PASSED.format(case.where, " and ".join(f"{share:g}" for share in SHARES))}
    sampled = "norm of the pass's derivative at random places and where |V''| = K"
    found = [
        V12.row(
            f"largest {RATIO}, {case.name}, all n",
            AtMost(1.0),
            readings.largest(_by_n(table, RATIO, case.name)),
            reason="Passes shrink differences by h |A_1^-1| C_L max |phi|_1 |phi_p| or less.",
            **texts,
        ),
        V12.row(
            f"least of measured limit / bound, {case.name}, all n",
            AtLeast(1.0),
            readings.least(over_bound),
            reason=f"As for the oscillator, whose V'' is K everywhere; {sampled}.",
            **texts,
        ),
        *(
            V12.row(
                f"measured limit / bound, {case.name}, n = {n}",
                AtLeast(1.0),
                _over_bound(table, LIMIT, n, case.name),
                reason=f"Sums of |phi_i| and of the rows of A^-1 are bounded apart; {sampled}.",
                **texts,
            )
            for n in SHOWN
        ),
        V12.row(
            f"{SAME}, {case.name}, largest over all n",
            AtMost(AGREE),
            readings.largest(_by_n(table, SAME, case.name)),
            source="H (2.5)",
            claimed="the fixed point is the step",
            reason="The same equations, in another basis.",
            **texts,
        ),
    ]
    if math.isfinite(case.radius):
        found += [
            V12.row(
                f"largest {name}, {case.name}, all n",
                AtMost(1.0),
                readings.largest(_by_n(table, name, case.name)),
                claimed="the potential's slope is Lipschitz continuous",
                reason=why,
                **texts,
            )
            for name, why in (
                (REACH, "Iterates stay within |w_1 - w_0| / (1 - k) of w_0 (Banach), and |q| at "
                 "the points within |q0| plus max_j |phi(c_j)|_1 times that: K holds there."),
                (SPREAD, "Measured; the proof is the row above."),
            )
        ]  # fmt: skip
    return found


def _by_n(table: DataFrame, quantity: str, study: str = STUDY) -> Array:
    return readings.values(table, "n", study=study, quantity=quantity)


def _over_bound(table: DataFrame, quantity: str, n: int, study: str = STUDY) -> float:
    limit, bound = (number(table, study=study, quantity=name, n=n) for name in (quantity, BOUND))
    return limit / bound


V12 = Claim(
    "V12",
    "The stage equations have one solution below a step",
    study,
    judge,
    source="H thm. 2.3.1",
    setup=f"oscillator, m = k = 1; Lagrange basis on {NS[0]} to {NS[-1]} Chebyshev points, test "
    "rows 1 .. n - 1, as H's proofs have them, where (2.8) prints 2 .. n; Gauss 2 n; norms of the "
    "largest row sum",
    claimed="contracts below the bound",
    reference="H's matrices, by numpy",
    statement="H lemmas 2.3.1, 2.3.2, thm. 2.3.1: the matrix A of a step is invertible, its "
    "inverse is bounded by that at h = 1, and the stage iteration contracts below a stated step.",
    caught=(
        of_table("galvi's pass against H's, largest relative difference, all n", C=1.0 + 1e-7),
        *(
            of_table(*(f"{SAME}, {case.name}, largest over all n" for case in NONLINEAR), **wrong)
            for wrong in ({"A": 1.0 + 1e-6}, {"beta": 1.0 + 1e-6})
        ),
    ),
)
