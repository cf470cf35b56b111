"""Quadrature rules on [0, 1]; RULES names every family, each made from its number of points.

`composite` repeats one of them on equal pieces, and is no family of its own.
"""

from galvi.rules.clenshaw_curtis import clenshaw_curtis
from galvi.rules.gauss import gauss
from galvi.rules.lobatto import lobatto
from galvi.rules.newton_cotes import newton_cotes
from galvi.rules.radau import radau

RULES = (gauss, lobatto, clenshaw_curtis, radau, newton_cotes)
