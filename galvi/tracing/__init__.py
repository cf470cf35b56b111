"""Lagrangians and forces from SymPy expressions, compiled."""
