"""Rank tests, change points, growth laws and timing."""
