"""A figure as data: which claims it may draw from, what draws it, what it says."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any


@dataclass(frozen=True)
class Figure:
    """One picture.

    name     of its files, e.g. "fig-2-03"
    title    what is shown, in one line
    draw     (axes, frame, **options)
    source   the paper's figure, as the claims name it, e.g. "H fig. 2.3"
    claims   ids of those whose frame it draws: the first of them that was measured
    options  what `draw` takes besides: quantities, labels, claimed rates
    caption  what the reader should see
    size     width and height in inches
    """

    name: str
    title: str
    draw: Callable[..., None]
    source: str = ""
    claims: tuple[str, ...] = ()
    options: Mapping[str, Any] = field(default_factory=dict)
    caption: str = ""
    size: tuple[float, float] = (6.4, 4.0)
