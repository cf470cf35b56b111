"""L11: stationary points are minima, and coercive, below a step (H lemmas 3.3.1 and 3.3.2)."""

from __future__ import annotations

from benchmarks.claims.kit import *
from benchmarks.claims.lie_groups.pendulum_motion import MOTION, problem
from benchmarks.measures.second_variation import constants, one_step, over_lower_form, smallest

N = 16
LEAST, MINIMUM, COERCIVE = "least eigenvalue", "bound on the step", "coercive bound on the step"
FORM = "least over the lower form"
LONG = 2.2  # a step well past the zero
PENDULUM, FREE = "3D pendulum, Cayley chart", "free rigid body, exponential chart"
SETUPS = {
    PENDULUM: MOTION,
    FREE: "free rigid body, J = diag(3.3, 2.5, 3.4), R0 = I, body velocity (2, -1.9, 1)",
}
BELOW_BOUND = "minimum for h below the bound"
FORMULA = (
    "C_xi' = C_p / 2, C_xi = C_d + C_m^2 / (2 C_p), C_V of H's proof, with the trace and the half "
    "that H's kinetic energy lacks and the factor 2 of the mixed term, maximised along the curve"
)


def study(make_method: MakeMethod, quick: bool, report: Report) -> DataFrame:
    """For each case and step: the least eigenvalue of the discrete second variation against the
    integral of |dxi'|^2, H's two bounds on the step, and the second variation over H's lower form.
    """
    found = []
    sizes = np.round(np.arange(0.1, 2.41, 0.1 if quick else 0.05), 10).tolist()
    for name in SETUPS:
        report(name)
        start, method = _case(name, make_method)
        for h in sizes:
            found += _step(name, start, method, h)
    return frame(found)


def _case(name: str, make_method: MakeMethod) -> tuple[Problem, Any]:
    space, rule = galvi.Polynomials(N - 1), galvi.gauss(N)
    if name == PENDULUM:
        return problem(), make_method(space, rule)
    return galvi.problems.free_rigid_body(), make_method(space, rule, galvi.Exponential())


def _step(name: str, start: Problem, method: Any, h: float) -> list[dict[str, Any]]:
    run = one_step(start, method, h)
    values = dict.fromkeys((LEAST, MINIMUM, COERCIVE, FORM), float("nan"))
    if run.success:
        known = constants(run)
        values = {
            LEAST: smallest(run),
            MINIMUM: known.minimum,
            COERCIVE: known.coercive,
            FORM: over_lower_form(run, known),
        }
    return rows(values, study=name, n=N, step=h, steps=1, status=failure(run))


def judge(table: DataFrame) -> list[Row]:
    """The step at which the second variation loses its sign, against the bounds of H's proof."""
    zero = _crossing(*_rising(table, PENDULUM, LEAST))
    minimum, coercive = (_reached(table, quantity) for quantity in (MINIMUM, COERCIVE))
    setup = _setup(PENDULUM)
    first, second = {"source": "H lemma 3.3.1"}, {"source": "H lemma 3.3.2"}
    return [
        *(
            L11.row(
                f"step where the least eigenvalue is 0, over H's {quantity}, {PENDULUM}",
                AtLeast(1.0),
                zero / reached,
                setup=setup,
                claimed=claimed,
                reason=f"The bound, with constants along the curve of that step, is {reached:.3g}; "
                f"the eigenvalue is 0 at {zero:.3g}.",
                **lemma,
            )
            for quantity, reached, claimed, lemma in (
                (MINIMUM, minimum, BELOW_BOUND, first),
                (COERCIVE, coercive, "coercive for h below the bound", second),
            )
        ),
        L11.row(
            f"least eigenvalue at h = {LONG:g}, {PENDULUM}",
            Finding(Below(0.0)),
            number(table, study=PENDULUM, quantity=LEAST, step=LONG),
            setup=setup,
            claimed="minima 'given a time step restriction on h' (the sentence before the lemma, "
            "and its proof); the lemma's own sentence does not repeat it",
            reason=f"Past a conjugate point, here at {zero:.3g}, a motion is no minimum: the "
            "restriction is needed.",
            **first,
        ),
        *(row for name in SETUPS for row in _below_the_bounds(table, name)),
    ]


def _below_the_bounds(table: DataFrame, name: str) -> list[Row]:
    h, least = _rising(table, name, LEAST)
    _, limit = _rising(table, name, MINIMUM)
    _, form = _rising(table, name, FORM)
    return [
        L11.row(
            f"least eigenvalue over all steps below the bound, {name}",
            Above(0.0),
            _least(least[h < limit]),
            source="H lemma 3.3.1",
            setup=_setup(name),
            claimed=BELOW_BOUND,
            reason="Each of the estimates is a safe one.",
        ),
        L11.row(
            "second variation over H's lower form, least over all steps below the coercive bound, "
            f"{name}",
            AtLeast(1.0),
            _least(form),
            source="H lemma 3.3.2",
            setup=_setup(name),
            claimed="D2S at least (3.30)",
            reason="Completing the square gives away a factor 2 at small steps: C_xi' = C_p / 2.",
        ),
    ]


def _setup(name: str) -> str:
    return (
        f"{SETUPS[name]}; Polynomials({N - 1}), gauss({N}); one step of h = 0.1 to 2.4; {FORMULA}"
    )


def _rising(table: DataFrame, name: str, quantity: str) -> tuple[Array, Array]:
    """Steps, ascending, and values."""
    h, values = series(table, "step", study=name, quantity=quantity)
    return h[::-1], values[::-1]


def _least(values: Array) -> float:
    """The least of the known values; NaN when none is known."""
    return readings.least(values[np.isfinite(values)])


def _crossing(h: Array, values: Array) -> float:
    """The first h where values that start positive reach 0, between two steps; NaN if none."""
    past = np.flatnonzero(values <= 0.0)
    if not past.size or past[0] == 0:
        return float("nan")
    k = past[0]
    share = values[k - 1] / (values[k - 1] - values[k])
    return float(h[k - 1] + share * (h[k] - h[k - 1]))


def _reached(table: DataFrame, quantity: str) -> float:
    """The step that is as long as the bound on it."""
    h, limit = _rising(table, PENDULUM, quantity)
    return _crossing(h, limit - h)


L11 = Claim(
    "L11",
    "Stationary points are minima and coercive below a step",
    study,
    judge,
    reference="second derivatives of the textbook's T and V, end points fixed",
    statement="H lemmas 3.3.1, 3.3.2: below bounds on the step stationary points are minima, and "
    "the action is coercive.",
    caught=(
        *(
            Fault(
                f"a constant that is too good: {name}",
                bool,
                wrong={
                    f"{__name__}.constants": lambda sound, name=name, by=by: (
                        lambda run: replace(
                            known := sound(run), **{name: by * getattr(known, name)}
                        )
                    )
                },
            )
            for name, by in (("speed", 4.0), ("well", 0.0))
        ),
    ),
)
