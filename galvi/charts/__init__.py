"""Charts of groups; `CHARTS` drives the tests."""

from galvi.charts.cayley import Cayley
from galvi.charts.chart import Chart
from galvi.charts.exponential import Exponential
from galvi.charts.modified_rodrigues import ModifiedRodrigues

CHARTS: tuple[Chart, ...] = (Cayley(), Exponential(), ModifiedRodrigues())
