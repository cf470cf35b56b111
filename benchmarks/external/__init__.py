"""Integrators from outside the project: loading, running and checking them."""
