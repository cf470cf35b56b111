"""Timings by pytest-benchmark: steps, trajectories and references."""
