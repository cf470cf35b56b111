"""Trajectories in extended precision, kept as files."""
