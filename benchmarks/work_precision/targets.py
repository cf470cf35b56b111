"""Targets for galvi's speed against other codes, set before any measurement."""

from __future__ import annotations

from dataclasses import dataclass

ORBITS = "the project's targets for N bodies"
TURNS = "the project's targets for rigid bodies"
OUTER, WHOLE = "outer solar system", "solar system without Pluto"
FREE_BODY = "free rigid body"
IAS15 = ("REBOUND IAS15", "REBOUND IAS15, GLOBAL", "REBOUND IAS15, looser")


@dataclass(frozen=True)
class Target:
    """A target for the ratio of times at an error.

    problem     name of the problem
    contenders  labels in the work-precision study; the fastest of them at the error counts
    error       final error of the position in au or of the attitude; None for the smallest error
                that the contenders reach
    ratio       least ratio of the contenders' time to galvi's; None when galvi only has to reach
                the error
    source      origin of the target
    """

    problem: str
    contenders: tuple[str, ...]
    error: float | None
    ratio: float | None
    source: str = ORBITS


def _each(
    problem: str, contender: str, asked: tuple[tuple[float | None, float | None], ...], **more: str
) -> tuple[Target, ...]:
    return tuple(Target(problem, (contender,), error, ratio, **more) for error, ratio in asked)


TARGETS = (
    Target(OUTER, IAS15, 1e-9, 18.0),
    *_each(OUTER, "heyoka", ((1e-9, 6.0),)),
    *_each(
        OUTER,
        "REBOUND WHFast, best",  # "at 1e-7 and below": at each decade of the comparison
        ((1e-6, 1.7), (1e-7, 2.5), (1e-8, 2.5), (1e-9, 2.5), (1e-10, 2.5)),
    ),
    Target(OUTER, IAS15[:1], None, None),
    Target(WHOLE, IAS15, 5e-11, 12.0),
    *_each(WHOLE, "heyoka", ((1e-9, 7.0),)),
    *_each(
        WHOLE,
        "REBOUND WHFast, best",
        ((1e-6, 0.6), (1e-7, 1.0), (1e-8, 1.0), (1e-9, 1.0), (1e-10, 1.0)),
    ),
    *_each(WHOLE, "REBOUND WHFast512", ((1e-9, 0.4),)),
    Target(WHOLE, IAS15[:1], None, None),
    *_each(
        FREE_BODY,
        "MuJoCo RK4",
        ((7e-6, 3.0), (1e-8, 10.0), (2e-11, 30.0), (1e-12, 40.0), (None, None)),
        source=TURNS,
    ),
    *_each(
        FREE_BODY,
        "DOP853 on quaternions, compiled",
        ((1e-11, 1.0), (1e-12, 1.0), (1e-13, 1.0)),  # "ahead at 1e-11 and below"
        source=TURNS,
    ),
)
