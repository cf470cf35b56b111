"""Colours and markers, the same for the same thing in every figure."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence

from matplotlib.colors import to_rgb

# Okabe and Ito (2008), without the yellow, which is too light for a white page.
COLOURS = ("#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9", "#222222")
MARKERS = ("o", "s", "^", "D", "v", "P", "X", "<", ">")
BLUES = ("#9CCBEA", "#4A9FD8", "#0072B2", "#003C66")
PEERS = ("#D55E00", "#009E73", "#CC79A7", "#E69F00", "#222222", "#7F7F7F", "#8C5A2B")
GUIDE = "#777777"  # claimed rates and other things that were not measured
SUN = "#E69F00"
BAND = "#eef3f7"


def looks(names: Iterable[str]) -> dict[str, dict[str, str]]:
    """A colour and a marker for each name: no two share both, for up to 63 names."""
    return {
        name: {"color": COLOURS[k % len(COLOURS)], "marker": MARKERS[k % len(MARKERS)]}
        for k, name in enumerate(dict.fromkeys(names))
    }


def contender_looks(names: Sequence[str], ours: Callable[[str], bool]) -> dict[str, dict[str, str]]:
    """Blues for galvi's methods, the other colours for peers; no two share colour and marker."""
    names = tuple(dict.fromkeys(names))
    found = {}
    for mine, colours in ((True, BLUES), (False, PEERS)):
        for k, name in enumerate(name for name in names if ours(name) is mine):
            marker = MARKERS[(k + 3 * (k // len(colours))) % len(MARKERS)]
            found[name] = {"color": colours[k % len(colours)], "marker": marker}
    return found


def darker(color: str) -> tuple[float, float, float]:
    """The same hue for words, which need more contrast with the page than lines do."""
    red, green, blue = (0.72 * part for part in to_rgb(color))
    return red, green, blue
