"""Format numbers for readers: few digits, powers of ten, empty where unknown."""

from __future__ import annotations

import math
from numbers import Real
from typing import Any

SUPERSCRIPT = str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹")
NARROW_SPACE = "\u202f"
MINUS = "\u2212"
FEW_DECIMALS, MOST_DECIMALS = 6, 15  # of a number below and from LEAST, without a power of ten
LEAST = 1e-3
TIMES = "\u2009\u00d7"


def known(number: Any) -> bool:
    """Whether this is a finite number, of numpy too; None, NaN and infinities are not."""
    return isinstance(number, Real) and math.isfinite(number)


def capital(text: str) -> str:
    """The text with its first letter capitalised, the rest unchanged."""
    return text[:1].upper() + text[1:]


def readable(number: Any, digits: int = 3) -> str:
    """Text such as 0.553, 12.4, 3.1·10⁻¹⁰; "" for None, NaN and infinities."""
    if not known(number):
        return ""
    if number == 0:
        return "0"
    mantissa, exponent = f"{number:.{digits - 1}e}".split("e")
    power = int(exponent)
    if -3 <= power < 5:
        rounded = float(f"{number:.{digits - 1}e}")
        return f"{rounded:.{max(0, digits - 1 - power)}f}".replace("-", MINUS)
    return f"{mantissa}·10{str(power).translate(SUPERSCRIPT)}".replace("-", MINUS)


def plain(number: Any, digits: int = 3) -> str:
    """The same in ASCII, for terminals and Markdown: 0.553, 3.1e-10."""
    if not known(number):
        return ""
    return f"{number:.{digits}g}"


def with_uncertainty(number: Any, uncertainty: Any) -> str:
    """Text such as 0.5534 ± 0.0012, rounded to the second digit of the uncertainty."""
    if not known(number) or not known(uncertainty) or not uncertainty > 0:
        return readable(number)
    second_digit = 1 - math.floor(math.log10(uncertainty))
    most = MOST_DECIMALS if abs(number) >= LEAST else FEW_DECIMALS
    if not 0 <= second_digit <= most:
        return f"{readable(number)} ± {readable(uncertainty, 2)}"
    return f"{number:.{second_digit}f} ± {uncertainty:.{second_digit}f}".replace("-", MINUS)


def concise(number: Any, uncertainty: Any, most: int = 3) -> str:
    """Text such as 3.97(2): one digit of the uncertainty, in units of the last one.

    At most so many decimals; a smaller uncertainty is shown as (1). Without one two decimals.
    """
    if not known(uncertainty) or not uncertainty > 0:
        return f"{number:.2f}"
    decimals = min(most, max(0, -math.floor(math.log10(uncertainty))))
    return f"{number:.{decimals}f}({max(1, round(uncertainty * 10**decimals))})"


def seconds(number: Any) -> str:
    """A time in seconds as text with its unit: 3.2 ms, 1.25 s; "" when unknown."""
    if not known(number):
        return ""
    units = (("s", 1.0), ("ms", 1e-3), ("µs", 1e-6))
    unit, size = next((one for one in units if abs(number) >= one[1]), units[-1])
    return f"{readable(number / size)}{NARROW_SPACE}{unit}"
