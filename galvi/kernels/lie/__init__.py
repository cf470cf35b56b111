"""Rotations, rigid motions, charts and groups, as compiled functions."""
