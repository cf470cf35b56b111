"""Forces on point masses: their values with odd fields, and runs with several of any strength."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

import numpy as np
from hypothesis import strategies as st

import galvi
from benchmarks.applications.fuzzing.arguments import COUNTS, ODD, STEPS
from benchmarks.applications.fuzzing.judgement import Call

SIZES = st.floats(1e-9, 10.0) | st.sampled_from([0.0, -1.0, 1e-160, 1e150])
POSITIVE = st.floats(1e-3, 1e3)
BODIES = st.integers(0, 3)
AXES = st.lists(st.floats(-2, 2), min_size=3, max_size=3) | st.just([0.0, 0.0, 1.0])
FORMS = st.sampled_from(["one source", "potential", "EIH"])
FEW = st.lists(st.floats(0, 1), min_size=3, max_size=3)


def branching(q: Any, *rest: Any) -> Any:
    """A force that cannot be traced."""
    return -q if q[0, 0] > 0.5 else 0.0 * q


FUNCTIONS = st.sampled_from(
    [
        branching,
        lambda q, *rest: q * np.nan,
        lambda q, *rest: q[0],
        lambda q, *rest: 0.0 * q,
        lambda q, *rest: -rest[0] if rest else q[:0],
    ]
)
# name -> (class, good values of its fields)
VALUES: Mapping[str, tuple[Callable[..., Any], Mapping[str, Any]]] = {
    "Relativity": (
        galvi.Relativity,
        {"c": POSITIVE, "source": BODIES, "form": FORMS},
    ),
    "Oblateness": (
        galvi.Oblateness,
        {"body": BODIES, "J2": SIZES, "radius": POSITIVE, "J4": SIZES, "pole": AXES},
    ),
    "Radiation": (galvi.Radiation, {"beta": FEW, "c": POSITIVE, "source": BODIES}),
    "Drag": (galvi.Drag, {"coefficients": FEW, "power": st.floats(0.1, 4.0)}),
    "Tides": (
        galvi.Tides,
        {"body": BODIES, "k2": SIZES, "radius": POSITIVE, "lag": SIZES, "spin": AXES,
         "raised_by": st.none() | BODIES},
    ),
    "PowerLaw": (
        galvi.PowerLaw,
        {"source": BODIES, "strength": SIZES, "power": st.floats(-6, 3) | st.just(-1.0)},
    ),
    "Force": (
        galvi.Force,
        {"function": FUNCTIONS, "takes_velocity": st.booleans(), "takes_time": st.booleans()},
    ),
}  # fmt: skip
ROOMS = [{}, {}, {}, {"clock": galvi.DynamicalTime()}, {"chart": galvi.KeplerFrame()}]


def forced(data: Any) -> Call:
    """Bodies with several forces, and at times an odd value among them; a state on the way."""
    n, dimension = data.draw(st.integers(2, 4)), data.draw(st.sampled_from([2, 3]))
    chosen = [
        VALUES[name] for name in data.draw(st.lists(st.sampled_from(sorted(VALUES)), max_size=3))
    ]
    drawn = [
        (kind, {key: data.draw(good) for key, good in fields.items()}) for kind, fields in chosen
    ]
    odd = data.draw(ODD) if data.draw(st.integers(0, 9)) == 0 else None
    masses = [1.0, *data.draw(st.lists(st.floats(1e-6, 0.1) | st.just(0.0), min_size=n - 1,
                                       max_size=n - 1))]  # fmt: skip
    place = st.floats(-2, 2)
    q0, v0 = (
        np.array(data.draw(st.lists(place, min_size=n * dimension, max_size=n * dimension)))
        .reshape(n, dimension) for _ in range(2)
    )  # fmt: skip
    s, room = data.draw(st.integers(1, 8)), data.draw(st.sampled_from(ROOMS))
    step, steps, share = data.draw(STEPS), data.draw(COUNTS), data.draw(st.floats(0.0, 1.0))

    def call() -> Any:
        forces = [kind(**fields) for kind, fields in drawn]
        problem = galvi.Problem(
            galvi.NBody(masses, forces=forces if odd is None else [*forces, odd]), q0, v0
        )
        method = galvi.Galerkin(galvi.Polynomials(s), galvi.gauss(s), **room)
        run = galvi.integrate(problem, method, step, steps)
        if run.success:
            t = min(max(run.t[0] + share * (run.t[-1] - run.t[0]), run.t.min()), run.t.max())
            for value in (run(t), run.velocity(t), *galvi.states_at(run, t)):
                if not np.isfinite(value).all():
                    raise AssertionError(f"not finite at {t!r}")
        return run

    text = ", ".join(f"{kind.__name__}({fields})" for kind, fields in drawn)
    given = f"{masses}, {q0.tolist()}, {v0.tolist()}, {text}, {odd!r:.60}, s={s}, {room}"
    return call, f"forces: {given}, {step}, {steps}"[:900]
