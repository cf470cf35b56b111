"""MuJoCo's XML: a model of bodies that nothing touches, its numbers read back bit for bit."""

from __future__ import annotations

from typing import Any

OFF = (
    *("contact", "constraint", "equality", "frictionloss", "limit", "spring", "damper"),
    *("clampctrl", "actuation", "sensor", "eulerdamp", "island", "warmstart", "autoreset"),
)  # what lone bodies have not, 4 % of a step; and the reset that would hide a failure


def document(gravity: Any, bodies: str, off: tuple[str, ...] = OFF) -> str:
    """The XML of a model with these bodies and gravity (3,); angles are in radians.

    off  names of what is disabled
    """
    flags = " ".join(f'{name}="disable"' for name in off)
    return (
        f'<mujoco><compiler angle="radian"/><option gravity="{text(gravity)}">'
        f"<flag {flags}/></option><worldbody>{bodies}</worldbody></mujoco>"
    )


def text(numbers: Any) -> str:
    """Numbers separated by spaces, each with the digits that determine its float64."""
    return " ".join(repr(float(number)) for number in numbers)
