"""Convergence fits, growth laws, rank tests, change points and timing."""
