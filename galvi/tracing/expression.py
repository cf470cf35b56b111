"""Reads and checks a user's SymPy expressions, and writes them in real symbols."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Set
from dataclasses import dataclass
from typing import Any

from galvi import input_checks
from galvi.input_checks import shown


def in_words(expression: Any, readable: Mapping[Any, str]) -> str:
    """The expression as text, with its symbols replaced by the names in ``readable``."""
    import sympy

    return str(
        expression.xreplace({symbol: sympy.Symbol(name) for symbol, name in readable.items()})
    )


def real_expression(label: str, expression: Any) -> Any:
    """The expression, if it is a number converted to SymPy.

    Raises
    ------
    TypeError
        For a value that is neither a number nor a SymPy expression.
    ValueError
        For an expression with I, an infinity or NaN.
    """
    import sympy

    if isinstance(expression, int | float):
        expression = sympy.sympify(expression)
    if not isinstance(expression, sympy.Expr):
        shape = getattr(expression, "shape", None)
        received = repr(expression) if shape is None else f"a matrix of shape {shape}"
        remedy = " Take its entry, L[0]." if shape == (1, 1) else ""
        raise TypeError(f"{label} must be a SymPy expression; received {received}.{remedy}")
    infinite = (sympy.I, sympy.zoo, sympy.oo, -sympy.oo, sympy.nan)
    if expression.has(*infinite):
        raise ValueError(f"{label} must be real and finite; received {expression}.")
    return expression


def checked_expression(
    label: str, expression: Any, allowed: set[Any], readable: Mapping[Any, str], names: set[str]
) -> Any:
    """The expression itself.

    Parameters
    ----------
    allowed
        all symbols that it may contain
    readable
        symbol -> its name in the user's notation
    names
        names of the symbols given by the user; another symbol of such a name has different
        assumptions

    Raises
    ------
    ValueError
        For an unevaluated operation, an unknown symbol, an undefined function, or an expression
        with I, an infinity or NaN.
    """
    import sympy
    from sympy.core.function import AppliedUndef

    unevaluated = expression.atoms(
        sympy.Derivative, sympy.Integral, sympy.Sum, sympy.Product, sympy.Limit, sympy.Subs
    )
    if unevaluated:
        received = ", ".join(sorted(in_words(x, readable) for x in unevaluated))
        raise ValueError(
            f"{label} must be an expression of q, v and t without derivatives, integrals or sums "
            f"left to do; received {received}. Call doit() on it, or replace velocities by those "
            f"in v.{assumptions_remedy({*map(str, unevaluated)} & names)}"
        )
    unknown = {*map(str, expression.free_symbols - allowed)}
    if unknown:
        raise ValueError(
            f"{label} must hold nothing but q, v, t and parameters; received "
            f"{', '.join(sorted(unknown))}.{_give_remedy(unknown - names)}"
            f"{assumptions_remedy(unknown & names)}"
        )
    undefined = expression.atoms(AppliedUndef)
    if undefined:
        received = ", ".join(sorted(in_words(x, readable) for x in undefined))
        raise ValueError(
            f"{label} must be made of known functions; received {received}. Put its formula in its "
            f"place.{assumptions_remedy({*map(str, undefined)} & names)}"
        )
    if expression.has(sympy.I, sympy.zoo, sympy.oo, -sympy.oo, sympy.nan):
        raise ValueError(
            f"{label} must be real and finite for real coordinates; received "
            f"{in_words(expression, readable)}."
        )
    return expression


def _give_remedy(unknown: set[str]) -> str:
    """The remedy for symbols that were not given; '' for none."""
    if not unknown:
        return ""
    values = ", ".join(f"{name}: ..." for name in sorted(unknown))
    time = ", or t=t where it is the time" if "t" in unknown else ""
    return f" Give parameters={{{values}}}{time}."


def assumptions_remedy(names: set[str]) -> str:
    """The remedy for symbols of the same name with different assumptions; '' for no names."""
    if not names:
        return ""
    listed = ", ".join(sorted(names))
    return f" The given {listed} has other assumptions: use one symbol throughout."


@dataclass(frozen=True, eq=False)
class Expressions:
    """The user's expressions in real symbols q0, q1, ..., v0, ..., t and parameters c0, ...

    Attributes
    ----------
    L
        the Lagrangian
    forces
        (d,) generalised forces; None for none
    q, v : tuple, shape (d,)
        the symbols of the coordinates and velocities
    t
        the symbol of the time
    c
        the symbols of the parameters, sorted by the user's names
    values
        the values of the parameters
    readable
        symbol -> its name in the user's notation
    """

    L: Any
    forces: tuple[Any, ...] | None
    q: tuple[Any, ...]
    v: tuple[Any, ...]
    t: Any
    c: tuple[Any, ...]
    values: tuple[float, ...]
    readable: Mapping[Any, str]

    @property
    def places(self) -> dict[Any, str]:
        """Symbol -> its generated code, e.g. 'q[0]', for q, v and c; the code of t is its name."""
        named = (("q", self.q), ("v", self.v), ("c", self.c))
        return {x: f"{name}[{i}]" for name, symbols in named for i, x in enumerate(symbols)}

    @property
    def names(self) -> tuple[str, ...]:
        """The parameters in the user's notation."""
        return tuple(self.readable[x] for x in self.c)

    def text(self, expression: Any) -> str:
        """An expression in the user's notation."""
        return in_words(expression, self.readable)


def expressions(L: Any, q: Any, v: Any, t: Any, parameters: Any, force: Any) -> Expressions:
    """`Expressions` from the arguments of `galvi.Lagrangian.from_sympy`; raises TypeError or
    ValueError for unusable ones."""
    import sympy

    coordinates = _coordinate_symbols("q", q)
    velocities, t = _velocities(coordinates, v, t)
    if len(velocities) != len(coordinates):
        raise ValueError(
            f"v must hold one velocity for each coordinate; received {len(velocities)} for "
            f"{len(coordinates)}. Give them in the order of q."
        )
    numbers = _numbers(parameters, sympy)
    symbols = [*coordinates, *velocities, *([] if t is None else [t]), *numbers]
    repeated = sorted({str(x) for x in symbols if symbols.count(x) > 1})
    if repeated:
        raise ValueError(
            f"coordinates, velocities, time and parameters must all differ; received "
            f"{', '.join(repeated)} more than once. Rename one of them."
        )
    real_symbols = {
        kind: tuple(sympy.Symbol(f"{kind}{i}", real=True) for i in range(count))
        for kind, count in (("q", len(coordinates)), ("v", len(velocities)), ("c", len(numbers)))
    }
    time = sympy.Symbol("t", real=True)
    replacements = [
        dict(zip(velocities, real_symbols["v"], strict=True)),
        {
            **dict(zip(coordinates, real_symbols["q"], strict=True)),
            **dict(zip(numbers, real_symbols["c"], strict=True)),
        },
        {} if t is None else {t: time},
    ]
    allowed = {*real_symbols["q"], *real_symbols["v"], *real_symbols["c"], time}
    names = {str(x) for x in symbols}

    def read(label: str, expression: Any) -> Any:
        expression = real_expression(label, expression)
        for replacement in replacements:
            expression = expression.xreplace(replacement)
        return checked_expression(label, expression, allowed, readable, names)

    readable = {a: _name(x) for a, x in zip(real_symbols["q"], coordinates, strict=True)}
    readable |= {a: _name(x) for a, x in zip(real_symbols["v"], velocities, strict=True)}
    readable |= {a: str(x) for a, x in zip(real_symbols["c"], numbers, strict=True)}
    if t is not None:
        readable[time] = str(t)
    forces = None
    if force is not None:
        rows = _as_list("force", force)
        if len(rows) != len(coordinates):
            raise ValueError(
                f"force must hold one expression for each coordinate; received {len(rows)} for "
                f"{len(coordinates)}."
            )
        forces = tuple(read("the force", row) for row in rows)
    return Expressions(
        read("the Lagrangian", L),
        forces,
        real_symbols["q"],
        real_symbols["v"],
        time,
        real_symbols["c"],
        tuple(numbers.values()),
        readable,
    )


def _coordinate_symbols(name: str, symbols: Any) -> list[Any]:
    from sympy import Derivative, Symbol
    from sympy.core.function import AppliedUndef

    items = _as_list(name, symbols)
    if not items or not all(isinstance(x, Symbol | AppliedUndef | Derivative) for x in items):
        raise TypeError(
            f"{name} must hold SymPy symbols, or functions of the time such as theta(t); received "
            f"{symbols!r}."
        )
    return items


def _as_list(name: str, collection: Any) -> list[Any]:
    """The items of a list, tuple, array or matrix; a single item as a list of one."""
    import sympy

    if isinstance(collection, Set | Mapping | sympy.Set | sympy.Dict):
        raise TypeError(
            f"{name} must be a list, in the order of the coordinates; "
            f"received {shown(collection)}, which "
            f"has no order."
        )
    is_collection = isinstance(collection, Iterable | sympy.MatrixBase) and not isinstance(
        collection, str
    )
    return list(collection) if is_collection else [collection]


def _velocities(coordinates: list[Any], v: Any, t: Any) -> tuple[list[Any], Any]:
    """The velocities, by default the derivatives of functions of the time; and the symbol of the
    time, None if there is none."""
    from sympy import Symbol

    times = {x.args for x in coordinates if not isinstance(x, Symbol)}
    if times:
        (time_arguments, *other_times) = times
        is_one_symbol = len(time_arguments) == 1 and isinstance(time_arguments[0], Symbol)
        if other_times or not is_one_symbol or (t is not None and t != time_arguments[0]):
            raise ValueError(
                f"coordinates must be functions of the time alone, the same for all; received "
                f"{', '.join(map(str, coordinates))}"
                + (f" with t = {t}." if t is not None else ".")
                + assumptions_remedy({str(t)} & {str(x) for (x, *_) in times if t is not None})
            )
        t = time_arguments[0]
    if t is not None and not isinstance(t, Symbol):
        raise TypeError(f"t must be a SymPy symbol; received {t!r}.")
    if v is not None:
        return _coordinate_symbols("v", v), t
    if any(isinstance(x, Symbol) for x in coordinates):
        raise ValueError(
            f"v must hold the velocities where coordinates are no functions of the time; received "
            f"none, with q = {', '.join(map(str, coordinates))}. Give a symbol for each."
        )
    return [x.diff(t) for x in coordinates], t


def _numbers(parameters: Any, sympy: Any) -> dict[Any, float]:
    if parameters is not None and not isinstance(parameters, Mapping):
        raise TypeError(f"parameters must be a dict of symbols; received {shown(parameters)}.")
    numbers = dict(parameters or {})
    for symbol in numbers:
        if not isinstance(symbol, sympy.Symbol):
            raise TypeError(
                f"parameters must have SymPy symbols as keys; received {shown(symbol)}."
                + " Give the symbol, not its name." * isinstance(symbol, str)
            )
    ordered = sorted(numbers, key=lambda symbol: (symbol.name, str(symbol.assumptions0)))
    real_values = {
        x: float(y) if isinstance(y, sympy.Expr) and y.is_number and y.is_real else y
        for x, y in numbers.items()
    }
    return {x: input_checks.real(f"parameter {x}", real_values[x]) for x in ordered}


def _name(x: Any) -> str:
    """The name of x, with a prime for each derivative."""
    from sympy import Derivative

    if isinstance(x, Derivative):
        return _name(x.expr) + "'" * sum(int(count) for _, count in x.variable_count)
    return str(getattr(x, "name", x)) if not hasattr(x, "func") or not x.args else x.func.__name__
