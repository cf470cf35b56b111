"""Forces that no potential has."""
