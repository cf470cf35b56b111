"""Charts of groups; `CHARTS` drives the tests."""

from galvi.charts.chart import Cayley, Chart, Exponential, ModifiedRodrigues

CHARTS: tuple[Chart, ...] = (Cayley(), Exponential(), ModifiedRodrigues())
