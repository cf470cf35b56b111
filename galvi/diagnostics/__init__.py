"""What is computed from a trajectory: invariants, balances, symplecticity, orbits, attitude."""
