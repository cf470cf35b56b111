"""The line of each chart in figures that compare contenders; dashes are for other codes."""

from __future__ import annotations

from typing import Any

from galvi.charts import CHARTS

LINES: tuple[tuple[str, Any], ...] = (
    ("solid", "-"),
    ("dash-dotted", (0, (6, 1.5, 1, 1.5))),
    ("dotted", (0, (1, 1.5))),
    ("dash-dot-dotted", (0, (6, 1.5, 1, 1.5, 1, 1.5))),
)
OF_CHART = {chart.name: LINES[k % len(LINES)] for k, chart in enumerate(CHARTS)}
LEGEND = "lines by chart: " + ", ".join(
    f"{words} {chart}" for chart, (words, _) in OF_CHART.items()
)


def chart_line(contender: str) -> Any:
    """Line style of the chart that ends the name of a method of galvi; solid without one."""
    chart = chart_of(contender)
    return OF_CHART[chart][1] if chart else "-"


def chart_of(contender: str) -> str:
    """The chart that ends the name of a method of galvi, or ""."""
    chart = contender.rpartition(", ")[2]
    return chart if chart in OF_CHART else ""
