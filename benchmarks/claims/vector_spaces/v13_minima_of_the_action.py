"""V13: stationary points are minima, and the action coercive, below a step (H 2.3.5, 2.3.8)."""

from __future__ import annotations

from scipy.linalg import eigvalsh, null_space

from benchmarks.claims.kit import *
from benchmarks.measures.independent_space import all_of_degree, gauss_points, grams, values

N = 8
LEAST, FORM, NORM = "least eigenvalue", "over the lower form", "over the W11 bound"
FARTHEST = "largest |q|"
OSCILLATOR, QUARTIC = "oscillator", "quartic potential"
REACH = 1.05  # the interval |q| <= REACH on which V'' of the quartic potential is bounded
RATIOS = np.round(np.arange(0.1, 2.4001, 0.05), 10)  # step over the bound for minima
DIRECTIONS = 64  # random variations in addition to the eigenvectors
FINE = 400  # quadrature points for the integrals of |q| in W11
SLACK = 1e-9
ROUND_OFF = 1e-12  # 2e-15 was measured
EXACT, ZERO = "s = 7, exact integrals", "first step without a positive least eigenvalue"
HALVINGS = 40
ONE_STEP = f"; one step, Polynomials({N - 1}), gauss({N}), end points fixed"


@dataclass(frozen=True)
class Case:
    """A problem with m = D = 1.

    second  V''(q)
    widest  C_R, the bound of |V''| on the stated interval
    """

    problem: Problem
    second: Callable[[Array], Array]
    widest: float
    setup: str

    @property
    def minimum(self) -> float:
        """The bound on the step of H 2.3.5, pi sqrt(m / (D C_R)); 2.3.8 has 2 C_R."""
        return float(np.pi / np.sqrt(self.widest))


def cases() -> dict[str, Case]:
    """The oscillator from q = 1 and V = q^4 / 4 from q = 1, both at rest."""
    quartic = galvi.Canonical(
        1.0,
        lambda q: 0.25 * q[0] ** 4,
        lambda q: q**3,
        lambda q: np.array([[3.0 * q[0] ** 2]]),
    )
    return {
        OSCILLATOR: Case(
            galvi.problems.harmonic_oscillator(),
            np.ones_like,
            1.0,
            "oscillator, m = k = 1, from q = 1 at rest, C_R = 1",
        ),
        QUARTIC: Case(
            Problem(quartic, [1.0], [0.0]),
            lambda q: 3.0 * q**2,
            3.0 * REACH**2,
            f"V = q^4 / 4, from q = 1 at rest, |q| <= {REACH:g}, C_R = {3.0 * REACH**2:.4g}",
        ),
    }


def study(make_method: MakeMethod, quick: bool, report: Report) -> DataFrame:
    """For each case and step, along the step's curve: the least eigenvalue of the discrete second
    variation, its least ratio to H (2.22)'s form, and to the bound in W^{1,1}."""
    method = make_method(galvi.Polynomials(N - 1), galvi.gauss(N))
    found = []
    for name, case in cases().items():
        report(name)
        for h in case.minimum * (RATIOS[::2] if quick else RATIOS):
            found += _step(name, case, method, float(h))
        found += rows({ZERO: _zero(case, method)}, study=name, n=N)
    few = make_method(galvi.Polynomials(2), galvi.lobatto(3))
    for name, one in (("s = 2, Lobatto 3", few), ("s = 7, Gauss 8", method)):
        found += rows({LEAST: _rayleigh(one)}, study=name)
    return frame(found + rows({LEAST: _exact_rayleigh(N - 1)}, study=EXACT))


def _zero(case: Case, method: Any) -> float:
    """The first step without a positive least eigenvalue, by bisection; NaN if there is none."""

    def bent(h: float) -> bool:
        return not _step("", case, method, h)[0]["value"] > 0.0

    low, high = 0.0, next((h for h in case.minimum * RATIOS if bent(h)), math.nan)
    for _ in range(HALVINGS if high > 0.0 else 0):
        middle = 0.5 * (low + high)
        low, high = (low, middle) if bent(middle) else (middle, high)
    return high


def _step(name: str, case: Case, method: Any, h: float) -> list[dict[str, Any]]:
    run = galvi.integrate(case.problem, method, h, 1)
    found = dict.fromkeys((LEAST, FORM, NORM, FARTHEST), float("nan"))
    if run.success:
        q = run.curves.bases[0, 0] + method.table.psi @ run.curves.coefficients[0, 0]
        found = _variation(method.table, method.space, h, case.second(q), case.widest)
        found[FARTHEST] = float(np.max(np.abs(q)))
    return rows(found, study=name, n=N, step=h, steps=1, status=failure(run))


def _variation(table: Any, space: Any, h: float, second: Array, widest: float) -> dict[str, float]:
    """Ratios of the second variation with fixed end points; variations are psi free x."""
    free = null_space(table.end[None, :])
    place, rate = table.psi @ free, table.slope @ free / h
    b = h * table.b[:, None]
    slopes, places = rate.T @ (b * rate), place.T @ (b * place)
    whole = slopes - place.T @ (b * second[:, None] * place)
    least, vectors = _eigen(whole, slopes)
    level = 0.5 * (np.pi / h) ** 2 - widest
    found = {LEAST: float(least[0]), FORM: float("nan"), NORM: float("nan")}
    if level > 0.0:
        lower = 0.5 * slopes + level * places
        found[FORM] = float(eigvalsh(whole, lower, subset_by_index=[0, 0])[0])
        random = np.random.default_rng(13).normal(size=(len(whole), DIRECTIONS))
        directions = np.hstack([vectors, random])
        norm = _w11(space, free, h) @ directions
        size = h / FINE * np.sum(np.abs(norm), axis=(0, 1))
        spent = np.einsum("ik,ij,jk->k", directions, whole, directions)
        constant = min(0.25 / h, 0.5 / h * level)
        found[NORM] = float(np.min(spent / (constant * size**2)))
    return found


def _eigen(whole: Array, slopes: Array) -> tuple[Array, Array]:
    root = np.linalg.cholesky(slopes)
    inner = np.linalg.solve(root, np.linalg.solve(root, whole).T)
    squares, vectors = np.linalg.eigh(0.5 * (inner + inner.T))
    return squares, np.linalg.solve(root.T, vectors)


def _w11(space: Any, free: Array, h: float) -> Array:
    """Values and rates of variations at midpoints, (2, FINE, free)."""
    tau = (np.arange(FINE) + 0.5) / FINE
    psi = (space.basis(tau) - space.basis(np.zeros(1)))[:, 1:]
    return np.stack([psi @ free, space.derivative(tau)[:, 1:] @ free / h])


def _rayleigh(method: Any) -> float:
    """The h at which the oscillator's least eigenvalue is 0, over pi."""
    table = method.table
    free = null_space(table.end[None, :])
    place, rate = table.psi @ free, table.slope @ free
    b = table.b[:, None]
    least = eigvalsh(rate.T @ (b * rate), place.T @ (b * place))[0]
    return float(np.sqrt(least) / np.pi)


def _exact_rayleigh(degree: int) -> float:
    """The same in Legendre polynomials of this degree that vanish at both ends, by numpy."""
    functions = all_of_degree(degree)
    free = null_space(values(functions, np.array([0.0, 1.0])).T)
    seen = grams(functions, *gauss_points(degree + 1))
    least = eigvalsh(free.T @ seen.slope @ free, free.T @ seen.place @ free)[0]
    return float(np.sqrt(least) / np.pi)


def judge(table: DataFrame) -> list[Row]:
    """Rows for the signs below the bounds, where they are lost, and the exactness of the rule."""
    signs = [row for name, case in cases().items() for row in _signs(table, name, case)]
    found, exact = (number(table, study=one, quantity=LEAST) for one in ("s = 7, Gauss 8", EXACT))
    return [
        *signs,
        V13.row(
            "that step over the one of exact integrals, less 1, oscillator",
            Near(0.0, ROUND_OFF),
            found / exact - 1.0,
            setup=cases()[OSCILLATOR].setup + ONE_STEP,
            claimed="the rule is exact for squares of functions of the space",
            reason="The same eigenvalue, in Legendre polynomials by numpy.",
        ),
        V13.row(
            "step where the least eigenvalue is 0, over the bound, a rule of degree 2 s - 1",
            Near(math.sqrt(8.0) / math.pi, SLACK),
            number(table, study="s = 2, Lobatto 3", quantity=LEAST),
            setup="oscillator; polynomials of degree 2, Lobatto 3 (degree 3)",
            claimed="asks for a rule of degree 2 s",
            reason="Below 1: it cannot be dropped. Simpson's rule makes the integral of "
            "t^2 (1 - t)^2 5/4 of what it is: sqrt(8) / pi.",
        ),
    ]


def _signs(table: DataFrame, name: str, case: Case) -> list[Row]:
    """Rows for positivity below the bounds, and for the step at which it is lost."""

    def least(quantity: str, below: float) -> float:
        h, found = series(table, "step", study=name, quantity=quantity)
        return readings.least(found[h < below])

    setup = case.setup + ONE_STEP
    coercive = {"source": "H thm. 2.3.8", "setup": setup}
    shortest = math.sqrt(0.5) * case.minimum
    signs = [
        V13.row(
            f"least eigenvalue over all steps below the bound, {name}",
            Above(0.0),
            least(LEAST, case.minimum),
            setup=setup,
            claimed="minimum for h < pi sqrt(m / (D C_R))",
            reason="Poincare's inequality holds in the space, and the rule is exact for squares of "
            "its functions.",
        ),
        V13.row(
            f"step where the least eigenvalue is 0, over the bound, {name}",
            AtLeast(1.0, round_off=SLACK),
            number(table, study=name, quantity=ZERO) / case.minimum,
            setup=setup,
            claimed="at least 1",
            reason="Sharp for the oscillator, whose V'' is C_R everywhere; the quartic's V'' is "
            "smaller along most of the motion.",
        ),
        V13.row(
            f"second variation over H (2.22), least below the coercive bound, {name}",
            AtLeast(1.0, round_off=SLACK),
            least(FORM, shortest),
            claimed="D2S at least (2.22) below pi sqrt(m / (2 D C_R))",
            reason="Half of the kinetic part pays for the potential one.",
            **coercive,
        ),
        V13.row(
            f"second variation over C_f |dq|^2 in W11, least below the coercive bound, {name}",
            AtLeast(1.0),
            least(NORM, shortest),
            claimed="D2S at least C_f |dq|^2, C_f = min(m / 4 h, (m pi^2 / 2 h^2 - D C_r) / 2 h)",
            reason="Holder's inequality and a square completed, both safe.",
            **coercive,
        ),
    ]
    if name == OSCILLATOR:
        return signs
    farthest = V13.row(
        "largest |q| at the stages, all steps",
        AtMost(REACH),
        readings.largest_of(table, study=name, quantity=FARTHEST),
        setup=setup,
        claimed="on the stated interval",
        reason="The energy keeps the motion in [-1, 1], but for the step's error.",
    )
    return [*signs, farthest]


V13 = Claim(
    "V13",
    "Curves of steps are minima, the action coercive",
    study,
    judge,
    source="H thm. 2.3.5",
    reference="V'' of the textbook along the step's curve",
    statement="H thm. 2.3.5, 2.3.8: below h = pi sqrt(m / (D C_R)) a step is a minimum of the "
    "action, and below a smaller bound the action is coercive, with a rule that is exact for "
    "squares of functions of the space.",
    caught=(
        of_table(
            "step where the least eigenvalue is 0, over the bound, oscillator",
            "second variation over H (2.22), least below the coercive bound, oscillator",
            psi=1.0 + 1e-6,
        ),
        of_table("least eigenvalue over all steps below the bound, oscillator", psi=2.5),
        of_table("that step over the one of exact integrals, less 1, oscillator", slope=1.0 + 1e-9),
    ),
)
