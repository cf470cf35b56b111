"""Selection of charts and groups by number, so that one compiled kernel serves all of them.

A chart or a group is a module with functions of fixed names; its number is its index among the
modules of its package in alphabetical order. Only this module branches on charts or groups.
galvi.kernels.lie.charts and galvi.kernels.lie.groups describe the functions.
"""

from importlib import import_module
from pkgutil import iter_modules

from galvi.kernels.lie import charts
from galvi.kernels.lie.arithmetic import generic


def modules_of(package):
    """The modules of a package in alphabetical order."""
    names = sorted(module.name for module in iter_modules(package.__path__))
    return tuple(import_module(f"{package.__name__}.{name}") for name in names)


def by_number(name, modules):
    """A function (number, ...) that calls ``name`` of the module with that number."""
    *leading, last = range(len(modules))
    lines = [f"def {name}_by_number(number, *arguments):"]
    for k in leading:
        lines += [f"    if number == {k}:", f"        return function_{k}(*arguments)"]
    lines += [f"    return function_{last}(*arguments)"]
    names = {f"function_{k}": getattr(module, name) for k, module in enumerate(modules)}
    names["__name__"] = __name__
    exec(compile("\n".join(lines), f"<{name} by number, of {__name__}>", "exec"), names)
    return generic(names[f"{name}_by_number"])


CHARTS = modules_of(charts)

rotation_radial = by_number("rotation", CHARTS)
tangent_radial = by_number("tangent", CHARTS)
inverse_radial = by_number("inverse", CHARTS)
translation_radial = by_number("translation", CHARTS)
half_turn = by_number("half_turn", CHARTS)
from_quaternion = by_number("from_quaternion", CHARTS)
angle_of = by_number("angle", CHARTS)
coordinate_of = by_number("coordinate", CHARTS)
LARGEST_ROTATIONS_IN_LANES = tuple(chart.LARGEST_IN_LANES for chart in CHARTS)
