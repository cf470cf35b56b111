"""What theory says of a space and a rule, and of a step on a problem, without running it."""
