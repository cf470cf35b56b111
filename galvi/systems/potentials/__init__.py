"""Potentials as values with readable fields."""
