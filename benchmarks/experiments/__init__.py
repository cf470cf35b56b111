"""Experiments behind choices in the solver, each a runnable module."""
