"""Moving pictures: artists that are shown in one of several frames.

A PNG shows the artists of the last frame. An animated SVG holds those of all frames, each of them
visible during its frame, by SMIL, which browsers support in images, too; without that support the
last frame is shown.
"""

from __future__ import annotations

import re
from collections.abc import Iterable

from matplotlib.artist import Artist
from matplotlib.figure import Figure

FRAME_SECONDS = 0.25  # duration of a frame
FRAME_GROUP = re.compile(rb'<g id="frame-(\d+)-of-(\d+)-\d+">')


def in_frame(artists: Iterable[Artist], frame: int, frames: int) -> None:
    """Assign the artists to a frame, counted from 0; only those of the last frame stay visible."""
    for k, artist in enumerate(artists):
        artist.set(gid=f"frame-{frame}-of-{frames}-{k}", visible=frame == frames - 1)


def show_all_frames(figure: Figure) -> None:
    """Make the artists of all frames visible, so that an SVG that is written next has them all."""
    for artist in figure.findobj(lambda artist: (artist.get_gid() or "").startswith("frame-")):
        artist.set_visible(True)


def animated(svg: bytes) -> bytes:
    """The SVG with an animation for each frame; unchanged where it has no frames."""
    return FRAME_GROUP.sub(_with_animation, svg)


def _with_animation(group: re.Match[bytes]) -> bytes:
    frame, frames = int(group[1]), int(group[2])
    start_time, end_time = f"{frame / frames:.6f}", f"{(frame + 1) / frames:.6f}"
    visibility = "visible" if frame == frames - 1 else "hidden"
    animation = (
        f' visibility="{visibility}"><animate attributeName="visibility" calcMode="discrete" '
        f'dur="{frames * FRAME_SECONDS:g}s" repeatCount="indefinite" '
        f'keyTimes="0;{start_time};{end_time}" '
        'values="hidden;visible;hidden"/>'
    )
    return group[0][:-1] + animation.encode()
