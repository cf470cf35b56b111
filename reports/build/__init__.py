"""The commands `verify`, `compare`, `studies`, `warm` and `build`."""
