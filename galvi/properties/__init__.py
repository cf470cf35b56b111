"""What a space and a rule make of a method: exactness, order, symmetry, classical name."""
