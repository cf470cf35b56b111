"""Galerkin curves between the steps of a run."""
