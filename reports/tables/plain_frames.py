"""A frame as plain values that JSON holds, and back: every number to the last bit, every type."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
import pandas as pd

TYPES = (bool, int, float, str)


def plain_frame(frame: pd.DataFrame) -> dict[str, Any]:
    """Name, type and values of each column. TypeError for a cell that is no number or text."""
    columns = [
        {"name": name, "type": str(frame[name].dtype), "values": [_plain(x) for x in frame[name]]}
        for name in frame
    ]
    return {"rows": len(frame), "columns": columns}


def framed(plain: Mapping[str, Any]) -> pd.DataFrame:
    """The frame, numbered from 0. ValueError when these are not the values of one."""
    try:
        index = pd.RangeIndex(plain["rows"])
        columns = {
            one["name"]: pd.Series(one["values"], index=index, dtype=one["type"])
            for one in plain["columns"]
        }
    except (KeyError, TypeError, AttributeError) as error:
        raise ValueError(f"it holds no frame ({type(error).__name__}: {error})") from None
    return pd.DataFrame(columns, index=index)


def _plain(value: Any) -> Any:
    if isinstance(value, np.generic):
        value = value.item()
    if value is not None and not isinstance(value, TYPES):
        raise TypeError(f"a cell holds a {type(value).__name__}")
    return value
