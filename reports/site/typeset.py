"""Typeset plain-text mathematics in HTML: superscripts, powers of ten, and unbreakable spaces."""

from __future__ import annotations

import re

from markupsafe import Markup, escape

POWER = re.compile(r"\^(-?\((?:[^()]|\([^()]*\))*\)|\{[^{}]*\}|-?[A-Za-z0-9./*]*[A-Za-z0-9])")
POWER_OF_TEN = re.compile(r"(?<![\w.])(\d+(?:\.\d+)?)e([+-]?\d+)(?!\w)")
SPACED_SIGN = re.compile(r"(?<=[\w)\]|]) ([+=/*±≤≥]|&lt;|&gt;) (?=[\w(\[|]|-\d)")
MINUS_SIGN = re.compile(r"(?<![A-Za-z]{2}) - (?=[\w(\[|])")
UNBROKEN = "\u00a0"
MINUS = "\u2212"
INFINITY = "\u221e"


def typeset(text: str) -> Markup:
    """Escaped text with superscripts and typographic signs; anything else is unchanged."""
    html = str(escape(text))
    html = html.replace("&#39;", "'").replace("fig. ", f"fig.{UNBROKEN}").replace(" -+ ", " ± ")
    html = html.replace("&lt;= ", "≤ ").replace("&gt;= ", "≥ ")
    html = SPACED_SIGN.sub(rf"{UNBROKEN}\1{UNBROKEN}", html)
    html = MINUS_SIGN.sub(f"{UNBROKEN}{MINUS}{UNBROKEN}", html)
    html = POWER_OF_TEN.sub(_ten, html)
    return Markup(POWER.sub(_superscript, html))


def _superscript(match: re.Match[str]) -> str:
    exponent = match.group(1)
    if exponent[0] in "({":
        exponent = exponent[1:-1]
    return f"<sup>{exponent.replace('-', MINUS).replace('infinity', INFINITY)}</sup>"


def _ten(match: re.Match[str]) -> str:
    digits, power = match.group(1), str(int(match.group(2))).replace("-", MINUS)
    return f"10<sup>{power}</sup>" if digits == "1" else f"{digits}·10<sup>{power}</sup>"
