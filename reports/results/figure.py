"""A figure as data: its claims, its drawing function, its title and caption."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any


@dataclass(frozen=True)
class Figure:
    """One picture.

    name     base name of its files, e.g. "fig-2-03"
    title    one line
    draw     (axes, frame, **options)
    source   the paper's figure, e.g. "H fig. 2.3"
    claims   ids of claims; the frame of the first that was measured is drawn
    options  further arguments of `draw`: quantities, labels, claimed rates
    caption  explanation for the reader
    size     width and height in inches, where there is room
    least    inches, below which it cannot be read and is not drawn
    """

    name: str
    title: str
    draw: Callable[..., None]
    source: str = ""
    claims: tuple[str, ...] = ()
    options: Mapping[str, Any] = field(default_factory=dict)
    caption: str = ""
    size: tuple[float, float] = (6.4, 4.0)
    least: float = 0.0
