"""Quadrature rules on [0, 1]; RULES lists the families, functions of the number of points.

`composite` repeats a rule on equal pieces and is not a family of its own.
"""

from galvi.rules.rule import clenshaw_curtis, gauss, lobatto, newton_cotes, radau

RULES = (gauss, lobatto, clenshaw_curtis, radau, newton_cotes)
