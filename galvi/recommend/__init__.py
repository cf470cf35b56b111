"""Which method and which step for a given error."""
