"""Charts and groups by number: one compiled kernel serves all of them.

A chart, or a group, is a module with functions of the same names; its number is its place among the
modules of its folder. Nothing else chooses between them.
"""

from __future__ import annotations

from importlib import import_module
from pkgutil import iter_modules

from galvi.kernels.lie.arithmetic import generic


def modules_of(package):
    """The modules of a package, in the order of their names."""
    names = sorted(module.name for module in iter_modules(package.__path__))
    return tuple(import_module(f"{package.__name__}.{name}") for name in names)


def by_number(name, modules):
    """A function (number, ...) that calls ``name`` of the module with that number."""
    chosen = None
    for number, module in reversed(list(enumerate(modules))):
        chosen = _choice(number, getattr(module, name), chosen)
    return chosen


def _choice(own, function, others):
    """``function`` for the number ``own``, and what ``others`` chooses for a larger one."""
    if others is None:

        @generic
        def choose(number, *arguments):
            return function(*arguments)

    else:

        @generic
        def choose(number, *arguments):
            if number == own:
                return function(*arguments)
            return others(number, *arguments)

    return choose
