"""The text of a bound as a sentence for readers; claims.csv keeps the exact text."""

from __future__ import annotations

import re
import sys

NUMBER = r"-?\d[\d.]*(?:e-?\d+)?"
TOLERANCES = re.compile(
    rf"^(?P<words>.*?)(?P<near> -\+ {NUMBER})?(?: (?P<sign>-\+|\+|-) (?P<round>{NUMBER}))?"
    rf"(?P<errors> (?:-\+|\+|-) 2 standard errors(?P<both> of both)?)?"
    rf"(?: \((?P<most>{NUMBER}) at most\))?$"
)
DIGITS = re.compile(rf"(?<![\w.]){NUMBER}")
MOST = 6  # digits of a number
EPS = sys.float_info.epsilon


def bound_words(text: str) -> str:
    """E.g. "order 2 within 0.25 plus two standard errors (these capped at 0.25)"."""
    found = TOLERANCES.match(text)
    if found is None or ";" in text:
        return text
    more = [found["round"]] if found["round"] else []
    if found["errors"]:
        capped = f" (these capped at {found['most']})" if found["most"] else ""
        more.append(f"two standard errors{found['both'] or ''}{capped}")
    near = f" within {found['near'].split()[-1]}" if found["near"] else ""
    joint = " minus " if text.startswith(("at least", "above")) else " plus "
    return DIGITS.sub(_short, joint.join([found["words"] + near, *more]))


def _short(found: re.Match[str]) -> str:
    """The number with few digits; multiples of the spacing of numbers at 1 as such."""
    value = float(found[0])
    times = round(value / EPS) if 0.0 < value < 1000.0 * EPS else 0
    if times and float(f"{times * EPS:.4g}") == value:
        return f"{times} eps"
    return found[0] if len(found[0].strip("-0.").replace(".", "")) <= MOST else f"{value:.{MOST}g}"
