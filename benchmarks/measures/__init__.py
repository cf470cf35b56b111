"""Measures of a run: errors, invariants by independent formulas, symplecticity, actions."""
