"""Which figures there are."""
