"""Titles, descriptions and time units of the problems, for readers."""

from __future__ import annotations

from typing import NamedTuple


class Label(NamedTuple):
    """A problem for readers.

    Attributes
    ----------
    title
        name in tables and figures
    text
        description: bodies, start and duration; "" for a problem that is not the suite's
    time
        unit of time; "" where it is dimensionless
    """

    title: str
    text: str = ""
    time: str = ""


H_BODY = "principal moments 3.3, 2.5, 3.4, angular velocity (2, -1.9, 1) in the body"
LABELS = {
    "kepler e=0.6": Label(
        "Kepler, e = 0.6",
        "One body about a fixed centre in the plane, GM = a = 1, period 2 pi, from its "
        "pericentre, over 100 periods. WHFast, which solves this problem in closed "
        "form, takes no part.",
    ),
    "outer solar system": Label(
        "Outer solar system",
        "Sun with the inner planets as one body, Jupiter to Pluto, from JPL's DE421 at "
        "2000-01-01, over 10,000 years; au and days.",
        "d",
    ),
    "solar system without Pluto": Label(
        "Sun and eight planets",
        "Sun, Mercury to Neptune, from JPL's DE421 at 2000-01-01, over 200 years; au and days.",
        "d",
    ),
    "outer solar system after Applegate": Label(
        "Outer solar system after Applegate",
        "Sun to Pluto with the masses and states of Applegate et al. (1986), over 10,000 years "
        "of 365 days; au, years and solar masses.",
        "years",
    ),
    "free rigid body": Label(
        "Free rigid body", f"H's body, {H_BODY}, over 20 units of time, about nine turns."
    ),
    "3D pendulum, m g = 9.81": Label(
        "3D pendulum, m g = 9.81",
        "H's body on a pivot, moments 4.8, 3, 3.8 about it, centre of mass at distance 1, "
        "started hanging with angular velocity (0.5, -0.5, 0.4), over 20 units of time.",
    ),
    "double pendulum": Label(
        "Double pendulum",
        "Two point masses 1 on weightless rods of length 1, g = 9.81, released at 2 and 2.5 rad "
        "from the vertical, a chaotic start, over 5 units of time.",
    ),
    "chain of 5 rods": Label(
        "Chain of 5 rods",
        "Uniform rods of mass and length 1, g = 9.81, hinged end to end, released straight and "
        "at rest at 1 rad from the vertical, over 5 units of time.",
    ),
    "heavy top": Label(
        "Heavy top",
        "A symmetric top on its tip, moments 1.5, 1.5, 0.5, m g l = 2, tilted by 0.5 rad, spin "
        "8, over 20 units of time, some twenty-five turns about its axis.",
    ),
    "free body on SE(3)": Label(
        "Free body on SE(3)",
        f"H's free body, {H_BODY}, mass 2, thrown with velocity (0.3, 0.2, -0.1) without "
        "gravity, over 20 units of time.",
    ),
    "elastic pendulum": Label(
        "Elastic pendulum",
        "A mass 1 on a spring of stiffness 40 and length 1, g = 9.81, in polar coordinates, "
        "released at r = 1.3 and 1.5 rad from the vertical, over 5 units of time, some seven "
        "oscillations.",
    ),
    "henon-heiles": Label(
        "Hénon-Heiles",
        "A star in an axisymmetric galaxy at energy 0.1, over 20 units of time, some three "
        "revolutions.",
    ),
    "fermi-pasta-ulam-tsingou": Label(
        "Fermi-Pasta-Ulam-Tsingou",
        "15 unit masses between walls on springs with alpha = 0.25, released in the lowest mode "
        "of amplitude 1, over 20 units of time, some six periods of the fastest mode.",
    ),
    "kepler e=0.3 in polar coordinates": Label(
        "Kepler, e = 0.3, in polar coordinates",
        "An orbit of GM = a = 1 and eccentricity 0.3 in r and phi, from its pericentre, over 20 "
        "units of time, more than three revolutions.",
    ),
    "brownout, 100 micrometres": Label(
        "Grain of sand in a rotor's wind",
        "A sphere of quartz of 100 micrometres that falls with a drag quadratic in its velocity "
        "through the wind of a helicopter's rotor, over 2 s, half of its fall.",
        "s",
    ),
    "skew arm": Label(
        "Skew arm",
        "Three rods of 1 kg and 0.5 m on hinges with skew axes that swing in gravity, without "
        "damping, over 2 s, some two turns.",
        "s",
    ),
    "floating arm": Label(
        "Floating arm",
        "The same arm on a body of 5 kg that floats without weight, over 10 s.",
        "s",
    ),
    "Burrau's problem": Label(
        "Burrau's problem",
        "Masses 3, 4 and 5 at rest at the corners of a triangle with sides 3, 4 and 5, which pass "
        "each other at 1e-2 to 1e-4 of their first distance until one leaves, over 63 units of "
        "time.",
    ),
    "HD 80606 and a companion": Label(
        "HD 80606 and a companion",
        "A planet of eccentricity 0.933 at 0.46 au and a companion of Jupiter's mass at 3 au, "
        "over 20 years; au, solar masses and years / 2 pi.",
        "years / 2 pi",
    ),
    "Kozai-Lidov cycles": Label(
        "Kozai-Lidov cycles",
        "A planet at 1 au that a star at 6 au, inclined by 75 degrees, makes eccentric again and "
        "again, over 200 years; au, solar masses and years / 2 pi.",
        "years / 2 pi",
    ),
    "a binary meets a star": Label(
        "A binary meets a star",
        "Three equal stars, one of which flies through the circular binary of the others, over 60 "
        "units of time.",
    ),
    "16 stars": Label(
        "16 stars",
        "Equal stars in Plummer's density, over 8.49 units of time, three crossing times.",
    ),
    "Sitnikov's problem": Label(
        "Sitnikov's problem",
        "A massless body on the axis of a binary of eccentricity 0.6, over 40 units of time. The "
        "axis is unstable, and a code whose rounding does not keep the symmetry leaves it.",
    ),
    **{
        f"two bodies, e = {e:g}": Label(
            f"Two bodies, e = {e:g}",
            f"Masses 0.7 and 0.3 on an orbit of eccentricity {e:g}, a = 1, from its pericentre, "
            "over 20.37 revolutions, so that its phase counts.",
        )
        for e in (0.9, 0.99, 0.999, 0.9999)
    },
}


def label_of(problem: str) -> Label:
    """The label of a problem; for a problem that is not in LABELS its name, capitalised."""
    return LABELS.get(problem) or Label(problem[:1].upper() + problem[1:])
