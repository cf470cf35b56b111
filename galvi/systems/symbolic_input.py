"""A Lagrangian as SymPy has it, read into symbols of our own, or refused with a sentence."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import Any

from galvi import checks


@dataclass(frozen=True, eq=False)
class Expressions:
    """What the user gave, in real symbols q0, q1, ..., v0, ..., t and parameters c0, ...

    L         the Lagrangian
    forces    (d,) generalised forces; None for none
    q, v, t   the symbols, (d,), (d,) and one
    c         the parameters' symbols, and their values, sorted by the names they were given
    readable  symbol -> its name in the user's words
    """

    L: Any
    forces: tuple[Any, ...] | None
    q: tuple[Any, ...]
    v: tuple[Any, ...]
    t: Any
    c: tuple[Any, ...]
    values: tuple[float, ...]
    readable: Mapping[Any, str]

    def text(self, expression: Any) -> str:
        """An expression in the user's words."""
        return in_words(expression, self.readable)


def expressions(L: Any, q: Any, v: Any, t: Any, parameters: Any, force: Any) -> Expressions:
    """As `galvi.Lagrangian.from_sympy` takes them. TypeError or ValueError for what cannot be."""
    import sympy

    places = _several("q", q)
    rates, t = _velocities(places, v, t)
    if len(rates) != len(places):
        raise ValueError(
            f"v must hold one velocity for each coordinate; received {len(rates)} for "
            f"{len(places)}. Give them in the order of q."
        )
    numbers = _numbers(parameters, sympy)
    given = [*places, *rates, *([] if t is None else [t]), *numbers]
    twice = sorted({str(x) for x in given if given.count(x) > 1})
    if twice:
        raise ValueError(
            f"coordinates, velocities, time and parameters must all differ; received "
            f"{', '.join(twice)} more than once. Rename one of them."
        )
    own = {
        kind: tuple(sympy.Symbol(f"{kind}{i}", real=True) for i in range(count))
        for kind, count in (("q", len(places)), ("v", len(rates)), ("c", len(numbers)))
    }
    time = sympy.Symbol("t", real=True)
    replaced = [dict(zip(rates, own["v"], strict=True)),
                {**dict(zip(places, own["q"], strict=True)),
                 **dict(zip(numbers, own["c"], strict=True))},
                {} if t is None else {t: time}]  # fmt: skip
    known = {*own["q"], *own["v"], *own["c"], time}

    def read(what: str, expression: Any) -> Any:
        found = _real_expression(what, expression, sympy)
        for step in replaced:
            found = found.xreplace(step)
        return _complete(what, found, known, words, sympy)

    words = {a: _name(x) for a, x in zip(own["q"], places, strict=True)}
    words |= {a: _name(x) for a, x in zip(own["v"], rates, strict=True)}
    words |= {a: str(x) for a, x in zip(own["c"], numbers, strict=True)}
    if t is not None:
        words[time] = str(t)
    forces = None
    if force is not None:
        rows = list(force) if isinstance(force, Iterable) else [force]
        if len(rows) != len(places):
            raise ValueError(
                f"force must hold one expression for each coordinate; received {len(rows)} for "
                f"{len(places)}."
            )
        forces = tuple(read("the force", row) for row in rows)
    return Expressions(
        read("the Lagrangian", L), forces, own["q"], own["v"], time, own["c"],
        tuple(numbers.values()), words,
    )  # fmt: skip


def in_words(expression: Any, words: Mapping[Any, str]) -> str:
    """Its symbols replaced by these names."""
    import sympy

    return str(expression.xreplace({own: sympy.Symbol(name) for own, name in words.items()}))


def _several(name: str, given: Any) -> list[Any]:
    from sympy import Derivative, Symbol
    from sympy.core.function import AppliedUndef

    found = list(given) if isinstance(given, Iterable) else [given]
    if not found or not all(isinstance(x, Symbol | AppliedUndef | Derivative) for x in found):
        raise TypeError(
            f"{name} must hold SymPy symbols, or functions of the time; received {given!r}."
        )
    return found


def _velocities(places: list[Any], v: Any, t: Any) -> tuple[list[Any], Any]:
    """Velocities, those of functions of the time by default, and the time, None where unknown."""
    from sympy import Symbol

    times = {x.args for x in places if not isinstance(x, Symbol)}
    if times:
        (when, *others) = times
        single = len(when) == 1 and isinstance(when[0], Symbol)
        if others or not single or (t is not None and t != when[0]):
            raise ValueError(
                f"coordinates must be functions of the time alone, the same for all; received "
                f"{', '.join(map(str, places))}" + (f" with t = {t}." if t is not None else ".")
            )
        t = when[0]
    if t is not None and not isinstance(t, Symbol):
        raise TypeError(f"t must be a SymPy symbol; received {t!r}.")
    if v is not None:
        return _several("v", v), t
    if any(isinstance(x, Symbol) for x in places):
        raise ValueError(
            f"v must hold the velocities where coordinates are no functions of the time; received "
            f"none, with q = {', '.join(map(str, places))}. Give a symbol for each."
        )
    return [x.diff(t) for x in places], t


def _numbers(parameters: Any, sympy: Any) -> dict[Any, float]:
    if parameters is not None and not isinstance(parameters, Mapping):
        raise TypeError(f"parameters must be a dict of symbols; received {parameters!r}.")
    given = dict(parameters or {})
    for symbol in given:
        if not isinstance(symbol, sympy.Symbol):
            raise TypeError(f"parameters must have SymPy symbols as keys; received {symbol!r}.")
    ordered = sorted(given, key=lambda symbol: (symbol.name, str(symbol.assumptions0)))
    plain = {x: float(y) if isinstance(y, sympy.Number) else y for x, y in given.items()}
    return {x: checks.real(f"parameter {x}", plain[x]) for x in ordered}


def _real_expression(what: str, expression: Any, sympy: Any) -> Any:
    if isinstance(expression, int | float):
        expression = sympy.sympify(expression)
    if not isinstance(expression, sympy.Expr):
        shape = getattr(expression, "shape", None)
        received = repr(expression) if shape is None else f"a matrix of shape {shape}"
        remedy = " Take its entry, L[0]." if shape == (1, 1) else ""
        raise TypeError(f"{what} must be a SymPy expression; received {received}.{remedy}")
    infinite = (sympy.I, sympy.zoo, sympy.oo, -sympy.oo, sympy.nan)
    if expression.has(*infinite):
        raise ValueError(f"{what} must be real and finite; received {expression}.")
    return expression


def _complete(what: str, found: Any, known: set[Any], words: Mapping[Any, str], sympy: Any) -> Any:
    """The same, if nothing is left to be done and every symbol is known."""
    from sympy.core.function import AppliedUndef

    left = found.atoms(
        sympy.Derivative, sympy.Integral, sympy.Sum, sympy.Product, sympy.Limit, sympy.Subs
    )
    if left:
        received = ", ".join(sorted(in_words(x, words) for x in left))
        raise ValueError(
            f"{what} must be an expression of q, v and t without derivatives, integrals or sums "
            f"left to do; received {received}. Call doit() on it, or replace velocities by those "
            f"in v."
        )
    unknown = sorted(map(str, found.free_symbols - known))
    if unknown:
        values = ", ".join(f"{name}: ..." for name in unknown)
        alike = " The symbol must be the same one, with the same assumptions."
        raise ValueError(
            f"{what} must hold q, v, t and symbols with a value alone; received "
            f"{', '.join(unknown)}. Give parameters={{{values}}}."
            + alike
            * bool({*unknown} & {*words.values()})
        )
    undefined = sorted(in_words(x, words) for x in found.atoms(AppliedUndef))
    if undefined:
        raise ValueError(
            f"{what} must be made of known functions; received {', '.join(undefined)}. Put its "
            f"formula in its place."
        )
    if found.has(sympy.I, sympy.zoo, sympy.oo, -sympy.oo, sympy.nan):
        raise ValueError(
            f"{what} must be real and finite for real coordinates; received "
            f"{in_words(found, words)}."
        )
    return found


def _name(x: Any) -> str:
    """x, or x' for a derivative."""
    from sympy import Derivative

    if isinstance(x, Derivative):
        return _name(x.expr) + "'" * sum(int(count) for _, count in x.variable_count)
    return str(getattr(x, "name", x)) if not hasattr(x, "func") or not x.args else x.func.__name__
