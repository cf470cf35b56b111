"""Lie groups as configuration spaces; `GROUPS` drives the tests."""

from galvi.groups.group import SE2, SE3, SO2, SO3, Rn
from galvi.groups.product import Product

GROUPS = (Rn(2), SO2(), SE2(), SO3(), SE3(), Product((SO3(), Rn(1), SO2())))
