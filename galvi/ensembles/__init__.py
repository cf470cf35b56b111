"""Many runs of one system, from arrays of starts and parameters."""
