"""Quadrature rules on [0, 1]."""
