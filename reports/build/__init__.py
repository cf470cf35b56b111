"""Verification, comparison and the page, put together."""
