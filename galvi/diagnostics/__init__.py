"""Diagnostics of a trajectory: invariants, balances, symplecticity, orbits, attitude."""
