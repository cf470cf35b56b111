"""Products of groups: charts, tangent maps, coordinates and momenta of all factors.

layout  (factors, 4 or 5)  for each factor the number of its group, its dimension, the number of
                      entries of an element, the number of leading components that are rotations,
                      and COUPLED
chart   number of a chart of rotations (galvi.kernels.lie.dispatch)
g       (r,)  an element, the entries of all factors; xi, eta (d,) in the algebra

For the functions of each factor see galvi.kernels.lie.groups.
"""

import numpy as np

from galvi.kernels.compile.jit import jit_inline, jit_noalloc
from galvi.kernels.lie import groups
from galvi.kernels.lie.dispatch import by_number, modules_of

GROUPS = modules_of(groups)
NUMBER, DIMENSION, ENTRIES, ROTATIONS = 0, 1, 2, 3
COUPLED = 4  # column in kernels of steps: factors that the mass couples have the same number

_position_scale = by_number("position_scale", GROUPS)


def over_factors(name, *arguments):
    """A kernel (layout, *arguments) that calls the function ``name`` of each factor's group with
    the factor's parts of the arguments.

    Parameters
    ----------
    arguments
        names of the arguments: with a final "*" for vectors (r,), without for vectors (d,); "chart"
        is passed on as it is
    """
    parts = ["row[NUMBER]"]
    for argument in arguments:
        first, size = ("first", "ENTRIES") if argument[-1] == "*" else ("start", "DIMENSION")
        part = f"{argument.rstrip('*')}[{first} : {first} + row[{size}]]"
        parts.append(argument if argument == "chart" else part)
    code = f"""
def {name}(layout, {", ".join(arguments).replace("*", "")}):
    first, start = 0, 0
    for factor in range(layout.shape[0]):
        row = layout[factor]
        of_group({", ".join(parts)})
        first, start = first + row[ENTRIES], start + row[DIMENSION]
"""
    # numba reads the source of a function in this file, from the line number of its code. The line
    # must begin a function, since Python 3.13 cannot read a block that begins within a string.
    code = "\n" * (over_factors.__code__.co_firstlineno - 2) + code
    names = {**globals(), "of_group": by_number(name, GROUPS)}
    exec(compile(code, __file__, "exec"), names)
    return jit_noalloc(names[name])


place = over_factors("place", "chart", "g*", "xi", "out*")
velocity = over_factors("velocity", "chart", "xi", "eta", "out")
rate = over_factors("rate", "chart", "xi", "v", "out")
momentum = over_factors("momentum", "chart", "xi", "mu", "out")
covector = over_factors("covector", "chart", "xi", "pi", "out")
momentum_slope = over_factors("momentum_slope", "chart", "xi", "eta", "mu", "out")
coadjoint_change = over_factors("coadjoint_change", "chart", "xi", "mu", "out")
coadjoint = over_factors("coadjoint", "chart", "xi", "mu", "out")
coordinates = over_factors("coordinates", "chart", "g*", "k*", "xi")
restore = over_factors("restore", "g*")
left_derivative = over_factors("left_derivative", "g*", "slope*", "out")
remember = over_factors("remember", "g*", "memory*")
advance = over_factors("advance", "chart", "xi", "g*", "memory*", "low*")
in_space = over_factors("in_space", "g*", "mu", "out")
# Groups on which Ad* = 1 do not use nu; low is then the low part of mu.
carry = over_factors("carry", "chart", "g*", "g1*", "xi", "kick", "mu", "nu", "low")


@jit_inline
def is_flat(layout):
    """Whether the group is R^n, where T = Ad* = 1."""
    return layout.shape[0] == 1 and layout[0, ROTATIONS] == 0


@jit_noalloc
def coadjoint_inverse(layout, chart, xi, mu, out):
    """out <- Ad*_{Phi(xi)^-1} mu: a body covector at g Phi(xi), in the frame of g."""
    coadjoint_change(layout, chart, xi, mu, out)
    for i in range(mu.size):
        out[i] += mu[i]


@jit_noalloc
def position_scale(layout, g, scale):
    """scale (d,) <- 1 for rotations; for positions the largest |coordinate| of the factor."""
    first, start = 0, 0
    for factor in range(layout.shape[0]):
        row = layout[factor]
        size = _position_scale(row[NUMBER], g[first : first + row[ENTRIES]])
        for i in range(row[DIMENSION]):
            scale[start + i] = 1.0 if i < row[ROTATIONS] else size
        first, start = first + row[ENTRIES], start + row[DIMENSION]


@jit_noalloc
def largest_rotation(layout, xi):
    """The largest |xi| of the rotations in xi (d,); 0 without rotations."""
    start, largest = 0, 0.0
    for factor in range(layout.shape[0]):
        size, square = 0.0, 0.0
        for i in range(start, start + layout[factor, ROTATIONS]):
            size = max(size, abs(xi[i]))
        for i in range(start, start + layout[factor, ROTATIONS]):
            square += (xi[i] / size) ** 2 if size > 0.0 else 0.0
        largest = max(largest, size * np.sqrt(square))
        start += layout[factor, DIMENSION]
    return largest
