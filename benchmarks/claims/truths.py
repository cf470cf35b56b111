"""The truths of the claims, each against a second, independent one, as rows of `verify`.

The limit on their distance is a tenth of the smallest error that a verdict rests on.
"""

from __future__ import annotations

from dataclasses import field

from benchmarks.claims.agreement import absence
from benchmarks.claims.kit import *
from benchmarks.claims.lie_groups.pendulum_motion import TRUTH as PENDULUM_TRUTH
from benchmarks.work_precision.with_settings import WithSettings
from references import Contender, missing_engine
from references.closed_forms.kepler import KEPLER
from references.closed_forms.oscillator import OSCILLATOR
from references.closed_forms.top_motion import FREE_TOP
from references.rebound.ias15 import IAS15
from references.scipy.ivp import DOP853, TIGHT
from references.scipy.rigid_ivp import RIGID_DOP853
from references.stored.attitude import STORED_ATTITUDE
from references.stored.planets import STORED_TRUTH

SAMPLES = 20
DIFFERENCE = "largest distance"


def same(motion: Array) -> Array:
    """The configurations as they are."""
    return motion


def relative(motion: Array) -> Array:
    """The second body as seen from the first, (k, 2), from (k, 2, 2)."""
    return motion[:, 1] - motion[:, 0]


def as_two_bodies(orbit: Problem) -> Problem:
    """Two equal bodies whose relative motion is that of a point about a centre with GM = 1."""
    q, v = (np.array([-0.5 * x, 0.5 * x]) for x in (orbit.q0, orbit.v0))
    return Problem(galvi.NBody([0.5, 0.5]), q, v, name="two equal bodies")


@dataclass(frozen=True, eq=False)
class TruthCase:
    """A truth of the claims and a second one, over `duration` of the problem.

    claims         the claims that rest on it
    limit          bound on the largest component of their difference at the samples
    reason         the error of which it is a tenth
    other_problem  the second truth's form of the problem
    compared       its configurations in the form of the first
    """

    truth: Contender | WithSettings
    second: Contender | WithSettings
    problem: Problem
    duration: float
    limit: float
    claims: str
    reason: str
    samples: int = SAMPLES
    setting: Mapping[str, Any] = field(default_factory=dict)
    other_problem: Callable[[Problem], Problem] = same
    compared: Callable[[Array], Array] = same

    @property
    def quantity(self) -> str:
        """The `quantity` of the row."""
        names = f"{self.truth.name}, and {self.second.name}"
        return f"{DIFFERENCE} of {names}: {self.problem.name}, T = {self.duration:g}"

    def measured(self, make_method: MakeMethod) -> dict[str, Any]:
        """A tidy row, of no method of galvi; its status or label says why it has no number."""
        found = row(study=AGREEMENT, quantity=self.quantity, t=self.duration)
        missing = self.truth.missing or self.second.missing
        if missing:
            engine = missing_engine(self.truth) or missing_engine(self.second)
            return {**found, "label": missing, "absent": engine}
        wanted = {"samples": self.samples}
        first = self.truth.run(self.problem, self.duration, wanted)
        other = self.other_problem(self.problem)
        second = self.second.run(other, self.duration, {**wanted, **self.setting})
        failed = " ".join(run.status for run in (first, second) if not run.success)
        if failed:
            return {**found, "status": failed}
        away = float(np.max(np.abs(first.q - self.compared(second.q))))
        return {**found, "value": away, "label": str(second.method)}

    def judged(self, name: str, table: DataFrame) -> Row:
        """The row; without an engine it is expected not to run."""
        absent, label = absence(table, self.quantity)
        return judged(
            name,
            self.quantity,
            AtMost(self.limit),
            number(table, quantity=self.quantity),
            source=AGREEMENT,
            setup=f"{self.problem.name}; T = {self.duration:g}, {self.samples} samples",
            claimed=f"the same motion; the truth of {self.claims}",
            expected=NOT_RUN if absent else HOLDS,
            reason=label if absent else self.reason,
            reference=self.second.name,
            absent=absent,
        )


ORBIT, BODY = galvi.problems.kepler(0.6), galvi.problems.free_rigid_body()
SPRING, HANGING = galvi.problems.harmonic_oscillator(), galvi.problems.pendulum_3d()
PLANETS = galvi.problems.solar_system()
BY_IAS15: Mapping[str, Any] = {"other_problem": as_two_bodies, "compared": relative}
TRUTHS = (
    TruthCase(
        OSCILLATOR, DOP853, SPRING, 8.0, 1e-12, "V14, V17 and V18",
        "A tenth of 1e-11, the smallest error that is fitted.", setting=TIGHT,
    ),
    TruthCase(
        OSCILLATOR, DOP853, SPRING, 2000.0, 1e-11, "V1",
        "A tenth of 1e-10, which the smallest error must reach.", setting=TIGHT,
    ),
    TruthCase(
        KEPLER, IAS15, ORBIT, 2.0, 1e-14, "V6, V7, V14 and V22",
        "A tenth of 1e-13, the smallest error that is fitted.", **BY_IAS15,
    ),
    TruthCase(
        KEPLER, IAS15, ORBIT, 200.0, 1e-12, "V3 to V5",
        "A tenth of 1e-11, the smallest error that is fitted.", **BY_IAS15,
    ),
    TruthCase(
        KEPLER, IAS15, ORBIT, 2.0 * np.pi, 1e-13, "V8, the starts of its short runs",
        "These need only be spread along the orbit: each run has its own energy.", samples=64,
        **BY_IAS15,
    ),
    TruthCase(
        FREE_TOP, RIGID_DOP853, BODY, 200.0, 1e-10, "L4, the starts of its short runs",
        "These need only be spread along the motion: each run has its own energy.", samples=64,
        setting=TIGHT,
    ),
    TruthCase(
        FREE_TOP, RIGID_DOP853, BODY, 5.0, 1e-13, "L2, L3 and L14",
        "A tenth of 1e-12, the smallest error that is fitted.", setting=TIGHT,
    ),
    TruthCase(
        PENDULUM_TRUTH, STORED_ATTITUDE, HANGING, 5.0, 1e-14, "L6 to L9, L14 and L15",
        "As small as an entry of a matrix allows after this time.", samples=1,
    ),
    TruthCase(
        IAS15, STORED_TRUTH, PLANETS, 1e4, 1e-11, "V9 and V10",
        "A tenth of the smallest distance of a planet that is judged.", samples=1,
    ),
)  # fmt: skip
