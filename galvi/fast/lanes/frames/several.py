"""Lanes of several planets, in which each operation is done for all of them in turn.

A planet's motion is one long chain of operations that wait for each other; those of two planets run
in parallel.
"""

from __future__ import annotations


class Several:
    """Lanes of as many planets, with the arithmetic of `galvi.fast.lanes.values.Lane`."""

    def __init__(self, lanes):
        self.lanes = tuple(lanes)

    def _others(self, other):
        return other.lanes if isinstance(other, Several) else (other,) * len(self.lanes)

    def each(self, function, *others):
        """The function of each planet's lanes."""
        columns = (self._others(other) for other in others)
        return Several(function(*row) for row in zip(self.lanes, *columns, strict=True))

    def __add__(self, other):
        return self.each(lambda a, b: a + b, other)

    def __sub__(self, other):
        return self.each(lambda a, b: a - b, other)

    def __rsub__(self, other):
        return self.each(lambda a, b: b - a, other)

    def __mul__(self, other):
        return self.each(lambda a, b: a * b, other)

    def __neg__(self):
        return self.each(lambda a: -a)

    def __abs__(self):
        return self.each(abs)

    __radd__, __rmul__ = __add__, __mul__
