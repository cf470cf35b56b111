"""Performance over time: a history of benches, and two revisions side by side."""
