"""How the figures of claims are drawn."""
