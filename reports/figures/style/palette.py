"""Colours and markers shared by all figures."""

from __future__ import annotations

from matplotlib.colors import to_rgb

# Okabe and Ito (2008), without the yellow, which is too light for a white page.
COLOURS = ("#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9", "#222222")
MARKERS = ("o", "s", "^", "D", "v", "P", "X", "<", ">")
GUIDE = "#777777"  # claimed rates and other things that were not measured
SUN = "#E69F00"
BAND = "#eef3f7"


def darker(color: str) -> tuple[float, float, float]:
    """The same hue, darker: text needs more contrast with the page than lines do."""
    red, green, blue = (0.72 * part for part in to_rgb(color))
    return red, green, blue
