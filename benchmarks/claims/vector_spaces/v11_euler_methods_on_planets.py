"""V11: the solar system by explicit, implicit and symplectic Euler (H figure 1.1)."""

from __future__ import annotations

import numpy as np

import galvi
from benchmarks.claims.kit import (
    OTHER_TRUTH,
    DataFrame,
    Fault,
    MakeMethod,
    Measurement,
    Problem,
    Report,
    readings,
    reversed_clock,
    rows,
    scaled,
    table_of,
    times,
    with_arguments,
)
from benchmarks.claims.vector_spaces.euler_readings import (
    EXPLICIT,
    IMPLICIT,
    SOLVED,
    STOPPED,
    SYMPLECTIC,
    energy_rows,
    implicit_rows,
    refinement_rows,
)
from benchmarks.claims.vector_spaces.implicit_euler_orbit import (
    DAYS_PER_YEAR,
    PRINTED_STEP,
    SMALLER,
    escapes,
)
from references.textbook.euler import EXPLICIT_EULER, SYMPLECTIC_EULER
from references.textbook.implicit_euler import IMPLICIT_EULER

METHODS = {EXPLICIT: EXPLICIT_EULER, IMPLICIT: IMPLICIT_EULER, SYMPLECTIC: SYMPLECTIC_EULER}


def problem() -> Problem:
    """The Sun and eight planets without Pluto, as in H."""
    return galvi.problems.solar_system(pluto=False)


def study(make_method: MakeMethod, quick: bool, report: Report) -> DataFrame:
    """The rows of `refined`, `energies`, `stops` and `escapes`, and the number of planets that are
    lost if unconverged steps are accepted."""
    system = problem()
    lines = (
        refinement_rows(METHODS, system)
        + energy_rows(METHODS, system)
        + implicit_rows(METHODS[IMPLICIT], system)
    )
    setting = {"step": PRINTED_STEP * DAYS_PER_YEAR, "accept_unconverged": True}
    q = IMPLICIT_EULER.run(system, 3.0 * DAYS_PER_YEAR, setting).q[-1]
    from_sun = np.linalg.norm(q[1:4] - q[0], axis=-1)
    gone = {
        "how many of Mercury, Venus and Earth are beyond 10 au after 3 years, unconverged steps "
        "accepted, implicit Euler": np.sum(from_sun > 10.0)
        if np.isfinite(from_sun).all()
        else np.nan
    }
    return table_of([*lines, *rows(escapes(system, 20 if quick else 200) | gone)])


def read(table: DataFrame) -> dict[str, Measurement]:
    """The orders of the quantities measured at several steps, and the numbers without a series."""
    without_series = table[table["study"] == ""]
    numbers: dict[str, Measurement] = dict(
        zip(without_series["quantity"], without_series["value"], strict=True)
    )
    at_steps = table[table["step"].notna()]
    for (quantity, label), series in at_steps.groupby(["quantity", "study"]):
        numbers[f"order of the {quantity}, {label}"] = readings.order(series, 1e-13)
    return numbers


FAULTS = {
    "another truth": OTHER_TRUTH,
    "methods exchanged": Fault(
        wrong={
            f"{__name__}.METHODS": lambda original: {
                EXPLICIT: SYMPLECTIC_EULER,
                **dict.fromkeys((IMPLICIT, SYMPLECTIC), EXPLICIT_EULER),
            }
        }
    ),
    "a velocity reversed": Fault(
        wrong=dict.fromkeys(
            (
                "references.textbook.nystrom.Nystrom.run",
                "references.textbook.implicit_euler.ImplicitEuler.run",
            ),
            with_arguments(
                lambda method, problem, *options: (method, reversed_clock(problem), *options)
            ),
        )
    ),
    "another first-order term": Fault(
        wrong={
            f"{__package__}.euler_readings.{name}": scaled(0.9)
            for name in ("explicit_slope", "symplectic_change")
        }
    ),
    "the smaller solutions": Fault(
        wrong={
            f"{__package__}.implicit_euler_orbit.distances": lambda original: (
                lambda size, a: original(size, a)[::-1]
            )
        }
    ),
    "planets that half of the steps keep": Fault(table=times(0.5, quantity=SMALLER)),
    "a stop that has a solution": Fault(table=times(1.2, quantity=STOPPED)),
    "a solved step without a solution": Fault(table=times(0.9, quantity=SOLVED)),
}
