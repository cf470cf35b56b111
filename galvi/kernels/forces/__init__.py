"""Compiled forces, one law per module, as accelerations or as derivatives of a Lagrangian."""
