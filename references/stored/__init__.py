"""Trajectories in extended precision, stored as files."""
