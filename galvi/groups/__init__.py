"""Lie groups as configuration spaces; `GROUPS` drives the tests."""

from galvi.groups.product import Product
from galvi.groups.rn import Rn
from galvi.groups.se2 import SE2
from galvi.groups.se3 import SE3
from galvi.groups.so2 import SO2
from galvi.groups.so3 import SO3

GROUPS = (Rn(2), SO2(), SE2(), SO3(), SE3(), Product((SO3(), Rn(1), SO2())))
