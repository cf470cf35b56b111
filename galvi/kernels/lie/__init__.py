"""Compiled functions of rotations, rigid motions, charts and groups."""
