"""The functions of a product of groups in one chart, for lanes or numbers."""

from __future__ import annotations

from galvi.kernels.lanes.law_pass import is_zero
from galvi.kernels.lie.product import DIMENSION, ENTRIES, GROUPS, NUMBER, ROTATIONS


class Chart:
    """layout  rows of numbers, see galvi.kernels.lie.product"""

    def __init__(self, layout, chart):
        self.number, self.factors, start, first = chart, [], 0, 0
        for row in layout:
            here = slice(start, start + row[DIMENSION])
            entries = slice(first, first + row[ENTRIES])
            self.factors.append((GROUPS[row[NUMBER]], here, entries, row[ROTATIONS]))
            start, first = here.stop, first + row[ENTRIES]
        self.dimension, self.entries = start, first

    def place(self, g, xi):
        """The entries of g Phi(xi)."""
        found = []
        for group, own, entries, _ in self.factors:
            out = [None] * (entries.stop - entries.start)
            group.place(self.number, g[entries], xi[own], out)
            found += out
        return found

    def left_derivative(self, g, slope):
        """The derivatives along g hat(e_a) of a function with Euclidean derivative slope."""
        found = []
        for group, own, entries, _ in self.factors:
            out = [0.0] * (own.stop - own.start)
            group.left_derivative(g[entries], slope[entries], out)
            found += out
        return found

    def apply(self, name, xi, *vectors):
        """A function of galvi.kernels.lie.groups with d results; 0.0 where it is of zeros alone."""
        found = []
        for group, own, _, _ in self.factors:
            parts = [list(vector[own]) for vector in vectors]
            out = [0.0] * len(xi[own])
            if not all(is_zero(x) for x in parts[-1]):
                getattr(group, name)(self.number, xi[own], *parts, out)
            found += out
        return found


def total(x, y):
    """x + y, and one of them where the other is the number 0."""
    return y if is_zero(x) else (x if is_zero(y) else x + y)
