"""Claims about Lie groups: L1 to L16."""
