"""What is measured of a run: errors, fits, invariants by independent formulas."""
