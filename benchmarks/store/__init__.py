"""Tidy tables, row files, the result cache and provenance."""
