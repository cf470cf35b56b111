"""REBOUND's integrators."""
