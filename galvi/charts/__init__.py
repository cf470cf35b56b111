"""Charts of groups; `CHARTS` drives the tests."""

from galvi.charts.cayley import Cayley
from galvi.charts.exponential import Exponential

CHARTS = (Cayley(), Exponential())
