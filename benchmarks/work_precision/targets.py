"""Targets for galvi's speed against other codes, set before any measurement."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

NBODY_SOURCE = "the project's targets for N bodies"
RIGID_BODY_SOURCE = "the project's targets for rigid bodies"
OUTER_PLANETS, EIGHT_PLANETS = "outer solar system", "solar system without Pluto"
VECTOR_SOURCE = "the project's targets for Lagrangians and bodies in vector instructions"
FREE_BODY, THROWN_BODY, SAND_GRAIN = (
    "free rigid body",
    "free body on SE(3)",
    "brownout, 100 micrometres",
)
DOUBLE_PENDULUM, FIVE_RODS = "double pendulum", "chain of 5 rods"
COORDINATE_PROBLEMS = (
    "elastic pendulum",
    "henon-heiles",
    "fermi-pasta-ulam-tsingou",
    "kepler e=0.3 in polar coordinates",
)
MORE_POINTS = tuple(f"galvi degree {s}, Gauss {s + 1}, Cayley" for s in (6, 7, 8, 10))
FRAME_SOURCE = "the project's targets for moving frames"
# iterated until converged: their energies do not drift
CONVERGED_FRAMES = ("galvi Kepler frame, Gauss 8", "galvi Kepler frame, Gauss 16")
TWO_PASS_FRAMES = tuple(f"{label}, 2 passes" for label in CONVERGED_FRAMES)
ALL_FRAMES = CONVERGED_FRAMES + TWO_PASS_FRAMES
GALVI_METHODS = {  # those of galvi's labels that a target names, in words
    (): "any",
    CONVERGED_FRAMES: "Kepler frame, converged",
    TWO_PASS_FRAMES: "Kepler frame, 2 passes",
    ALL_FRAMES: "Kepler frame",
    MORE_POINTS: "n points for n functions",
}
GENERAL_KERNEL_NOTE = "The general kernel is faster now than when this target was set."
WITHOUT_FRAME = tuple(f"galvi degree {s}, Gauss {s}" for s in (8, 12, 16))
RIVALS = {WITHOUT_FRAME: "galvi without frame, best"}
IAS15 = ("REBOUND IAS15", "REBOUND IAS15, GLOBAL", "REBOUND IAS15, looser")


@dataclass(frozen=True)
class Target:
    """A target for the ratio of times at an error.

    Attributes
    ----------
    problem
        name of the problem
    contenders
        labels in the work-precision study; the fastest of them at the error counts
    error
        final error of the position in au or of the attitude; None for the smallest error that the
        contenders reach
    ratio
        least ratio of the contenders' time to galvi's; None when galvi only has to reach the error
    source
        origin of the target
    galvi_contenders
        galvi's labels that count; () for all but the contenders
    note
        a sentence on what has changed since it was set
    """

    problem: str
    contenders: tuple[str, ...]
    error: float | None
    ratio: float | None
    source: str = NBODY_SOURCE
    galvi_contenders: tuple[str, ...] = ()
    note: str = ""

    @property
    def against(self) -> str:
        """The rival in words: the first of the contenders, unless several of galvi's count."""
        return RIVALS.get(self.contenders, self.contenders[0])

    @property
    def counted(self) -> str:
        """Which of galvi's methods count, in words."""
        return GALVI_METHODS.get(self.galvi_contenders) or ", ".join(self.galvi_contenders).replace(
            "galvi ", ""
        )


def _targets(
    problem: str,
    contender: str,
    errors_and_ratios: tuple[tuple[float | None, float | None], ...],
    **fields: Any,
) -> tuple[Target, ...]:
    return tuple(
        Target(problem, (contender,), error, ratio, **fields) for error, ratio in errors_and_ratios
    )


TARGETS = (
    Target(OUTER_PLANETS, IAS15, 1e-9, 18.0),
    *_targets(OUTER_PLANETS, "heyoka", ((1e-9, 6.0),)),
    *_targets(
        OUTER_PLANETS,
        "REBOUND WHFast, best",  # "at 1e-7 and below": at each decade of the comparison
        ((1e-6, 1.7), (1e-7, 2.5), (1e-8, 2.5), (1e-9, 2.5), (1e-10, 2.5)),
    ),
    Target(OUTER_PLANETS, IAS15[:1], None, None),
    Target(EIGHT_PLANETS, IAS15, 5e-11, 12.0),
    *_targets(EIGHT_PLANETS, "heyoka", ((1e-9, 7.0),)),
    *_targets(
        EIGHT_PLANETS,
        "REBOUND WHFast, best",
        ((1e-6, 0.6), (1e-7, 1.0), (1e-8, 1.0), (1e-9, 1.0), (1e-10, 1.0)),
    ),
    *_targets(EIGHT_PLANETS, "REBOUND WHFast512", ((1e-9, 0.4),)),
    Target(EIGHT_PLANETS, IAS15[:1], None, None),
    *_targets(
        EIGHT_PLANETS, "REBOUND WHFast512", ((1e-4, 1.3), (1e-6, 1.25), (1e-8, 1.15), (1e-9, 1.3)),
        source=FRAME_SOURCE, galvi_contenders=TWO_PASS_FRAMES,
    ),
    Target(EIGHT_PLANETS, ("REBOUND WHFast512",), 1e-11, None, FRAME_SOURCE, ALL_FRAMES),
    *_targets(  # "at every error": at each decade of the comparison
        EIGHT_PLANETS, "REBOUND WHFast, best",
        tuple((10.0**-k, 5.0) for k in range(5, 11)),
        source=FRAME_SOURCE, galvi_contenders=CONVERGED_FRAMES,
    ),
    *(
        Target(OUTER_PLANETS, WITHOUT_FRAME, error, ratio, FRAME_SOURCE, ALL_FRAMES)
        for error, ratio in ((1e-7, 3.0), (1e-9, 1.8), (1e-10, 1.5))
    ),
    *_targets(
        FREE_BODY,
        "MuJoCo RK4",
        ((7e-6, 3.0), (1e-8, 10.0), (2e-11, 30.0), (1e-12, 40.0), (None, None)),
        source=RIGID_BODY_SOURCE,
    ),
    *_targets(
        FREE_BODY,
        "DOP853 on quaternions, compiled",
        ((1e-11, 1.0), (1e-12, 1.0), (1e-13, 1.0)),  # "ahead at 1e-11 and below"
        source=RIGID_BODY_SOURCE,
    ),
    *_targets(
        FREE_BODY,
        "DOP853 on quaternions, compiled",
        ((1e-10, 1.0),),
        source=VECTOR_SOURCE,
    ),
    *_targets(
        FREE_BODY,
        "heyoka, rigid bodies",
        ((1e-10, 1.0), (1e-11, 1.0), (1e-12, 1.0), (1e-13, 1.0)),
        source=VECTOR_SOURCE,
    ),
    *_targets(
        FREE_BODY,
        "MuJoCo RK4",
        ((7e-6, 6.0), (1e-8, 30.0), (2e-11, 150.0)),  # H's rule: n points for n functions
        source=VECTOR_SOURCE,
        galvi_contenders=MORE_POINTS,
    ),
    *_targets(
        DOUBLE_PENDULUM, "heyoka, chains", ((1e-6, 1.1), (1e-10, 1.8), (1e-12, 2.5)),
        source=VECTOR_SOURCE,
    ),
    *_targets(
        FIVE_RODS, "heyoka, chains", ((1e-6, 6.0), (1e-10, 9.0), (1e-12, 11.0)),
        source=VECTOR_SOURCE,
    ),
    *_targets(
        FIVE_RODS, "MuJoCo RK4", ((1e-4, 1.0), (1e-6, 1.0), (None, 1.0)), source=VECTOR_SOURCE
    ),
    *(
        target
        for problem in COORDINATE_PROBLEMS
        for target in _targets(
            problem, "heyoka, Lagrangians", ((1e-6, 1.0), (1e-10, 1.0), (1e-12, 1.0)),
            source=VECTOR_SOURCE,
        )
    ),
    *_targets(
        THROWN_BODY, "galvi degree 5, Gauss 5, general kernel", ((1e-7, 45.0),),
        source=VECTOR_SOURCE, galvi_contenders=("galvi degree 5, Gauss 5",),
        note=GENERAL_KERNEL_NOTE,
    ),
    *_targets(
        SAND_GRAIN, "galvi degree 4, Gauss 4, general kernel", ((1e-9, 15.0),),
        source=VECTOR_SOURCE, galvi_contenders=("galvi degree 4, Gauss 4",),
        note=GENERAL_KERNEL_NOTE,
    ),
)  # fmt: skip
