"""Tidy frames, row files, the result cache and provenance."""
