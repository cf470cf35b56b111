"""Potentials that references recognise by type and fields."""
