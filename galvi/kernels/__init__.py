"""Compiled free functions on arrays, independent of the rest of galvi."""
