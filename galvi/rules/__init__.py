"""Quadrature rules on [0, 1]; RULES names every family, each made from its number of points."""

from galvi.rules.clenshaw_curtis import clenshaw_curtis
from galvi.rules.gauss import gauss
from galvi.rules.lobatto import lobatto

RULES = (gauss, lobatto, clenshaw_curtis)
