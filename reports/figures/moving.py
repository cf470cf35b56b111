"""Pictures that move: artists that are shown in one of several frames.

Only those of the last frame are visible, as in a PNG. In an animated SVG all are, each during its
frame, by SMIL, which browsers follow in images too; where it is not followed, the last is shown.
"""

from __future__ import annotations

import re
from collections.abc import Iterable

from matplotlib.artist import Artist
from matplotlib.figure import Figure

SECONDS = 0.25  # of a frame
GROUP = re.compile(rb'<g id="frame-(\d+)-of-(\d+)-\d+">')


def in_frame(artists: Iterable[Artist], frame: int, frames: int) -> None:
    """Show the artists in a frame only, counted from 0."""
    for k, artist in enumerate(artists):
        artist.set(gid=f"frame-{frame}-of-{frames}-{k}", visible=frame == frames - 1)


def show_all_frames(figure: Figure) -> None:
    """Make all frames visible, before an SVG is written that is then animated."""
    for artist in figure.findobj(lambda artist: (artist.get_gid() or "").startswith("frame-")):
        artist.set_visible(True)


def animated(svg: bytes) -> bytes:
    """The SVG with the times of its frames; the same bytes where there are none."""
    return GROUP.sub(_timed, svg)


def _timed(group: re.Match[bytes]) -> bytes:
    frame, frames = int(group[1]), int(group[2])
    begin, end = f"{frame / frames:.6f}", f"{(frame + 1) / frames:.6f}"
    visibility = "visible" if frame == frames - 1 else "hidden"
    animation = (
        f' visibility="{visibility}"><animate attributeName="visibility" calcMode="discrete" '
        f'dur="{frames * SECONDS:g}s" repeatCount="indefinite" keyTimes="0;{begin};{end}" '
        'values="hidden;visible;hidden"/>'
    )
    return group[0][:-1] + animation.encode()
