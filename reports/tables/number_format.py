"""Numbers as text: for readers, for terminals, and for siunitx."""

from __future__ import annotations

import math
from numbers import Real
from typing import Any

SUPERSCRIPT = str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹")
NARROW_SPACE = "\u202f"
MINUS = "\u2212"
TIMES = "\u2009\u00d7"
PLAIN_EXPONENTS = range(-3, 5)  # exponents of numbers that are written without a power of ten
MAX_DECIMALS = 15  # largest number of decimals of a number with an uncertainty
MAX_SETTING_DIGITS = 6  # largest number of digits of a setting, which is written exactly


def is_finite(number: Any) -> bool:
    """Whether this is a finite real number of Python or numpy; None, NaN and infinities are not."""
    return isinstance(number, Real) and math.isfinite(number)


def capital(text: str) -> str:
    """The text with its first letter capitalised, the rest unchanged."""
    return text[:1].upper() + text[1:]


def plain(number: Any, digits: int = 3) -> str:
    """ASCII for terminals and Markdown: 0.553, 4, 1230, 3.1e-10; "" for None, NaN, infinities."""
    return f"{float(f'{number:.{digits}g}'):.{max(6, digits)}g}" if is_finite(number) else ""


def readable(number: Any, digits: int = 3) -> str:
    """Text such as 0.553, 12.4, 3.10·10⁻¹⁰; "" for None, NaN and infinities."""
    mantissa, _, exponent = _rounded(number, digits).partition("e")
    power = f"·10{exponent.translate(SUPERSCRIPT)}" if exponent else ""
    return mantissa.replace("-", MINUS) + power


def in_full(number: float) -> str:
    """As `readable`, but whole numbers, and settings of up to MAX_SETTING_DIGITS digits such as
    0.9999, are exact."""
    if not is_finite(number):
        return ""
    if float(number).is_integer() and abs(number) < 10.0**MAX_DECIMALS:
        return f"{number:.0f}".replace("-", MINUS)
    max_digits = MAX_SETTING_DIGITS if _exponent(number) in PLAIN_EXPONENTS else 1
    needed = (
        digits for digits in range(1, max_digits + 1) if float(plain(number, digits)) == number
    )
    return readable(number, next(needed, 3))


def with_uncertainty(number: Any, uncertainty: Any) -> str:
    """Text such as 0.5534 ± 0.0012, rounded to the second digit of the uncertainty."""
    if not is_finite(number) or not is_finite(uncertainty) or not uncertainty > 0:
        return readable(number)
    decimals = _decimals(uncertainty, 2)
    if not 0 <= decimals <= MAX_DECIMALS or (
        abs(number) < 10.0 ** PLAIN_EXPONENTS[0] and decimals > MAX_SETTING_DIGITS
    ):
        return f"{readable(number)} ± {readable(uncertainty, 2)}"
    return f"{number:.{decimals}f} ± {uncertainty:.{decimals}f}".replace("-", MINUS)


def concise(number: float, uncertainty: Any, digits: int = 1, max_decimals: int = 3) -> str:
    """Text such as 3.97(2), with `digits` digits of the uncertainty, in units of the last decimal.

    There are at most `max_decimals` decimals; a smaller uncertainty is shown as (1). Without an
    uncertainty the number has two decimals.
    """
    if not is_finite(uncertainty) or not uncertainty > 0:
        return f"{number:.2f}"
    decimals = min(max_decimals, max(0, _decimals(uncertainty, digits)))
    return f"{number:.{decimals}f}({max(1, round(uncertainty * 10**decimals))})"


def siunitx(number: Any, uncertainty: Any = None) -> str:
    """A number for siunitx: 0.553(12) with two digits of the uncertainty, or 3.10e-10, 12.4, and
    whole numbers below 100,000 in full; "" for None, NaN and infinities."""
    if not is_finite(number):
        return ""
    if is_finite(uncertainty) and uncertainty > 0:
        power = _exponent(max(abs(number), uncertainty))
        power *= power not in PLAIN_EXPONENTS
        text = concise(number / 10.0**power, uncertainty / 10.0**power, 2, MAX_DECIMALS)
        return f"{text}e{power}" if power else text
    is_short_integer = float(number).is_integer() and _exponent(number) in PLAIN_EXPONENTS
    return f"{number:.0f}" if is_short_integer else _rounded(number, 3)


def seconds(number: Any) -> str:
    """A time in seconds as text with its unit: 3.20 ms, 1.25 s; "" if unknown."""
    if not is_finite(number):
        return ""
    units = (("s", 1.0), ("ms", 1e-3), ("µs", 1e-6))
    unit, size = next((pair for pair in units if abs(number) >= pair[1]), units[-1])
    return f"{readable(number / size)}{NARROW_SPACE}{unit}"


def _rounded(number: Any, digits: int) -> str:
    """A number with `digits` digits, e.g. 0.553, 12.4, 3.10e-10; "" if it is not finite."""
    if not is_finite(number):
        return ""
    if number == 0:
        return "0"
    text = f"{number:.{digits - 1}e}"
    mantissa, exponent = text.split("e")
    if int(exponent) in PLAIN_EXPONENTS:
        return f"{float(text):.{max(0, digits - 1 - int(exponent))}f}"
    return f"{mantissa}e{int(exponent)}"


def _exponent(number: float) -> int:
    """The decimal exponent of a number that is rounded to one digit."""
    return int(f"{number:.0e}".split("e")[1])


def _decimals(uncertainty: float, digits: int) -> int:
    """The number of decimals with which the uncertainty has `digits` digits."""
    return digits - 1 - math.floor(math.log10(uncertainty))
