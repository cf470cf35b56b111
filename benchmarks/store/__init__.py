"""Tidy frames, files of rows, and the provenance of both."""
