"""Quadrature rules on [0, 1]; RULES lists the families, functions of the number of points.

`composite` repeats a rule on equal pieces and is not a family of its own.
"""

from galvi.rules.clenshaw_curtis import clenshaw_curtis
from galvi.rules.gauss import gauss
from galvi.rules.lobatto import lobatto
from galvi.rules.newton_cotes import newton_cotes
from galvi.rules.radau import radau

RULES = (gauss, lobatto, clenshaw_curtis, radau, newton_cotes)
