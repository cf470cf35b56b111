"""V28: rates in N and h for motions with s derivatives, and M's open question (M (13), sec. 5)."""

from __future__ import annotations

from scipy.integrate import quad

from benchmarks.claims.kit import *
from benchmarks.claims.vector_spaces import singular_approximation
from benchmarks.claims.vector_spaces.singular_approximation import (
    closed_errors,
    path_error,
    quadrature_error,
)
from benchmarks.measures.best_approximation import best_errors
from benchmarks.test_problems.oscillators import SingularDrive

BEST, CLOSED = "error of the best polynomial", "the same in closed form"
LARGEST, PATH = "e_max", "error along the path"
MOTION = "distance of the motion from its integral"
INSIDE, END = (0.5, 0.3, 0.1), 0.0  # t* in [0, 1]
EXPONENTS = (0.49, 0.45, 0.25, -0.25, -0.55)
ROUGH = (0.49, 0.45, 0.25)  # of the rates in h
POWERS = (16, 24, 32, 48, 64, 96, 128, 192)  # degrees N; the quick form leaves out the last
AT_END = 64  # the largest there, where errors fall twice as fast
DEGREES = (1, 2, 4)
PLACE = 1.0 / 3.0  # with K = 3 m + 1 subintervals, at a third of the one that contains it
COUNTS = (4, 7, 10, 16, 22, 31, 43, 64, 91, 127, 181, 256)
QUICK_COUNTS = COUNTS[:9]
FLOOR = 1e-12
TIMES = (0.1, 0.4, 0.9)


def _shift(sizes: Array, departures: Array) -> float:
    """The largest change of a fitted power of `sizes` by relative errors of up to these sizes."""
    x = np.log(sizes) - np.mean(np.log(sizes))
    return float(np.sum(abs(x) * departures) / np.sum(x**2))


def _in_windows() -> tuple[float, float]:
    """How well a power of N and an order in h are known from the shorter of the windows.

    Inside, the square of the error is a sum over k >= N of terms like k^(-2 p - 1)
    cos^2((k + 1/2) theta + const), p = 3/2 - b and cos(theta) = 2 t* - 1, which departs from its
    power by p / (N sin(theta)) of itself, in either direction; at an end by N^-2. In h the next
    term of u is smaller by r^2 / ((2 - b) (3 - b)), r = |t - t*| < h, which is below h^2.
    """
    N, h = np.array(POWERS[:-1], dtype=np.float64), 1.0 / np.array(QUICK_COUNTS)
    sine = min(2.0 * np.sqrt(place * (1.0 - place)) for place in INSIDE)
    return _shift(N, (1.5 - min(EXPONENTS)) / (2.0 * sine * N)), _shift(h, h**2)


RESOLUTION, H_RESOLUTION = _in_windows()  # 0.064 and 0.016


def named(place: float, b: float) -> str:
    """The study of a motion."""
    return f"t* = {place:g}, b = {b:g}"


def study(make_method: MakeMethod, quick: bool, report: Report) -> DataFrame:
    """By degree, n = N + 1, the error of one best polynomial on [0, 1], by two means; by the number
    of subintervals, e_max, and the error of galvi's step through t*; the motion by two means.
    """
    found: list[dict[str, Any]] = []
    for place in (*INSIDE, END):
        report(f"t* = {place:g}")
        for b in EXPONENTS:
            found += _in_degree(SingularDrive(place, b), quick)
    for b in ROUGH:
        drive = SingularDrive(PLACE, b, spring=True)
        report(f"K subintervals, b = {b:g}")
        found.append(row(study=named(PLACE, b), quantity=MOTION, value=_distance(drive)))
        for degree in DEGREES:
            method = make_method(galvi.Polynomials(degree), galvi.gauss(degree + 1))
            for count in QUICK_COUNTS if quick else COUNTS:
                found += _in_step(drive, method, degree, count)
    return frame(found)


def _in_degree(drive: SingularDrive, quick: bool) -> list[dict[str, Any]]:
    last = AT_END if drive.place == END else POWERS[-2] if quick else POWERS[-1]
    degrees = [N for N in POWERS if last >= N]
    closed, found = closed_errors(drive.place, drive.b, 0.0, 1.0, degrees), []
    for N, other in zip(degrees, closed, strict=True):
        values = {BEST: quadrature_error(drive.motion, drive.place, 0.0, 1.0, N), CLOSED: other}
        found += rows(values, study=named(drive.place, drive.b), n=N + 1)
    return found


def _in_step(drive: SingularDrive, method: Any, degree: int, count: int) -> list[dict[str, Any]]:
    edges = np.linspace(0.0, 1.0, count + 1)
    k = int(drive.place * count)
    errors = best_errors(drive.motion, edges, degree)
    errors[k] = quadrature_error(drive.motion, drive.place, edges[k], edges[k + 1], degree)
    run = galvi.integrate(drive.problem(float(edges[k])), method, 1.0 / count, 1)
    values = {
        LARGEST: errors.max(),
        PATH: path_error(run, drive.motion, drive.place) if run.success else float("nan"),
    }
    where = {"n": degree + 1, "step": 1.0 / count, "steps": count}
    return rows(values, study=named(drive.place, drive.b), status=failure(run), **where)


def _distance(drive: SingularDrive) -> float:
    """Largest distance of u and u' from int f(x - r) r^-b dr, f = sin, cos, by QUADPACK's QAWS."""
    apart = []
    for t in TIMES:
        x = abs(t - drive.place)
        u, v = (float(part) for part in drive.motion(np.array(t)))
        for found, f in ((u, np.sin), (abs(v), np.cos)):
            integral = quad(lambda r, f=f, x=x: f(x - r), 0.0, x, weight="alg", wvar=(-drive.b, 0))
            apart.append(abs(found - integral[0]))
    return max(apart)


def judge(table: DataFrame) -> list[Row]:
    """Rows for the power of N by place and exponent, then for the order in h."""
    return [
        *(_middle(table, b) for b in EXPONENTS),
        *(_elsewhere(table, place) for place in INSIDE[1:]),
        *(_at_end(table, b) for b in EXPONENTS),
        *_powers_found(table),
        *_largest(table),
        *(_path(table, b, degree) for b in ROUGH for degree in DEGREES),
        *_oracles(table),
    ]


DRIVE = "u'' = |t - t*|^-b, u = u' = 0 at t*, so that s = {} derivatives are in L^2"
DRIVEN = "u'' + u = |t - t*|^-b, u = u' = 0 at t*, so that s = 2 derivatives are in L^2"
WHOLE = "one polynomial of degree N = 16 to 192 (128 in the quick form; 64 for t* = 0) on [0, 1]"
PRINTED = "N^-s in |.|_X, s = {0}, times a norm of u, which is |u^(s)| from N = s - 1 on"
LOST = (
    "Inside, Legendre's series of u' ~ sign(t - t*) |t - t*|^(1 - b) has an error of "
    "N^-(3/2 - b), which for s derivatives, s - 1 < 3/2 - b < s, is never N^-s, and comes near "
    "N^(1 - s): N^-s is the rate in L^2, and |.|_X has a derivative more"
)
SCAN = "scanned: t* = 0.5, 0.3, 0.1 and 0; b = " + ", ".join(f"{b:g}" for b in EXPONENTS)
TWO_MEANS = "graded quadrature; Legendre coefficients in closed form agree to {:.0e}"


def _smoothness(b: float) -> int:
    return SingularDrive(0.5, b).smoothness


def _power(table: DataFrame, place: float, b: float) -> Fit:
    return readings.power(table, FLOOR, study=named(place, b), quantity=BEST)


def _rates(table: DataFrame, places: Iterable[float], exponents: Iterable[float]) -> Array:
    """The fitted powers, (places, exponents)."""
    chosen = tuple(exponents)
    return np.array([[_power(table, place, b).rate for b in chosen] for place in places])


def _printed(table: DataFrame, s: int, b: str, place: str) -> dict[str, str]:
    return {
        "setup": f"{DRIVE.format(s)}; t* = {place}, b = {b}; {WHOLE}; {SCAN}",
        "claimed": PRINTED.format(s),
        "reference": TWO_MEANS.format(_apart(table)),
    }


def _middle(table: DataFrame, b: float) -> Row:
    s = _smoothness(b)
    return V28.row(
        f"power of 1 / N, {named(INSIDE[0], b)}",
        AtLeast(float(s), round_off=RESOLUTION, uncertainty=0.0),
        _power(table, INSIDE[0], b),
        expected=CONTRADICTED,
        reason=f"{LOST}.",
        **_printed(table, s, f"{b:g}", f"{INSIDE[0]:g}"),
    )


def _elsewhere(table: DataFrame, place: float) -> Row:
    smooth = [b for b in EXPONENTS if _smoothness(b) == 2]
    return V28.row(
        f"largest power of 1 / N over b, s = 2, t* = {place:g}",
        AtLeast(2.0, round_off=RESOLUTION),
        readings.largest(_rates(table, [place], smooth).ravel()),
        expected=CONTRADICTED,
        reason=f"{LOST}.",
        **_printed(table, 2, ", ".join(f"{b:g}" for b in smooth), f"{place:g}"),
    )


def _at_end(table: DataFrame, b: float) -> Row:
    s = _smoothness(b)
    return V28.row(
        f"power of 1 / N, {named(END, b)}",
        AtLeast(float(s), round_off=RESOLUTION, uncertainty=0.0),
        _power(table, END, b),
        reason="At an end the error is N^-(3 - 2 b), with twice the exponent: polynomials resolve "
        "1 / N^2 there. For such a power at an end, with s of 2 or more, M's rate holds.",
        **_printed(table, s, f"{b:g}", f"{END:g}"),
    )


def _powers_found(table: DataFrame) -> list[Row]:
    said = 1.5 - np.array(EXPONENTS)
    inside, ends = _rates(table, INSIDE, EXPONENTS), _rates(table, [END], EXPONENTS)
    fits = [(_power(table, place, b), _smoothness(b)) for place in INSIDE for b in EXPONENTS]
    fit, s = min(fits, key=lambda one: one[0].rate - one[1])
    shared = {
        "setup": f"{DRIVE.format('2, or 3 for b = -0.55')}; {WHOLE}; {SCAN}",
        "reference": TWO_MEANS.format(_apart(table)),
    }
    return [
        V28.row(
            "largest departure of the power of 1 / N from 3/2 - b, t* inside",
            Finding(AtMost(RESOLUTION)),
            readings.largest(abs(inside - said).ravel()),
            claimed="N^-s; our value: N^-(3/2 - b)",
            reason="Coefficients of Legendre's series fall like k^(b - 3/2), and the error is the "
            "root of the sum of their squares over 2 k + 1, from k = N on.",
            **shared,
        ),
        V28.row(
            "largest departure of the power of 1 / N from 3 - 2 b, t* = 0",
            Finding(AtMost(RESOLUTION)),
            readings.largest(abs(ends - 2.0 * said).ravel()),
            claimed="N^-s; our value: N^-(3 - 2 b)",
            reason="With X = cos(theta), |t|^(1 - b) is like theta^(2 - 2 b).",
            **shared,
        ),
        V28.row(
            "least of the power of 1 / N less s - 1, t* inside",
            Finding(AtLeast(0.0, uncertainty=0.0)),
            Estimate(fit.rate - (s - 1.0), fit.uncertainty),
            claimed="N^-s; our value: N^(1 - s)",
            reason="3/2 - b is above s - 1, and comes as near as one likes: N^(1 - s) is sharp.",
            **shared,
        ),
    ]


def _order(table: DataFrame, quantity: str, b: float, degree: int) -> Fit:
    return readings.order(table, FLOOR, study=named(PLACE, b), quantity=quantity, n=degree + 1)


def _in_h(table: DataFrame) -> dict[str, str]:
    return {
        "setup": f"{DRIVEN}; t* = 1/3; K = 3 m + 1 = 4 to 256 (91 in the quick form) "
        "subintervals of [0, 1]",
        "source": "M sec. 5, (13)",
        "reference": "closed form; QUADPACK's integral of the motion agrees to "
        f"{_motion(table):.0e}",
    }


def _largest(table: DataFrame) -> list[Row]:
    orders = np.array([[_order(table, LARGEST, b, N).rate for N in DEGREES] for b in ROUGH])
    return [
        V28.row(
            "least order of e_max, all b and N",
            AtLeast(1.0),
            readings.least(orders.ravel()),
            claimed="h^(min(s, N + 1) - 1), s = 2",
            reason="Errors of the subinterval with t* scale like |u''| in L^2 there, h^(1/2 - b), "
            "times h.",
            **_in_h(table),
        ),
        V28.row(
            "largest departure of the order of e_max from 3/2 - b, all b and N",
            Finding(AtMost(H_RESOLUTION)),
            readings.largest(abs(orders.T - 1.5 + np.array(ROUGH)).ravel()),
            claimed="at least h^1; our value: h^(3/2 - b)",
            reason="Near t* the motion is |t - t*|^(2 - b), which scales with h.",
            **_in_h(table),
        ),
    ]


def _path(table: DataFrame, b: float, degree: int) -> Row:
    return V28.row(
        f"order of the error along the path, b = {b:g}, N = {degree}",
        Finding(Order(1.5 - b, resolution=H_RESOLUTION)),
        _order(table, PATH, b, degree),
        claimed="h^1, as e_max; M knows no mechanical system of which this order is measured",
        reason="An oscillator driven by |t - t*|^-b is one: its step through t* has an error of "
        "h^(3/2 - b) in |.|_X, in best approximation and rule alike, and 3/2 - b tends to 1 with "
        "b to 1/2.",
        **{
            **_in_h(table),
            "setup": f"{_in_h(table)['setup']}; the step through t*, from the exact state; "
            "Polynomials(N), gauss(N + 1)",
        },
    )


def _oracles(table: DataFrame) -> list[Row]:
    shared = {
        "claimed": "no claim: check of the reference",
        "setup": f"{DRIVE.format('2 or 3')}; {SCAN}",
    }
    return [
        V28.row(
            "distance between the two references, best approximation, relative",
            Finding(AtMost(1e-4)),
            _apart(table),
            reason="Compared where the closed form, a difference of squares, has digits left; an "
            "error of 1e-4 changes no power by as much.",
            reference="graded quadrature; Legendre coefficients in closed form",
            **shared,
        ),
        V28.row(
            "distance between the two references, motion",
            Finding(AtMost(1e-6)),
            _motion(table),
            reason="The bound is a tenth of the least error along the path, 1e-5.",
            reference="power series; QUADPACK's integral with an algebraic weight",
            **shared,
        ),
    ]


def _apart(table: DataFrame) -> float:
    """Of quadrature and closed form, the largest relative distance."""
    by = ["study", "n"]
    best, other = (pick(table, quantity=name).set_index(by)["value"] for name in (BEST, CLOSED))
    apart = abs(other.reindex(best.index) / best - 1.0).to_numpy(np.float64)
    return readings.largest(apart[np.isfinite(apart)])


def _motion(table: DataFrame) -> float:
    return readings.largest_of(table, quantity=MOTION)


V28 = Claim(
    "V28",
    "Rates in N and h at finite smoothness",
    study,
    judge,
    ("M sec. 5",),
    source="M (13)",
    statement="M (13): at smoothness s the best approximation converges like N^-s. Measured: "
    "where the singularity is inside the interval down to N^(1 - s), so that the claim is "
    "contradicted; where it is at an end the claim holds.",
    caught=(
        Fault(
            "a coarse quadrature",
            {"distance between the two references, best approximation, relative"},
            wrong={
                f"{singular_approximation.__name__}.graded_nodes": given(
                    lambda *these: (*these[:3], these[3] // 4)
                )
            },
        ),
        Fault(
            "another motion",
            {"distance between the two references, motion"},
            wrong={"benchmarks.test_problems.oscillators.SingularDrive.motion": scaled(1.0 + 1e-4)},
        ),
        of_motion(
            "a singularity elsewhere",
            {f"order of the error along the path, b = 0.49, N = {N}" for N in (2, 4)},
            lambda problem: replace(problem, t0=problem.t0 - 0.01),
        ),
    ),
)
