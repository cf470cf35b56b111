"""Free functions on arrays, compiled; they import nothing of the rest of galvi."""
