"""Which charts have a pole: coordinates that grow without bound towards their limit."""

from __future__ import annotations

from galvi.charts.chart import Chart


def has_pole(chart: Chart) -> bool:
    """Whether |xi| has a pole at the limit, as k tan(angle / k) has at k pi / 2, for k = 2 in
    Cayley's chart and k = 4 in modified Rodrigues parameters; |xi| = angle has none."""
    return chart.farthest > 2.0 * chart.limit
