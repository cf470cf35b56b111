"""Experiments that support choices in the solver and the suite, each a runnable module."""
