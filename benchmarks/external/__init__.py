"""Somebody else's integrators: loading, running and checking them."""
