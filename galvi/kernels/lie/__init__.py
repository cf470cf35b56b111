"""Rotations, rigid motions, charts and the coadjoint action, as compiled functions."""
