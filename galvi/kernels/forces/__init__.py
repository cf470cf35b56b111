"""Compiled forces: one law each, as acceleration or as derivatives of a Lagrangian."""
