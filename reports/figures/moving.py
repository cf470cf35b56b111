"""Pictures that move: artists that are shown in one of several frames.

In the SVG each such artist is visible during its frame, by SMIL, which browsers follow in images
too; where it is not followed, and in the PNG, the last frame is shown.
"""

from __future__ import annotations

import itertools
import re

from matplotlib.artist import Artist
from matplotlib.figure import Figure

SECONDS = 0.25  # of a frame
NAME = re.compile(r"frame-(\d+)-of-(\d+)-")
GROUP = re.compile(rb'<g id="frame-(\d+)-of-(\d+)-\d+">')


def in_frame(artist: Artist, frame: int, frames: int) -> None:
    """Show the artist in a frame only, counted from 0."""
    known = len(_moving(artist.get_figure(root=True)))
    artist.set_gid(f"frame-{frame}-of-{frames}-{known}")


def _moving(figure: Figure) -> list[Artist]:
    return [one for one in figure.findobj() if NAME.match(one.get_gid() or "")]


def hide_all_but_last(figure: Figure) -> None:
    """Before the PNG is written."""
    for artist in _moving(figure):
        found = NAME.match(artist.get_gid() or "")
        artist.set_visible(int(found[1]) == int(found[2]) - 1)


def animated(svg: bytes) -> bytes:
    """The SVG with the times of its frames; the same bytes where there are none."""
    return GROUP.sub(_timed, svg)


def _timed(group: re.Match[bytes]) -> bytes:
    frame, frames = int(group[1]), int(group[2])
    edges = [0.0, frame / frames, (frame + 1) / frames]
    values = ["hidden", "visible", "hidden"]
    if frame == 0:
        edges, values = [0.0, edges[2]], values[1:]
    if frame == frames - 1:
        edges, values = edges[: len(edges) - 1], values[: len(values) - 1]
    kept = [edge for edge, _ in itertools.groupby(edges)]
    times = ";".join(f"{edge:.6f}" for edge in kept)
    last = b"visible" if frame == frames - 1 else b"hidden"
    animation = (
        f'<animate attributeName="visibility" calcMode="discrete" dur="{frames * SECONDS:g}s" '
        f'repeatCount="indefinite" keyTimes="{times}" values="{";".join(values)}"/>'
    )
    return group[0][:-1] + b' visibility="' + last + b'">' + animation.encode()
